# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads an ensemble's folder: rows and statistics as the program gives them; `sample_files` reads the rest."""
from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, Iterable, Optional, TypeVar

import numpy as np
from crackle.files import ENSEMBLE_KIND, SAMPLE_KIND, ResultsError, is_there, results, text_of
from crackle.program import statistics_of
from crackle.units import MM, Unit

from .plate import Plate
from .results import CrossSection, Ensemble, PathGroup, Paths, Ranks, Result, Samples, Share, Statistics, Symmetry
from .sample_files import SampleFiles

PROVENANCE = {"program_version": "program version", "git_commit": "git commit", "library_versions": "libraries",
              "seed": "seed", "schema_version": "version of the file format"}
GROUPS = ("leader", "leader/one_crack", "leader/two_cracks", "follower")  # of the statistics


def read_ensemble(folder: Path, program: Optional[Path] = None, skips_damaged: bool = False) -> Ensemble:
    """The results in an output folder of the program, of a run that is under way too. Raises ResultsError.

    @param skips_damaged: look at all sample files now, and go on without those that cannot be used
    """
    document = statistics_of(folder, program)
    paths, statistics = document["crack_path"], document["statistics"]
    files, ensemble_file = SampleFiles(folder), folder / "ensemble.h5"
    if skips_damaged:
        files.leave_out_damaged()
    own = [(ensemble_file, ENSEMBLE_KIND)] if is_there(ensemble_file) else []
    provenance = {}
    for first, kind in [*own, *((file, SAMPLE_KIND) for file in files.files.values())][:1]:  # none before the first sample has ended
        with results(first, kind) as root:
            provenance = {title: str(text_of(root.attrs[name])) for name, title in PROVENANCE.items() if name in root.attrs}
    n = document["n_needed"]
    plate = Plate.of(document["specimen"])
    return Ensemble(
        folder=folder, plate=plate, sections=_sections(paths, plate.lengths),
        confidence=statistics["confidence"], n_looks=statistics["n_looks"], n_planned=document["n_samples"],
        samples=_samples(document, n, plate), statistics=_paths(Statistics, statistics, n), precision=statistics["precision"],
        symmetries=[Symmetry(reference, **symmetry) for reference, symmetry in
               zip(statistics["reference_notch"], statistics.get("symmetries", []))],
        ranks={name: _paths(Ranks, statistics[name], n) for name in GROUPS},
        interval_scope=statistics["interval_scope"], notes=document["notes"], provenance=provenance,
        input_text=document["input"], files=files, inputs=document.get("inputs", []), sensitivities=document.get("sensitivities"),
        warnings=document["warnings"], headline=document["headline_load"], materials=_materials(document["input"]),
        fragments={**document["fragments"], "statistics": statistics["fragments"]} if "fragments" in document else None)


def _materials(text: str) -> list[str]:
    """Names of those in an input."""
    try:
        found = tomllib.loads(text).get("material", {})
    except tomllib.TOMLDecodeError:  # as of input.toml while it is edited
        found = {}
    several = found if isinstance(found, list) else [found]
    return [str(one.get("name", f"material {k}")) for k, one in enumerate(several)]


def _sections(paths: dict[str, Any], lengths: Unit) -> tuple[CrossSection, ...]:
    lines = iter(paths.get("section_line", []))

    def name_of(axis: int, position: float, name: str) -> str:
        """The program's, whose unit is that of the input, or one in the report's unit."""
        return name if lengths == MM or not axis else f"{' yz'[axis]} = {lengths.of(position):.4g} {lengths.name}"

    return tuple(CrossSection(axis, position, name_of(axis, position, name), along, None if axis else np.array(next(lines)))
                 for axis, position, name, along in zip(*(paths[key] for key in (
                     "section_axis", "section", "section_name", "section_coordinate"))))


def _samples(document: dict[str, Any], n: int, plate: Plate) -> Samples:
    """The first n rows, which are those that count."""
    rows = document["samples"]
    results = tuple(_result(one, plate) for one in document["results"])
    return Samples(np.array(rows["status"][:n], int), rows["error"][:n], results,
                   {result.name: _numbers(rows[result.name][:n]) for result in results},
                   np.array(document["crack_path"]["position"][:n], float),
                   np.array(document["crack_path"]["arrival_time"][:n], float), np.array(rows["wall_time"][:n], float))


def _result(found: dict[str, Any], plate: Plate) -> Result:
    words = [plate.name_of(notch) for notch in range(len(plate.notch_axis))] if found["is_start"] else []
    return Result(found["name"], found["label"], found["shown_units"], found["shown_factor"], found["format"],
                  found.get("categories", words), found.get("n_any", 0),
                  Share(found["share"], found["lower"], found["upper"]) if "share" in found else None,
                  *(tuple(np.array(found.get(name, ()), float)) for name in ("quantiles", "quantile_bounds")), found.get("n_bounds", 0),
                  found["about"], found["in_sensitivities"], found["of_unbroken"], found["tells_the_end"])


def _numbers(values: Iterable[Any]) -> np.ndarray:
    """As integers where all are; null is NaN."""
    return np.array(values) if all(isinstance(value, int) for value in values) else np.array(values, float)


PathsKind = TypeVar("PathsKind", bound=Paths)


def _paths(kind: type[PathsKind], members: dict[str, Any], n: int) -> PathsKind:
    """@param n samples that running values are kept of"""
    found = {name: _numbers_in(members[name]) for name in kind.__dataclass_fields__ if name != "groups"}
    if kind is Ranks:
        found["groups"] = [PathGroup(**{name: np.array(group[name], float) if isinstance(group[name], list) else group[name]
                                        for name in PathGroup.__dataclass_fields__}) for group in members["groups"]]
    return kind(**{name: values[:n] if name.startswith("running") else values for name, values in found.items()})


def _numbers_in(values: list) -> np.ndarray:
    table = np.array(values)
    return table.astype(float) if table.dtype == object else table
