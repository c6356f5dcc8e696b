# SPDX-License-Identifier: GPL-3.0-or-later
"""How the cracks of one sample ran: when they crossed which part of their ligament, from the facets that opened."""
from __future__ import annotations

import math
from pathlib import Path

import h5py
import numpy as np

from crackle_report.plate import Plate

# As in the program's patterns (crack_path.h).
STATIONS = 50
THICKNESS_SHARE = 0.3
BINS = 200  # across the thickness
STARTED = 0.06  # share of the ligament that a crack has crossed when it counts as started: some 1 mm
FAR = 0.8  # that the first crack has crossed when the other one is looked at

FIELDS = ("start_0", "start_1", "reach_0", "reach_1", "other_when_far", "kinks_0", "kinks_1", "bend_0", "bend_1", "turned",
          "forces", "long_forks", "fork_time", "fork_place", "fork_angle", "fork_speed")
LONG_ARM = 2e-3  # [m]
FRONT_WINDOW = 3e-3  # [m] before a fork, in which the crack's speed is measured: six or seven stations


def read(sample: Path, plate: Plate) -> dict[str, float]:
    """FIELDS of a sample's file.

    Of each notch: `start` is the time at which its crack has crossed STARTED of the ligament [s], since the onset of the
    last dynamic phase (0 if before it), or since the load began to grow where the body was at rest; `reach` the share
    that it has crossed at the end; `kinks` and `bend` [rad] those of its crack line. `other_when_far` is what the other
    crack has crossed when the first one has crossed FAR. `turned` is 1 where the mesh is turned by 180 degrees against
    the base, `forces` counts evaluations of the force, and `long_forks` the forks in the projection whose arms are LONG_ARM or
    more, whatever the spacing. Of the first fork in the projection: `fork_time` since the onset [s], `fork_place` from its
    notch's tip along the ligament [m], `fork_angle` between its arms [rad], `fork_speed` of the crack before it, over
    Rayleigh's. What did not happen is NaN.
    """
    with h5py.File(sample) as root:
        lines = {name: column[...] for name, column in root["crack_lines/lines"].items()}
        crack, time = root["crack_surface/crack"][...], root["crack_surface/time"][...]
        corners, notch_of = root["crack_surface/corners"][...], root["crack_surface/cracks/notch"][...]
        result = {"turned": float((int(root["mesh"].attrs.get("reflected_axes", 0)) & 4) != 0),
                  "forces": float(root["counts/force_evaluations"][()]),
                  "long_forks": _long_forks(root) if "forks" in root else math.nan}
        shares = []
        for notch in range(2):
            mine = notch_of[crack] == notch
            y = _advance(plate, notch, corners[mine][:, :, 1]) / plate.ligament(notch)
            shares.append(arrivals(corners[mine][:, :, 0] / plate.size[0], y, time[mine]))
        result |= _first_fork(root, plate, shares)
    for notch, arrival in enumerate(shares):
        result[f"start_{notch}"] = float(np.maximum(0.0, time_of(arrival, STARTED)))  # NaN stays
        result[f"reach_{notch}"] = reach_at(arrival, math.inf)
        root_lines = (lines["notch"] == notch) & (lines["parent"] < 0)
        result[f"kinks_{notch}"] = float(lines["kinks"][lines["notch"] == notch].sum())
        result[f"bend_{notch}"] = float(lines["bend"][root_lines].sum()) if root_lines.any() else math.nan
    far = [time_of(arrival, FAR) for arrival in shares]
    first = int(np.argmin(np.nan_to_num(far, nan=math.inf)))
    result["other_when_far"] = math.nan if math.isnan(far[first]) else reach_at(shares[1 - first], far[first])
    return result


def _long_forks(root: h5py.File) -> float:
    forks = root["forks"]
    return float(np.count_nonzero((forks["in_projection"][...] == 1) & (forks["length"][...] >= LONG_ARM)))


def _advance(plate: Plate, notch: int, y: np.ndarray) -> np.ndarray:
    """From a notch's tip along its ligament [m]."""
    return plate.notch_direction[notch] * (y - plate.notch_tip[notch, 0])


