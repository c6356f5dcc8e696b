# SPDX-License-Identifier: GPL-3.0-or-later
"""The samples of a study as rows of one table, which is small enough to be kept beside the project's inputs."""
from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from crackle_report import input_text
from crackle_report.plate import Plate
from crackle_report.reading import text_of

from .studies import Run

SECTIONS = ("7", "9", "12.25", "15.5", "17.5")  # y [mm]
SUMMARY = ("onset_force", "onset_time", "outcome", "pattern", "overlap", "bifurcations", "kinks", "breaks", "crack_area",
           "crack_speed_ratio", "energy_error")  # of ensemble.h5
COURSE = ("start", "reach_0", "reach_1", "early_reach_0", "early_reach_1", "turned", "forces")  # of the sample's file
FIELDS = SUMMARY + COURSE
BAR_SPEED = math.sqrt(3.3e9 / 1180)  # of waves along the plate, in jobs/paper.toml's material [m/s]
START_LENGTH = 1e-3  # [m]
EARLY = 85e-6  # [s]: with it the longest of the paper's 100 us after onset that all samples have


@dataclass(frozen=True)
class Rows:
    """The done samples of one run; SI units.

    `start` is the time at which the first crack has run START_LENGTH, since the onset of the last dynamic phase, or since
    the load began to grow where the body was at rest. `reach` is the share of its ligament that the crack of each notch
    has crossed at the end, `early_reach` EARLY after the start. `turned` is 1 where the mesh is turned by 180 degrees
    against the base. `forces` counts evaluations of the force.
    """

    name: str
    label: str
    sample: np.ndarray
    values: dict[str, np.ndarray]  # FIELDS
    z: np.ndarray  # samples x notches x sections [m]; NaN where a crack did not arrive
    seconds: np.ndarray  # that each sample took

    def __len__(self) -> int:
        return len(self.sample)

    def share(self, pattern: int) -> int:
        return int(np.count_nonzero(self.values["pattern"] == pattern))


def read(run: Run, results: Path) -> Rows:
    """From an ensemble's folder; samples that are pending or have failed are left out.

    A load that grows from rest has no onset of a dynamic phase. Its onset is then the start, less the time that the load
    takes to the notch, and the load at the loaded end at that time.
    """
    with h5py.File(results / "ensemble.h5") as root:
        setting = input_text.parse(text_of(root.attrs["input"]))
        done = np.flatnonzero(root["samples/status"][...] == 1)
        values = {name: root[f"samples/{name}"][...][done].astype(float) for name in SUMMARY}
        z, seconds = root["crack_path/z"][...][done], root["timing/wall_time"][...][done]
    plate = input_text.plate(setting)
    courses = [_course(results / "samples" / f"{i:04d}.h5", plate) for i in done]
    values |= {name: np.array([course[name] for course in courses]) for name in COURSE}
    if run.rate is not None:
        values["onset_time"] = values["start"] - np.array([course["travel"] for course in courses])
        values["onset_force"] = run.rate * values["onset_time"]
    return Rows(run.name, run.label, done, values, z, seconds)


def _course(sample: Path, plate: Plate) -> dict[str, float]:
    """When a sample's cracks ran, and how far; `travel` is what a wave takes from z-max to the notch that starts [s]."""
    with h5py.File(sample) as root:
        table = {name: column[...] for name, column in root["crack_lines/lines"].items()}
        position, time = root["crack_lines/position"][...], root["crack_lines/time"][...]
        turned = bool(int(root["mesh"].attrs.get("reflected_axes", 0)) & 4)
        forces = float(root["counts/force_evaluations"][()])
    starts, advances = np.full(2, math.nan), [(np.empty(0), np.empty(0))] * 2
    ligaments = np.array([plate.size[1] - notch.depth for notch in plate.notches])
    for notch, parent, first, count in zip(*(table[name] for name in ("notch", "parent", "first", "count"))):
        if parent >= 0:
            continue
        advance = np.abs(position[first:first + count, 0] - plate.tip(notch)[0])
        advances[notch] = advance, time[first:first + count]
        far = np.flatnonzero(advance >= START_LENGTH)
        starts[notch] = time[first + far[0]] if far.size else math.nan
    result = {"start": math.nan, "travel": math.nan, "turned": float(turned), "forces": forces}
    if np.isfinite(starts).any():
        leader = int(np.nanargmin(starts))
        result |= {"start": float(starts[leader]), "travel": (plate.size[2] - plate.tip(leader)[1]) / BAR_SPEED}
    for notch, (advance, when) in enumerate(advances):
        result[f"reach_{notch}"] = float(advance.max(initial=0)) / ligaments[notch]
        early = advance[when <= result["start"] + EARLY]
        result[f"early_reach_{notch}"] = float(early.max(initial=0)) / ligaments[notch]
    return result


def write_csv(rows: list[Rows], file: Path) -> None:
    with open(file, "w", newline="") as stream:
        out = csv.writer(stream, lineterminator="\n")
        out.writerow(["run", "label", "sample", *FIELDS, *(f"z_{notch}_{y}mm" for notch in range(2) for y in SECTIONS),
                      "seconds"])
        for r in rows:
            for i in range(len(r)):
                out.writerow([r.name, r.label, r.sample[i], *(f"{r.values[name][i]:.7g}" for name in FIELDS),
                              *(f"{z:.6g}" for z in r.z[i].ravel()), f"{r.seconds[i]:.1f}"])


def read_csv(file: Path) -> list[Rows]:
    with open(file, newline="") as stream:
        lines = list(csv.DictReader(stream))
    result = []
    for name in dict.fromkeys(line["run"] for line in lines):
        mine = [line for line in lines if line["run"] == name]
        z = [[float(line[f"z_{notch}_{y}mm"]) for notch in range(2) for y in SECTIONS] for line in mine]
        result.append(Rows(name, mine[0]["label"], np.array([int(line["sample"]) for line in mine]),
                           {field: np.array([float(line[field]) for line in mine]) for field in FIELDS},
                           np.array(z).reshape(len(mine), 2, len(SECTIONS)),
                           np.array([float(line["seconds"]) for line in mine])))
    return result
