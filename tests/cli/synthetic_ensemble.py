#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes an output folder as `crackle run` leaves it, with invented cracks: for the report's tests, and to
look at the pictures of an ensemble of any size without computing one."""
from __future__ import annotations

import argparse
from pathlib import Path

import h5py
import numpy as np

from box_mesh import box_mesh

INPUT = """\
[ensemble]
samples = {samples}
seed = 2012

[specimen]
size = ["5 mm", "2.45 cm", "140 mm"]
[[specimen.notch]]
face = "y-min"
at = "65 mm"
depth = "6 mm"
height = "0.6 mm"
[[specimen.notch]]
face = "y-max"
at = "75 mm"
depth = "6 mm"
height = "0.6 mm"

[sections]
y = ["7 mm", "9 mm", "12.25 mm", "15.5 mm", "17.5 mm"]
"""
THICKNESS, WIDTH = 5e-3, 24.5e-3
SECTIONS = np.array([7, 9, 12.25, 15.5, 17.5]) * 1e-3
TIPS = ((6e-3, 65e-3, 1), (WIDTH - 6e-3, 75e-3, -1))  # y, z, direction of growth along y
N_PATTERNS = 4


def write_ensemble(folder: Path, n_samples: int, failed: tuple[int, ...] = (), pending: tuple[int, ...] = (),
                   with_ensemble_file: bool = True) -> list[dict]:
    """Writes the folder and returns the samples' rows."""
    (folder / "samples").mkdir(parents=True, exist_ok=True)
    text = INPUT.format(samples=n_samples)
    rows = []
    for i in range(n_samples):
        rows.append(_make_sample(i))
        if i in pending:
            rows[i] = _empty_row(0, "")
            continue
        if i in failed:
            rows[i] = _empty_row(2, "static solve diverged after 500 iterations (residual 3.1e-2 of the load)")
        _write_sample(folder / "samples" / f"{i:04d}.h5", i, rows[i], text)
    if with_ensemble_file:
        _write_ensemble_file(folder / "ensemble.h5", rows, text)
    return rows


def _empty_row(status: int, error: str) -> dict:
    shape = (len(TIPS), SECTIONS.size)
    return {"status": status, "error": error, "onset_force": np.nan, "onset_time": np.nan, "outcome": 0,
            "pattern": 0, "overlap": np.nan, "bifurcations": 0, "kinks": 0, "crack_area": np.nan, "crack_speed_max": np.nan, "crack_speed_ratio": np.nan, "effective_toughness": np.nan, "energy_error": np.nan,
            "z": np.full(shape, np.nan), "z_spread": np.full(shape, np.nan),
            "branches": np.zeros(shape, int), "facets": [], "lines": []}


