# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of the verification, beside their references, and the table of them; comparisons of the law with one before it."""
from __future__ import annotations

import json
import re
import subprocess
import zlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable, Sequence

import crackle
import numpy as np

from crackle_runs import JOBS, ROOT, RunError, markdown, model_of, run, with_keys, without_samples

MILLIMETRE = 1e-3
RECORD = JOBS / "runs.json"
"""What the quantities of comparisons are in each sample that was computed, so that tables need no sample again."""


@dataclass(frozen=True)
class Figure:
    case: str
    quantity: str
    found: str
    reference: str
    before: str = ""  # found with another law


@dataclass(frozen=True)
class Quantity:
    """What is found in each sample of a run."""

    title: str
    of: Callable[[crackle.Ensemble], Sequence[float]]  # of the samples that are done; NaN for one that has none
    form: str  # of the mean
    reference: str = "equal"
    unit: str = ""

    def cell(self, values: Sequence[float]) -> str:
        """Mean and standard deviation of the samples that have it, their number and, where it differs, that of all."""
        values = np.array(values, float)
        there = values[np.isfinite(values)]
        number = f"({len(there)})" if len(there) == len(values) else f"({len(there)} of {len(values)})"
        return f"{mean(list(there), self.form)}{self.unit} {number}" if len(there) else f"none {number}" if len(values) else "–"


@dataclass(frozen=True)
class Comparison:
    """The same quantities of several inputs, under the law and under one before it."""

    case: str
    name: str  # of the folders
    inputs: dict[str, str]  # by what they differ in
    quantities: Sequence[Quantity]
    n_samples: int
    before: dict[str, str | None] = field(default_factory=dict)  # keys of the other law; without any only the law is computed

    def runs(self, folder: Path) -> list[tuple[str, Path]]:
        """Input and folder of each run, those of the other law last."""
        keys = {"ensemble.samples": f"{self.n_samples}"}
        return [(with_keys(text, keys | law), folder / f"{self.name}-{label}{'-before' if law else ''}")
                for law in ({}, self.before)[:1 + bool(self.before)] for label, text in self.inputs.items()]

    def __call__(self, folder: Path, program: Path, is_kept: bool = False) -> list[Figure]:
        """@param is_kept: of the samples that are there, computing none"""
        found = [self._values(text, place, program, is_kept) for text, place in self.runs(folder)]
        laws = found[:len(self.inputs)], found[len(self.inputs):]
        return [Figure(self.case, quantity.title, cells[0], quantity.reference, cells[1]) for k, quantity in enumerate(self.quantities)
                for cells in [["; ".join(quantity.cell([sample[k] for sample in samples]) for samples in law) for law in laws]]]

    def _values(self, text: str, place: Path, program: Path, is_kept: bool) -> list[list[float]]:
        """Of each sample its quantities: recorded ones and, unless all are, those of the run, which are recorded."""
        record = json.loads(RECORD.read_text()) if RECORD.is_file() else {}
        model = model_of(program)
        heading = {"input": zlib.crc32(without_samples(text).encode()), "model": model,
                   "quantities": [quantity.title for quantity in self.quantities]}
        entry = record.get(place.name, {})
        samples = dict(entry["samples"]) if heading.items() <= entry.items() else {}
        ensemble = _kept(place) if is_kept or len(samples) >= self.n_samples else run(text, place, program)
        if ensemble is not None:
            with ensemble[ensemble.done[0]].open() as root:  # a run's samples are of one model
                if root.attrs.get("model_version") != model:
                    raise RunError(f"the samples in '{place}' are of another model than '{program}': remove the folder")
            columns = [quantity.of(ensemble) for quantity in self.quantities]
            seen = {str(sample): [float(f"{value:.7g}") for value in row] for sample, row in zip(ensemble.done, zip(*columns))}
            samples |= seen
            if samples != entry.get("samples"):
                _write(record | {place.name: heading | {"samples": samples}})
        return [samples[sample] for sample in sorted(samples, key=int)]


def _write(record: dict[str, dict]) -> None:
    """A line for each sample."""
    lines = [f'"{name}": {json.dumps(entry | {"samples": {}}, ensure_ascii=False)[:-2]}\n' + ",\n".join(
        f'  "{sample}": {json.dumps(row)}' for sample, row in sorted(entry["samples"].items(), key=lambda item: int(item[0]))) + "}}"
        for name, entry in sorted(record.items())]
    RECORD.write_text("{\n" + ",\n".join(lines) + "\n}\n")


def _kept(folder: Path) -> crackle.Ensemble | None:
    ensemble = crackle.open(folder / "out") if any(folder.glob("out/samples/*.h5")) else None
    return ensemble if ensemble is not None and ensemble.done else None


def each(of: Callable[[crackle.Sample], float]) -> Callable[[crackle.Ensemble], list[float]]:
    return lambda ensemble: [of(ensemble[number]) for number in ensemble.done]


def result(name: str, factor: float = 1) -> Callable[[crackle.Ensemble], Sequence[float]]:
    """A result of `crackle stats --columns`."""
    return lambda ensemble: factor * ensemble.samples[name][ensemble.done].to_numpy(float)


def mean(values: list[float], form: str) -> str:
    """Mean and standard deviation."""
    return f"{np.mean(values):{form}} ± {np.std(values, ddof=1):{form}}" if len(values) > 1 else f"{values[0]:{form}}"


def output_of(test: str) -> str:
    """What a test prints, by its name for CTest."""
    done = subprocess.run(["ctest", "--test-dir", str(ROOT / "build"), "-V", "--no-tests=error", "-R", rf"^{test}$"],
                          capture_output=True, text=True)
    if done.returncode != 0:
        raise RunError(f"the test {test} failed; `CRACKLE_TESTS=ON tools/build` builds it:\n{done.stdout[-2000:]}{done.stderr}")
    return re.sub(r"(?m)^\d+: ", "", done.stdout)


def table(figures: list[Figure]) -> str:
    previous, compared = ["", *(figure.case for figure in figures)], any(figure.before for figure in figures)
    return markdown(["case", "figure", "found", *(["before"] if compared else []), "reference"],
                    [[figure.case if figure.case != before else "", figure.quantity, figure.found, *([figure.before or "–"] if compared else []),
                      figure.reference] for figure, before in zip(figures, previous)])
