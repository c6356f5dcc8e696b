# SPDX-License-Identifier: GPL-3.0-or-later
"""The samples of a study as rows of one table, which is small enough to be kept beside the project's inputs."""
from __future__ import annotations

import csv
import hashlib
import io
import json
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Iterable

import numpy as np

from crackle_report.reading import read_ensemble
from crackle_report.writing import write_whole
from crackle_runs import RunError

from . import course, ramp
from .studies import Run

SECTIONS = ("7", "9", "12.25", "15.5", "17.5")  # y [mm]
SUMMARY = ("onset_force", "onset_time", "outcome", "pattern", "overlap", "bifurcations", "bifurcations_projected", "kinks", "breaks", "crack_area",
           "crack_speed_ratio", "energy_error")  # of `crackle stats`
FIELDS = SUMMARY + course.FIELDS


@dataclass(frozen=True)
class Rows:
    """The done samples of one run; SI units."""

    name: str
    label: str
    input: str  # digest of what the samples follow from
    sample: np.ndarray
    values: dict[str, np.ndarray]  # FIELDS; see course.read
    z: np.ndarray  # samples x notches x sections [m]; NaN where a crack did not arrive
    seconds: np.ndarray  # that each sample took

    def __len__(self) -> int:
        return len(self.sample)

    @property
    def start(self) -> np.ndarray:
        """When the first crack has started [s]; NaN where none has."""
        return np.fmin(self.values["start_0"], self.values["start_1"])

    @property
    def forked(self) -> np.ndarray:
        """Which samples have a fork in the projection; none where forks were not counted."""
        return self.values["bifurcations_projected"] > 0

    def knows(self, name: str) -> bool:
        """Whether a value is known of every sample; files from before it was measured do not have it."""
        return not np.isnan(self.values[name]).any()

    def share(self, pattern: int) -> int:
        return int(np.count_nonzero(self.values["pattern"] == pattern))


def digest(text: str) -> str:
    """Of an input, whatever its comments and its number of samples."""
    settings = tomllib.loads(text)
    del settings["ensemble"]["samples"]
    return hashlib.sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()[:12]


def input_of(results: Path) -> str:
    """Digest of the input that an ensemble's folder is of."""
    return digest((results / "input.toml").read_text())


def read(run: Run, results: Path) -> Rows:
    """From an ensemble's folder; samples that are pending, have failed, or whose files were moved away are left out.

    A load that grows from rest has no onset of a dynamic phase. Its onset is then the first start, and the load that of a
    bar without notches at the notches' middle.
    """
    ensemble = read_ensemble(results)
    done = np.array([i for i in ensemble.done if i in ensemble.files.files], int)
    samples, plate = ensemble.samples, ensemble.plate
    values = {name: samples.numbers.get(name, np.full(len(samples), np.nan))[done].astype(float) for name in SUMMARY}
    courses = [course.read(ensemble.files.files[i], plate) for i in done]
    values |= {name: np.array([one[name] for one in courses]) for name in course.FIELDS}
    rows = Rows(run.name, run.label, input_of(results), done, values, samples.position[done],
                samples.wall_time[done])
    if run.rate is not None:
        values["onset_time"] = rows.start
        values["onset_force"] = ramp.section_load(run.rate, rows.start, plate.size[2] / 2, plate.size[2])
    return rows


def joined(known: Rows, found: Rows) -> Rows:
    """The samples of both, in order; what was found goes before what was known of the same sample.

    @raise RunError: they are of different inputs, or what was known does not say of which
    """
    if known.input != found.input:
        raise RunError(f"the {len(known)} samples of {known.name} that are kept are of another input, or do not say of which; remove "
                       f"their lines to keep the {len(found)} that were found instead")
    kept = ~np.isin(known.sample, found.sample)
    order = np.argsort(np.concatenate([known.sample[kept], found.sample]), kind="stable")

    def join(one: np.ndarray, other: np.ndarray) -> np.ndarray:
        return np.concatenate([one[kept], other])[order]

    return Rows(found.name, found.label, found.input, join(known.sample, found.sample),
                {name: join(known.values[name], found.values[name]) for name in FIELDS}, join(known.z, found.z),
                join(known.seconds, found.seconds))


def write_table(titles: list[str], lines: Iterable[list], file: Path) -> None:
    """A CSV file, replaced in one step: what it holds may have been computed elsewhere."""
    stream = io.StringIO(newline="")
    csv.writer(stream, lineterminator="\n").writerows([titles, *lines])
    write_whole(file, stream.getvalue().encode())


def write_csv(rows: list[Rows], file: Path) -> None:
    titles = ["run", "label", "input", "sample", *FIELDS, *(f"z_{notch}_{y}mm" for notch in range(2) for y in SECTIONS), "seconds"]
    write_table(titles, ([r.name, r.label, r.input, r.sample[i], *(f"{r.values[name][i]:.7g}" for name in FIELDS),
                          *(f"{z:.6g}" for z in r.z[i].ravel()), f"{r.seconds[i]:.1f}"] for r in rows for i in range(len(r))), file)


def read_csv(file: Path) -> list[Rows]:
    """What an older file does not have is NaN."""
    with open(file, newline="") as stream:
        lines = list(csv.DictReader(stream))
    result = []
    for name in dict.fromkeys(line["run"] for line in lines):
        mine = [line for line in lines if line["run"] == name]
        z = [[float(line[f"z_{notch}_{y}mm"]) for notch in range(2) for y in SECTIONS] for line in mine]
        result.append(Rows(name, mine[0]["label"], mine[0].get("input", ""), np.array([int(line["sample"]) for line in mine]),
                           {field: np.array([float(line.get(field, "nan")) for line in mine]) for field in FIELDS},
                           np.array(z).reshape(len(mine), 2, len(SECTIONS)),
                           np.array([float(line["seconds"]) for line in mine])))
    return result
