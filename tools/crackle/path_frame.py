# SPDX-License-Identifier: GPL-3.0-or-later
"""Crack paths as numbers: offsets from a common curve. Polylines are n x 2, y and z [m]."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Iterable, Optional, Sequence

import numpy as np
from scipy import signal

N_STATIONS = 50
N_COARSE = 21  # points at which curves are compared with each other
USUAL_SHARE = 0.9  # the medoid is among curves of at least this share of the median length
CHORD_SHARE = 0.1  # normals are those of chords over this share of the curve
LEAST_ALONG = 0.5  # a path runs along a curve if what lies beside it is at least this share of its own length
STEPS_PER_CORRELATION, MOST_STEPS = 2.0, 1000.0  # of a reading error


def arc_lengths(line: np.ndarray) -> np.ndarray:
    """Of each point, from 0."""
    return np.append(0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))


def length_of(line: np.ndarray) -> float:
    return float(arc_lengths(line)[-1])


def point_at(line: np.ndarray, at: np.ndarray | float) -> np.ndarray:
    """Places at these arc lengths, n x 2."""
    along = arc_lengths(line)
    return np.stack([np.interp(at, along, line[:, i]) for i in (0, 1)], axis=-1)


def resampled(line: np.ndarray, n: int = N_COARSE) -> np.ndarray:
    """n points at equal steps."""
    return point_at(line, length_of(line) * np.arange(n) / (n - 1))


def project(line: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of each point (n x 2) the arc length of the nearest point of the line, and the distance to it."""
    (y, z), (along_y, along_z) = line[:-1].T, np.diff(line, axis=0).T
    square = along_y ** 2 + along_z ** 2
    to_y, to_z = points[:, :1] - y, points[:, 1:] - z
    share = np.clip((to_y * along_y + to_z * along_z) / np.where(square > 0, square, np.inf), 0, 1)
    distance = (to_y - share * along_y) ** 2 + (to_z - share * along_z) ** 2
    nearest = distance.argmin(axis=1)
    rows = np.arange(len(points))
    return arc_lengths(line)[nearest] + share[rows, nearest] * np.sqrt(square[nearest]), np.sqrt(distance[rows, nearest])


def unit(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)


def left_of(vectors: np.ndarray) -> np.ndarray:
    return np.stack([-vectors[..., 1], vectors[..., 0]], axis=-1)


def extended(line: np.ndarray, length: float) -> np.ndarray:
    """The line with its ends drawn out straight, each by this length."""
    return np.vstack([line[0] + length * unit(line[0] - line[1]), line, line[-1] + length * unit(line[-1] - line[-2])])


def chords(line: np.ndarray, at: np.ndarray, half: float) -> np.ndarray:
    """Unit vectors along the line at these arc lengths."""
    return unit(point_at(line, np.minimum(at + half, length_of(line))) - point_at(line, np.maximum(at - half, 0.0)))


def with_reading_error(line: np.ndarray, deviation: float, correlation: float, random: np.random.Generator) -> np.ndarray:
    """The line as read off with an error: shifted along its normals by a Gaussian process whose correlation falls exponentially
    with the arc length."""
    if not deviation > 0:
        return line
    length = length_of(line)
    wanted = STEPS_PER_CORRELATION * length / correlation if correlation > 0 else 0.0
    n_steps = int(np.clip(np.ceil(wanted), N_COARSE, MOST_STEPS))
    step = length / n_steps
    memory = np.exp(-step / correlation) if correlation > 0 else 0.0
    drawn = deviation * random.standard_normal(n_steps + 1)
    drawn[1:] *= np.sqrt(1 - memory ** 2)
    error = signal.lfilter([1], [1, -memory], drawn)
    at = step * np.arange(n_steps + 1)
    return point_at(line, at) + error[:, None] * left_of(chords(line, at, step))


