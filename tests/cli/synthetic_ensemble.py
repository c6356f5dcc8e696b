#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes an output folder as `crackle run` leaves it, with invented cracks: for the report's tests, and to
look at the pictures of an ensemble of any size without computing one."""
from __future__ import annotations

import argparse
import contextlib
import functools
import shutil
import sys
from pathlib import Path
from typing import Iterator, Optional

import h5py
import numpy as np
from scipy.spatial import cKDTree

sys.path.append(str(Path(__file__).resolve().parents[2] / "tools"))

from box_mesh import box_mesh  # noqa: E402
from crackle.checksum import checksum  # noqa: E402
from crackle.files import MARK  # noqa: E402

INPUT = """\
[ensemble]
samples = {samples}
seed = 2012
{stop}
[specimen]
size = ["5 mm", "2.45 cm", "140 mm"]
{notches}
[mesh]
base = "shared"
spacing = "1 mm"
notch_spacing = "0.3 mm"

[material]
youngs_modulus = "3300 MPa"
poisson_ratio = 0.38
density = "1180 kg/m^3"

[fracture]
strength = "35 MPa"
impulse = "1e-8 MPa^2 s"

[[boundary]]
on = "x-min"
fix = ["x", "y", "z"]

[time]
duration = "100 us"

[sections]
{sections}
"""
THICKNESS, WIDTH = 5e-3, 24.5e-3
SLOTS = (("y-min", 65, 6, 0.6), ("y-max", 75, 6, 0.6))  # face, at, depth and height [mm]
SECTIONS = np.array([7, 9, 12.25, 15.5, 17.5]) * 1e-3
TIPS = ((6e-3, 65e-3, 1), (WIDTH - 6e-3, 75e-3, -1))  # y, z, direction of growth along y


def write_ensemble(folder: Path, n_samples: int, failed: tuple[int, ...] = (), pending: tuple[int, ...] = (),
                   with_ensemble_file: bool = True, slots: tuple = SLOTS, stop: str = "",
                   sections: tuple = tuple((1, y) for y in SECTIONS * 1e3), leading: Optional[list[int]] = None) -> list[dict]:
    """Writes the folder, of version 4 of the format, and returns the samples' rows.

    @param stop the keys of [ensemble.stop]
    @param sections axis and position [mm] of each
    @param leading notch of each sample; by default the one whose crack arrives at most sections
    """
    shutil.rmtree(folder / "samples", ignore_errors=True)
    (folder / "samples").mkdir(parents=True)
    notches = "".join(f'[[specimen.notch]]\nface = "{face}"\nat = "{at} mm"\ndepth = "{depth} mm"\nheight = "{height} mm"\n'
                      for face, at, depth, height in slots)
    lists = ((name, [f'"{at:g} mm"' for its_axis, at in sections if its_axis == axis]) for axis, name in ((1, "y"), (2, "z")))
    text = INPUT.format(samples=n_samples, stop=f"[ensemble.stop]\n{stop}" if stop else "", notches=notches,
                        sections="\n".join(f"{name} = [{', '.join(its)}]" for name, its in lists if its))
    rows = []
    for i in range(n_samples):
        rows.append({**_make_sample(i, len(slots))})
        if leading is not None:
            rows[i]["leading_notch"] = leading[i]
        if i in pending:
            rows[i] = _empty_row(0, "", len(slots))
            continue
        if i in failed:
            rows[i] = _empty_row(2, "static solve diverged after 500 iterations (residual 3.1e-2 of the load)", len(slots))
        file = folder / "samples" / f"{i:04d}.h5"
        _write_sample(file, i, rows[i], text)
        seal(file)
    if with_ensemble_file:
        _write_ensemble_file(folder / "ensemble.h5", rows, text, sections)
    return rows



def seal(file: Path) -> None:
    """Gives a sample file the check sum of its content."""
    data = file.read_bytes()
    if data[-32:].startswith(MARK):
        data = data[:-32]
    file.write_bytes(data + MARK + f"{checksum(data):016x}".encode())


@contextlib.contextmanager
def changed(file: Path) -> Iterator[h5py.File]:
    """A sample file for a change, after which its check sum fits again."""
    with h5py.File(file, "r+") as root:
        yield root
    seal(file)


VERSION = 4  # of the format
NUMBERS = ("onset_force", "onset_time", "overlap", "crack_area", "crack_speed_max", "crack_speed_ratio", "traced_area",
           "effective_toughness", "energy_error", "first_break_time", "first_break_load", "crack_area_before_onset",
           "equilibrium_residual", "peak_load", "displacement_at_peak", "work_of_fracture")
COUNTS = ("outcome", "pattern", "bifurcations", "kinks", "breaks", "dynamic_phases", "leading_notch", "bifurcations_projected")
POSITIONS = ("position", "z_spread", "arrival_time", "branches")  # notches x sections


def _empty_row(status: int, error: str, n_notches: int = len(TIPS)) -> dict:
    shape = (n_notches, SECTIONS.size)
    return {"status": status, "error": error, **{name: np.nan for name in NUMBERS},
            **{name: 0 for name in COUNTS}, "leading_notch": -1,
            "position": np.full(shape, np.nan), "z_spread": np.full(shape, np.nan), "arrival_time": np.full(shape, np.nan),
            "branches": np.zeros(shape, int), "facets": [], "lines": [], "branching": []}


@functools.cache  # many ensembles have the same ones
def _make_sample(number: int, n_notches: int) -> dict:
    random = np.random.Generator(np.random.PCG64([2012, number]))
    row = _empty_row(1, "", n_notches)
    pattern = int(random.choice([1, 2, 2, 3]))
    reach = {1: (18e-3, 2e-3), 2: (13e-3, 12e-3), 3: (5e-3, 3e-3)}[pattern]
    if random.random() < 0.5:
        reach = reach[::-1]
    facets = []  # corners, time, notch
    for notch, (tip_y, tip_z, direction) in enumerate(TIPS[:n_notches]):
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
            row["branching"].append((notch, *branch[0], (y[start]) / 380))
        position = direction * (SECTIONS - tip_y)
        arrived = (position >= 0) & (position <= reach[notch])
        row["position"][notch, arrived] = np.interp(position[arrived], y, z)
        row["branches"][notch, arrived] = 1
        row["z_spread"][notch, arrived] = 1.2e-4
    for _ in range(4):  # stray breaks
        centre = random.uniform((0, 7e-3, 63e-3), (THICKNESS, 17e-3, 77e-3))
        facets.append((centre + random.uniform(-2e-4, 2e-4, (4, 3)), random.uniform(0, 3e-5), -1))
    row.update(outcome=3 if pattern == 3 else 2, pattern=pattern, overlap={1: 0.1, 2: 0.8, 3: 0.4}[pattern], kinks=number % 3, onset_force=random.normal(381, 12), crack_area=2e-7 * len(facets),
               crack_speed_max=random.normal(520, 40), crack_speed_ratio=0.5, effective_toughness=220.0, traced_area=1.3e-4, breaks=len(facets),
               bifurcations_projected=row["bifurcations"], dynamic_phases=1,
               leading_notch=int(np.isfinite(row["position"]).sum(axis=1).argmax()),
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
    root.attrs.update({"kind": kind, "schema_version": VERSION, "program_version": "1.0.0", "git_commit": "synthetic",
                       "library_versions": "Open MPI 4.1.4, PETSc 3.18.5, HDF5 1.10.8", "seed": 2012,
                       "input": text})


def _write_sample(file: Path, number: int, row: dict, text: str) -> None:
    with h5py.File(file, "w") as root:
        _write_identity(root, "crackle sample", text)
        root.attrs.update({"sample": number, "status": row["status"], "error": row["error"], "note": ""})
        summary = root.create_group("summary")
        for name in (*NUMBERS, *COUNTS, *POSITIONS):
            summary[name] = row[name]
        root["timing/wall_time"] = 12.5
        if row["status"] != 1:
            return
        surface = root.create_group("crack_surface")
        facets = sorted(row["facets"], key=lambda facet: facet[1])
        surface["corners"] = np.array([facet[0] for facet in facets]).reshape(-1, 4, 3)
        surface["time"] = np.array([facet[1] for facet in facets])
        cracks = [0, 1, -1]
        surface["crack"] = np.array([cracks.index(facet[2]) for facet in facets], dtype="i4")
        surface["cracks/notch"] = np.array(cracks, dtype="i4")
        surface["cracks/area"] = [2e-7 * sum(facet[2] == notch for facet in facets) for notch in cracks]
        surface["cracks/first_time"] = surface["cracks/last_time"] = np.zeros(len(cracks))
        surface["area"] = np.full(len(facets), 2e-7)
        _write_branching(root, row["branching"])
        lines = root.create_group("crack_lines")
        lines["position"] = np.concatenate([points for _, _, points in row["lines"]])
        count = np.array([len(points) for _, _, points in row["lines"]])
        lines["lines/first"], lines["lines/count"] = np.cumsum(count) - count, count
        lines["lines/notch"] = [notch for notch, _, _ in row["lines"]]
        lines["lines/parent"] = [parent for _, parent, _ in row["lines"]]
        _write_fields(root)


def _write_branching(root: h5py.File, points: list[tuple]) -> None:
    group = root.create_group("forks")
    group["position"] = np.array([point[1:3] for point in points]).reshape(-1, 2)
    group["time"] = np.array([point[3] for point in points])
    group["notch"] = np.array([point[0] for point in points], dtype="i4")
    for name, value in (("x", THICKNESS / 2), ("length", 4e-3), ("angle", 0.6), ("share", 1.0)):
        group[name] = np.full(len(points), value)
    for name in ("in_projection", "in_space"):
        group[name] = np.ones(len(points), "u1")


def _write_history(root: h5py.File, time: np.ndarray) -> None:
    history = root.create_group("history")
    history.attrs["rayleigh_speed"] = 950.0
    history["time"], history["phase_time"] = 76 + time, time
    history["phase"] = np.ones(time.size, "i4")
    history["governing_load"] = 380 + 1e6 * time
    history["governing_displacement"] = 1e-3 + 10 * time
    for name, value in (("crack_area", 1e-6), ("crack_length", 1e-3), ("tip_speed", 400.0), ("energy_release_rate", 50.0)):
        history[name] = np.full((time.size, len(TIPS)), value)


def _write_fields(root: h5py.File) -> None:
    """A plate in tension whose load grows a little, with one more tetrahedron broken in each frame."""
    nodes, tetrahedra = box_mesh((THICKNESS, WIDTH, 140e-3), (1, 8, 40))
    root["mesh/nodes"], root["mesh/tetrahedra"] = nodes, tetrahedra
    surface = root["crack_surface"]
    middle = nodes[tetrahedra].mean(axis=1)
    surface["tetrahedron"] = cKDTree(middle).query(surface["corners"][...].mean(axis=1))[1]
    time = np.linspace(0, 60e-6, 4)
    frames = root.create_group("frames")
    frames.attrs.update({"youngs_modulus": 3300e6, "poisson_ratio": 0.38})
    frames["time"], frames["broken"] = time, np.arange(time.size)
    strain = nodes * (-0.38, -0.38, 1)
    frames["displacement"] = (np.array([1, 1.1, 1.2, 1.3])[:, None, None] * 1e-3 * strain).astype("f4")
    frames["velocity"] = np.full((time.size, *nodes.shape), 0.5, "f4")
    root["breaks/tetrahedron"] = np.arange(100, 100 + time.size)
    root["breaks/cut"] = np.arange(time.size, dtype="i4")
    root["breaks/load_time"], root["breaks/phase_time"] = np.full(time.size, 76.0), time
    _write_history(root, time)
    energy = root.create_group("energy")
    energy["time"] = time
    for name, value in (("kinetic", 0.01), ("strain", 0.02), ("external", 0.04), ("released", 0.01),
                        ("dissipated", 0.0)):
        energy[name] = np.full(time.size, value)


def _write_ensemble_file(file: Path, rows: list[dict], text: str, sections: tuple) -> None:
    n_samples = len(rows)
    with h5py.File(file, "w") as root:
        _write_identity(root, "crackle ensemble", text)
        texts = {"dtype": h5py.string_dtype()}
        root.create_dataset("samples/error", data=[row["error"] for row in rows], **texts)
        for name in ("status", *NUMBERS, *COUNTS):
            root[f"samples/{name}"] = np.array([row[name] for row in rows])
        root["timing/wall_time"] = np.full(n_samples, 12.5)
        root["crack_path/section"] = [1e-3 * at for _, at in sections]
        for name in POSITIONS:
            root[f"crack_path/{name}"] = np.array([row[name] for row in rows])
        root.create_dataset("samples/note", data=[""] * n_samples, **texts)
        root["crack_path/section_axis"] = [axis for axis, _ in sections]
        root["crack_path/z"] = root["crack_path/position"][...]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--samples", type=int, default=6)
    arguments = parser.parse_args()
    write_ensemble(arguments.folder, arguments.samples)