def _make_sample(number: int) -> dict:
    random = np.random.Generator(np.random.PCG64([2012, number]))
    row = _empty_row(1, "")
    pattern = int(random.choice([1, 2, 2, 3]))
    reach = {1: (18e-3, 2e-3), 2: (13e-3, 12e-3), 3: (5e-3, 3e-3)}[pattern]
    if random.random() < 0.5:
        reach = reach[::-1]
    facets = []  # corners, time, notch
    for notch, (tip_y, tip_z, direction) in enumerate(TIPS):
        y = np.arange(0, reach[notch], 0.25e-3)
        slope = np.cumsum(random.normal(0, 0.06, y.size)) * np.exp(-y / 12e-3)
        if pattern == 2:  # the cracks turn away from each other, then towards each other
            slope += direction * np.interp(y, [0, 5e-3, 13e-3], [-0.2, -0.1, 0.7])
        z = tip_z + 0.25e-3 * np.cumsum(slope)
        _add_strip(facets, random, tip_y + direction * y, z, notch, y / 400, number)
        row["lines"].append((notch, -1, np.stack([tip_y + direction * y, z], axis=1)[::3]))
        if pattern == 2 and random.random() < 0.4:
            row["bifurcations"] += 1
            tail = y[y > 0.6 * reach[notch]] - 0.6 * reach[notch]
            start = np.searchsorted(y, 0.6 * reach[notch])
            _add_strip(facets, random, tip_y + direction * (y[start] + tail),
                       z[start] + direction * 0.7 * tail, notch, (y[start] + tail) / 380, number)
            branch = np.stack([tip_y + direction * (y[start] + tail), z[start] + direction * 0.7 * tail], axis=1)
            row["lines"].append((notch, len(row["lines"]) - 1, branch))
        position = direction * (SECTIONS - tip_y)
        arrived = (position >= 0) & (position <= reach[notch])
        row["z"][notch, arrived] = np.interp(position[arrived], y, z)
        row["branches"][notch, arrived] = 1
        row["z_spread"][notch, arrived] = 1.2e-4
    for _ in range(4):  # stray breaks
        centre = random.uniform((0, 7e-3, 63e-3), (THICKNESS, 17e-3, 77e-3))
        facets.append((centre + random.uniform(-2e-4, 2e-4, (4, 3)), random.uniform(0, 3e-5), -1))
    row.update(outcome=3 if pattern == 3 else 2, pattern=pattern, overlap={1: 0.1, 2: 0.8, 3: 0.4}[pattern], kinks=number % 3, onset_force=random.normal(381, 12), crack_area=2e-7 * len(facets),
               crack_speed_max=random.normal(520, 40), crack_speed_ratio=0.5, effective_toughness=220.0,
               energy_error=10 ** random.uniform(-6, -4),
               facets=facets)
    row["onset_time"] = (row["onset_force"] - 135) / 5 + 27
    return row


def _add_strip(facets: list, random: np.random.Generator, y: np.ndarray, z: np.ndarray, notch: int,
               time: np.ndarray, number: int) -> None:
    """Small quadrilaterals through the thickness along a path."""
    for centre_y, centre_z, centre_time in zip(y, z, time):
        before_onset = centre_time < (number % 3) * 1e-6
        for x in np.arange(0.25e-3, THICKNESS, 0.5e-3):
            centre = np.array([x, centre_y, centre_z + random.normal(0, 1.2e-4)])
            along = random.normal(0, 1, 3)
            along *= 2.5e-4 / np.linalg.norm(along)
            across = random.normal(0, 1.5e-4, 3)
            corners = centre + np.array([along, across, -along, -across])
            facets.append((corners, -3e-3 if before_onset else centre_time + random.uniform(0, 2e-6), notch))


def _write_identity(root: h5py.File, kind: str, text: str) -> None:
    root.attrs.update({"kind": kind, "schema_version": 2, "program_version": "0.1.0", "git_commit": "synthetic",
                       "library_versions": "Open MPI 4.1.4, PETSc 3.18.5, HDF5 1.10.8", "seed": 2012,
                       "input": text})


def _write_sample(file: Path, number: int, row: dict, text: str) -> None:
    with h5py.File(file, "w") as root:
        _write_identity(root, "crackle sample", text)
        root.attrs.update({"sample": number, "status": row["status"], "error": row["error"]})
        summary = root.create_group("summary")
        for name, value in row.items():
            if name not in ("status", "error", "facets", "lines"):
                summary[name] = value
        if row["status"] != 1:
            return
        surface = root.create_group("crack_surface")
        facets = sorted(row["facets"], key=lambda facet: facet[1])
        surface["corners"] = np.array([facet[0] for facet in facets]).reshape(-1, 4, 3)
        surface["time"] = np.array([facet[1] for facet in facets])
        cracks = [0, 1, -1]
        surface["crack"] = np.array([cracks.index(facet[2]) for facet in facets], dtype="i4")
        surface["cracks/notch"] = np.array(cracks, dtype="i4")
        lines = root.create_group("crack_lines")
        lines["position"] = np.concatenate([points for _, _, points in row["lines"]])
        count = np.array([len(points) for _, _, points in row["lines"]])
        lines["lines/first"], lines["lines/count"] = np.cumsum(count) - count, count
        lines["lines/notch"] = [notch for notch, _, _ in row["lines"]]
        lines["lines/parent"] = [parent for _, parent, _ in row["lines"]]
        _write_fields(root)