class Gaps:
    """Distances between curves: of the N_COARSE points of each from each other curve. What has been found for a curve is kept by
    its identity."""

    def __init__(self) -> None:
        self._curves: list[np.ndarray] = []  # kept, so that their identities stay their own
        self._number: dict[int, int] = {}
        self._coarse = np.zeros((0, N_COARSE, 2))
        self._known = np.zeros((0, 0, N_COARSE))

    def between(self, curves: Sequence[np.ndarray]) -> np.ndarray:
        """n x n x N_COARSE: of the points of curve i from curve k [m]."""
        new = [*{id(curve): curve for curve in curves if id(curve) not in self._number}.values()]
        for curve in new:
            self._number.setdefault(id(curve), len(self._number))
        if new:
            n = len(self._curves)
            self._curves += new
            self._coarse = np.concatenate([self._coarse, [resampled(curve) for curve in new]])
            known = np.full((len(self._curves),) * 2 + (N_COARSE,), np.nan)
            known[:n, :n] = self._known
            self._known = known
        number = np.array([self._number[id(curve)] for curve in curves])
        for k in number:
            if (lacking := number[np.isnan(self._known[number, k, 0])]).size:
                distance = project(self._coarse[k], self._coarse[lacking].reshape(-1, 2))[1]
                self._known[lacking, k] = distance.reshape(-1, N_COARSE)
        return self._known[np.ix_(number, number)]


@dataclass
class PathFrame:
    """Stations on a curve amid all others, with normals whose mean is along +y or +z, whichever is nearer."""
    curve: np.ndarray
    place: np.ndarray  # N_STATIONS x 2
    normal: np.ndarray  # likewise
    is_along_y: bool


@dataclass(frozen=True)
class Window:
    """The part of a crack that was in sight."""
    first: np.ndarray
    last: np.ndarray
    arrested: bool = False  # the crack ended at `last`, and more would have been seen


def medoid_of(curves: Sequence[np.ndarray], gaps: Gaps) -> np.ndarray:
    """The curve with the smallest mean distance to the others, among those of nearly the usual length or more."""
    mean = gaps.between(curves).mean(axis=2)
    lengths = np.array([length_of(curve) for curve in curves])
    usual = USUAL_SHARE * np.sort(lengths)[len(lengths) // 2]
    return curves[int(np.where(lengths >= usual, (mean + mean.T).sum(axis=1), np.inf).argmin())]


def runs_along(curve: np.ndarray, first: np.ndarray, last: np.ndarray) -> bool:
    """Whether what lies beside a path on the curve is at least half as long as the distance between its ends, or as the curve."""
    at = project(curve, np.array([first, last]))[0]
    return bool(abs(at[1] - at[0]) >= LEAST_ALONG * min(np.linalg.norm(last - first), length_of(curve)))


def path_frame(curves: Sequence[np.ndarray], windows: Iterable[Window], gaps: Optional[Gaps] = None) -> Optional[PathFrame]:
    """Stations on the medoid of the curves, in what all windows show; windows of paths that do not run along it do not count.
    None where the windows leave nothing of it."""
    medoid = medoid_of(curves, gaps or Gaps())
    length = length_of(medoid)
    start, end = 0.0, length
    for window in windows:
        if not runs_along(medoid, window.first, window.last):
            continue
        first, last = project(medoid, np.array([window.first, window.last]))[0]
        start = max(start, first if first <= last else 0.0 if window.arrested else last)
        end = min(end, first if first > last else length if window.arrested else last)
    if not end > start:
        return None
    at = start + (end - start) * (np.arange(N_STATIONS) + 0.5) / N_STATIONS
    normal = left_of(chords(medoid, at, CHORD_SHARE * length / 2))
    total = normal.sum(axis=0)
    is_along_y = bool(abs(total[0]) >= abs(total[1]))
    return PathFrame(medoid, point_at(medoid, at), -normal if total[0 if is_along_y else 1] < 0 else normal, is_along_y)


def offsets(frame: PathFrame, curve: Optional[np.ndarray]) -> np.ndarray:
    """Along the normal at each station [m], to the nearest intersection; NaN where there is none within the length of the frame's
    curve, and everywhere if the curve does not run along that of the frame."""
    if curve is None or not runs_along(frame.curve, curve[0], curve[-1]):
        return np.full(len(frame.place), np.nan)
    to = curve - frame.place[:, None]
    along = (to * left_of(frame.normal)[:, None]).sum(axis=2)
    off = (to * frame.normal[:, None]).sum(axis=2)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = along[:, :-1] / (along[:, :-1] - along[:, 1:])
        found = (1 - share) * off[:, :-1] + share * off[:, 1:]
    found = np.where((along[:, :-1] < 0) == (along[:, 1:] < 0), np.inf, found)
    nearest = found[np.arange(len(found)), np.abs(found).argmin(axis=1)]
    return np.where(np.abs(nearest) <= length_of(frame.curve), nearest, np.nan)