def _first_fork(root: h5py.File, plate: Plate, shares: list[np.ndarray]) -> dict[str, float]:
    """The fields of the first fork.

    @param shares of each notch, when its crack arrived at each station
    """
    seen = np.flatnonzero(root["forks/in_projection"][...] == 1) if "forks" in root else np.empty(0, int)
    if seen.size == 0:
        return dict.fromkeys(("fork_time", "fork_place", "fork_angle", "fork_speed"), math.nan)
    forks = {name: root[f"forks/{name}"][...] for name in ("time", "position", "angle", "notch")}
    first = seen[np.argmin(forks["time"][seen])]
    notch = int(forks["notch"][first])
    place = float(_advance(plate, notch, forks["position"][first, 0]))
    rayleigh = root["summary/crack_speed_max"][()] / root["summary/crack_speed_ratio"][()]
    return {"fork_time": float(forks["time"][first]), "fork_place": place, "fork_angle": float(forks["angle"][first]),
            "fork_speed": float(speed_before(shares[notch], plate.ligament(notch), place) / rayleigh)}


def arrivals(x: np.ndarray, y: np.ndarray, time: np.ndarray) -> np.ndarray:
    """When the facets of a notch's cracks first cover THICKNESS_SHARE of the thickness at each station; inf where never.

    Stray facets count too, unlike in the program, which asks that they lie beside each other.

    @param x, y facets x corners, in thicknesses from x = 0 and in ligaments from the tip
    @param time of each facet's opening
    """
    first_time = np.full((STATIONS, BINS), np.inf)
    place = y * STATIONS - 0.5  # station i is at i
    low, high = np.ceil(place.min(axis=1)).astype(int), np.floor(place.max(axis=1)).astype(int)
    for offset in range(max(0, int((high - low).max(initial=-1)) + 1)):
        station = low + offset
        met = np.flatnonzero((station <= high) & (station >= 0) & (station < STATIONS))
        # Each facet is met in a segment between two of its edges.
        here = place[met] - station[met, None]
        there, x_there = np.roll(here, -1, axis=1), np.roll(x[met], -1, axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            cut = np.where((here <= 0) != (there <= 0), x[met] + (x_there - x[met]) * here / (here - there), np.nan)
        crossed = np.isfinite(cut).any(axis=1)
        begin, end = np.nanmin(cut[crossed], axis=1) * BINS, np.nanmax(cut[crossed], axis=1) * BINS
        begin, end = (np.clip(np.round(edge).astype(int), 0, BINS) for edge in (begin, end))
        count = end - begin
        facet = np.repeat(np.flatnonzero(crossed), count)
        bins = np.arange(count.sum()) - np.repeat(count.cumsum() - count, count) + np.repeat(begin, count)
        np.minimum.at(first_time, (station[met][facet], bins), time[met][facet])
    return np.sort(first_time, axis=1)[:, math.ceil(THICKNESS_SHARE * BINS) - 1]


def reach_at(arrival: np.ndarray, time: float) -> float:
    """Share of the ligament up to the farthest station that was crossed by then, as the program counts it."""
    crossed = np.flatnonzero(np.isfinite(arrival) & (arrival <= time))
    return (crossed[-1] + 1) / STATIONS if crossed.size else 0.0


def time_of(arrival: np.ndarray, share: float) -> float:
    """When a crack had crossed this share; NaN if it never had."""
    time = arrival[math.ceil(share * STATIONS - 1e-9) - 1:].min()
    return float(time) if math.isfinite(time) else math.nan


def speed_before(arrival: np.ndarray, ligament: float, place: float) -> float:
    """Speed of a crack's front in FRONT_WINDOW before a place on its ligament [m/s]: slope of a line through its arrivals, each
    station's no later than the next one's; NaN where fewer than four stations are left.
    """
    station = (np.arange(STATIONS) + 0.5) * ligament / STATIONS
    passed = np.minimum.accumulate(arrival[::-1])[::-1]
    here = (station > place - FRONT_WINDOW) & (station <= place) & np.isfinite(passed)
    slope = np.polyfit(station[here], passed[here], 1)[0] if here.sum() >= 4 else math.nan
    return 1 / slope if slope > 0 else math.nan