def _write_fields(root: h5py.File) -> None:
    """A plate in tension whose load grows a little, with one more tetrahedron broken in each frame."""
    nodes, tetrahedra = box_mesh((THICKNESS, WIDTH, 140e-3), (1, 8, 40))
    root["mesh/nodes"], root["mesh/tetrahedra"] = nodes, tetrahedra
    time = np.linspace(0, 60e-6, 4)
    frames = root.create_group("frames")
    frames.attrs.update({"youngs_modulus": 3300e6, "poisson_ratio": 0.38})
    frames["time"], frames["broken"] = time, np.arange(time.size)
    strain = nodes * (-0.38, -0.38, 1)
    frames["displacement"] = (np.array([1, 1.1, 1.2, 1.3])[:, None, None] * 1e-3 * strain).astype("f4")
    frames["velocity"] = np.full((time.size, *nodes.shape), 0.5, "f4")
    root["breaks/tetrahedron"] = np.arange(100, 100 + time.size)
    root["breaks/cut"] = np.arange(time.size, dtype="i4")
    energy = root.create_group("energy")
    energy["time"] = time
    for name, value in (("kinetic", 0.01), ("strain", 0.02), ("external", 0.04), ("released", 0.01),
                        ("dissipated", 0.0)):
        energy[name] = np.full(time.size, value)


def _write_ensemble_file(file: Path, rows: list[dict], text: str) -> None:
    n_samples = len(rows)
    with h5py.File(file, "w") as root:
        _write_identity(root, "crackle ensemble", text)
        samples = root.create_group("samples")
        samples.create_dataset("error", data=[row["error"] for row in rows], dtype=h5py.string_dtype())
        for name in ("status", "onset_force", "onset_time", "outcome", "pattern", "overlap", "bifurcations",
                     "kinks", "crack_area", "crack_speed_max", "crack_speed_ratio", "effective_toughness", "energy_error"):
            samples[name] = np.array([row[name] for row in rows])
        z = np.array([row["z"] for row in rows])
        root["crack_path/section"] = SECTIONS
        root["crack_path/z"] = z
        root["crack_path/z_spread"] = np.array([row["z_spread"] for row in rows])
        root["crack_path/branches"] = np.array([row["branches"] for row in rows])
        statistics = root.create_group("statistics")
        statistics.attrs.update({"confidence": 0.95, "n_looks": 1, "n_needed": n_samples})
        done = np.array([row["status"] == 1 for row in rows])
        reached = np.isfinite(z).sum(axis=0)
        with np.errstate(invalid="ignore", divide="ignore"):
            statistics["z_mean"] = np.nansum(z, axis=0) / reached
            std = np.sqrt(np.nansum((z - statistics["z_mean"]) ** 2, axis=0) / (reached - 1))
            statistics["z_std"] = std
            statistics["z_half_width"] = 1.96 * std / np.sqrt(reached)
            statistics["running_mean"] = np.nancumsum(z, axis=0) / np.cumsum(np.isfinite(z), axis=0)
        statistics["reached"] = reached
        pattern = np.array([row["pattern"] for row in rows])[done]
        share = np.bincount(pattern, minlength=N_PATTERNS) / max(done.sum(), 1)
        statistics["pattern_share"] = share
        statistics["pattern_half_width"] = 1.96 * np.sqrt(share * (1 - share) / max(n_samples, 1))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--samples", type=int, default=6)
    arguments = parser.parse_args()
    write_ensemble(arguments.folder, arguments.samples)
