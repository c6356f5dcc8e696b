# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads an ensemble's folder: ensemble.h5 where it is, samples/NNNN.h5 for what it does not hold."""
from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any, Callable, TypeVar

# A folder on a network file system, or one that a run is writing to, may not be locked for reading.
os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")

import h5py  # noqa: E402
import numpy as np  # noqa: E402

from . import input_text  # noqa: E402
from .ranks import GROUPS, LeaderFrame, derived_leading, make_ranks  # noqa: E402
from .results import (DONE, PENDING, CrackLine, CrackSurface, CrossSection, Energy, Ensemble, Forks, Frames, Ranks,  # noqa: E402
                      Result, Samples, Statistics)
from .statistics import look_schedule, make_statistics  # noqa: E402
from .stress import ALL_EDGES, CROSSED_EDGES  # noqa: E402

DEFAULT_CONFIDENCE = 0.95  # of the intervals while there is no ensemble.h5
DEFAULT_MIN_SAMPLES = 30  # of [ensemble.stop]
INTERVAL_SCOPES = {  # by mesh.base; of files that do not say so themselves
    "shared": "Intervals cover the scatter of samples that share one set of mother points; that between such sets is not in "
              "them.",
    "own": "Intervals cover the scatter of independent samples, each with a set of mother points of its own."}
ENSEMBLE_KIND, SAMPLE_KIND = "crackle ensemble", "crackle sample"
POSITIONS = ("position", "z_spread", "branches")
NOT_RESULTS = (*POSITIONS, "z", "status", "error", "note", "phase_start", "time_step", "stable_step")  # that stand beside the results
CATEGORIES = {"outcome": "0 unbroken, 1 arrested, 2 separated, 3 in one piece",
              "pattern": "0 none, 1 one crack, 2 two cracks, 3 other"}  # of files that do not say so themselves


class ResultsError(Exception):
    """The folder does not hold an ensemble's results, or they cannot be read."""


def read_ensemble(folder: Path) -> Ensemble:
    """The results in an output folder of the program.

    Samples that ensemble.h5 does not hold, because the run was stopped or still goes on, come from their own
    files; then the statistics are made anew. Raises ResultsError.
    """
    if not folder.is_dir():
        raise ResultsError(f"'{folder}' is no folder")
    try:
        return _read(folder)
    except KeyError as error:
        raise ResultsError(f"'{folder}': its files lack something that this report needs: {error.args[0]}") from error


def _read(folder: Path) -> Ensemble:
    file = folder / "ensemble.h5"
    sample_files = _sample_files(folder)
    if file.is_file():
        with _open(file, ENSEMBLE_KIND) as root:
            identity = _identity(root)
            samples, statistics, ranks = _read_rows(root), _read_statistics(root), _read_ranks(root)
            scope = text_of(root["statistics"].attrs.get("interval_scope", INTERVAL_SCOPES["shared"]))
            confidence = float(root["statistics"].attrs["confidence"])
            n_looks, n_needed = (int(root["statistics"].attrs[name]) for name in ("n_looks", "n_needed"))
            sections = _read_sections(root["crack_path"])
            setting = _parse_input(file, identity)
    elif sample_files:
        first = next(iter(sample_files.values()))
        with _open(first, SAMPLE_KIND) as root:
            identity = _identity(root)
            results = _describe_results(root["summary"])
            types = {result.name: root["summary"][result.name].dtype for result in results}
        setting = _parse_input(first, identity)
        sections = tuple(CrossSection(*section) for section in input_text.sections(setting))
        n_samples = n_needed = max(int(setting["ensemble"]["samples"]), max(sample_files) + 1)
        samples = _pending_rows(n_samples, len(setting["specimen"].get("notch", [])), len(sections), results, types)
        statistics, ranks, scope = None, {}, INTERVAL_SCOPES[setting.get("mesh", {}).get("base", "shared")]
        stop = setting["ensemble"].get("stop")
        confidence = float((stop or {}).get("confidence", DEFAULT_CONFIDENCE))
        n_looks = len(look_schedule(n_samples, int(stop.get("min_samples", DEFAULT_MIN_SAMPLES)))) if stop else 1
    else:
        raise ResultsError(f"'{folder}' holds neither ensemble.h5 nor samples: no output folder of crackle run, "
                           "or no sample has finished yet")

    n_planned = len(samples)
    samples, statistics = samples.first(n_needed), statistics and statistics.first(n_needed)
    ranks = {group: of.first(n_needed) for group, of in ranks.items()}
    added = [i for i in sample_files if i < len(samples) and samples.status[i] == PENDING]
    for i in added:
        _read_row(sample_files[i], samples, i)
    if statistics is None or added:
        statistics = make_statistics(samples, confidence, n_looks)
    plate = input_text.plate(setting)
    frame = LeaderFrame(plate, sections)
    is_derived = "leading_notch" not in samples.numbers
    leading = derived_leading(plate, sections, samples) if is_derived else samples.leading_notch
    leading = np.where(samples.status == DONE, leading, -1)
    if not ranks or added:
        ranks = make_ranks(frame, samples, leading, confidence, n_looks)
    return Ensemble(
        folder=folder, plate=plate, frame=frame, leading=leading, leading_is_derived=is_derived, ranks=ranks,
        interval_scope=scope, sections=sections, confidence=confidence, n_looks=n_looks, n_planned=n_planned,
        samples=samples, statistics=statistics, provenance=_describe(identity),
        input_text=str(identity["input"]), stop_half_width=input_text.stop_half_width(setting),
        load_crack=_loader(sample_files, _read_crack, None), load_lines=_loader(sample_files, _read_lines, []),
        load_forks=_loader(sample_files, _read_forks, None), load_energy=_loader(sample_files, _read_energy, None),
        load_frames=_loader(sample_files, _read_frames, None))


Part = TypeVar("Part")


def _loader(files: dict[int, Path], read: Callable[[h5py.File], Part], nothing: Part) -> Callable[[int], Part]:
    """Reads a part of a sample's results; `nothing` without its file or when it failed."""

    def load(i: int) -> Part:
        if i not in files:
            return nothing
        with _open(files[i], SAMPLE_KIND) as root:
            return read(root) if root.attrs["status"] == DONE else nothing

    return load


def _sample_files(folder: Path) -> dict[int, Path]:
    """The whole sample files by their number; files under way have other names."""
    names = ((re.fullmatch(r"(\d{4,})\.h5", file.name), file) for file in (folder / "samples").glob("*.h5"))
    return dict(sorted((int(match[1]), file) for match, file in names if match))


def _open(file: Path, kind: str) -> h5py.File:
    try:
        root = h5py.File(file, "r")
    except OSError as error:
        raise ResultsError(f"'{file}' cannot be read: {error}") from error
    found = text_of(root.attrs.get("kind", ""))
    if found != kind:
        root.close()
        raise ResultsError(f"'{file}' is not a {kind} file")
    return root


def text_of(value: Any) -> Any:
    """An attribute or element as h5py gives it; texts of fixed length come as bytes."""
    return value.decode("utf-8") if isinstance(value, bytes) else value


def _identity(root: h5py.File) -> dict[str, Any]:
    return {name: text_of(value) for name, value in root.attrs.items()}


def _describe(identity: dict[str, Any]) -> dict[str, str]:
    names = {"program_version": "program version", "git_commit": "git commit",
             "library_versions": "libraries", "seed": "seed", "schema_version": "version of the file format"}
    return {title: str(identity[name]) for name, title in names.items() if name in identity}


def _parse_input(file: Path, identity: dict[str, Any]) -> dict[str, Any]:
    try:
        setting = input_text.parse(str(identity["input"]))
        input_text.plate(setting)
        return setting
    except ValueError as error:
        raise ResultsError(f"the input text in '{file}' cannot be understood: {error}") from error


def _describe_results(group: h5py.Group) -> tuple[Result, ...]:
    """The results among the group's datasets, in the order of tables."""
    results = []
    for name, dataset in group.items():
        if name in NOT_RESULTS:
            continue
        found = {key: text_of(value) for key, value in dataset.attrs.items()}
        words = (entry.split(" ", 1) for entry in found.get("categories", CATEGORIES.get(name, "")).split(", ") if entry)
        results.append((found.get("column", 0), Result(
            name, found.get("label", name.replace("_", " ")), found.get("shown_units", found.get("units", "")),
            float(found.get("shown_factor", 1)), found.get("format", ".4g" if dataset.dtype.kind == "f" else "d"),
            {int(number): word for number, word in words})))
    return tuple(result for _, result in sorted(results, key=lambda entry: entry[0]))


def _pending_rows(n_samples: int, n_notches: int, n_sections: int, results: tuple[Result, ...],
                  types: dict[str, np.dtype]) -> Samples:
    shape = (n_samples, n_notches, n_sections)
    return Samples(status=np.zeros(n_samples, int), error=[""] * n_samples, results=results,
                   numbers={name: np.full(n_samples, np.nan if kind.kind == "f" else 0, kind)
                            for name, kind in types.items()},
                   position=np.full(shape, np.nan), z_spread=np.full(shape, np.nan), branches=np.zeros(shape, int))


def _read_rows(root: h5py.File) -> Samples:
    group = root["samples"]
    results = _describe_results(group)
    return Samples(status=group["status"][...], error=[text_of(reason) for reason in group["error"][...]],
                   results=results, numbers={result.name: group[result.name][...] for result in results},
                   **_positions(root["crack_path"]))


def _positions(group: h5py.Group) -> dict[str, np.ndarray]:
    """What is measured at the sections; in files of version 2 all of them were y = const, and the position was z."""
    return {name: group["z" if name == "position" and name not in group else name][...] for name in POSITIONS}


def _read_sections(group: h5py.Group) -> tuple[CrossSection, ...]:
    position = group["section"][...]
    axis = group["section_axis"][...] if "section_axis" in group else np.ones(len(position), int)
    return tuple(CrossSection(int(a), float(p)) for a, p in zip(axis, position))


def _read_row(file: Path, samples: Samples, i: int) -> None:
    with _open(file, SAMPLE_KIND) as root:
        samples.status[i] = root.attrs["status"]
        samples.error[i] = text_of(root.attrs["error"])
        group = root["summary"]
        for name, values in samples.numbers.items():
            values[i] = group[name][()]
        for name, values in _positions(group).items():
            getattr(samples, name)[i] = values


def _read_statistics(root: h5py.File) -> Statistics:
    group = root["statistics"]
    return Statistics(**{name: group[name][...] for name in Statistics.__dataclass_fields__})


def _read_ranks(root: h5py.File) -> dict[str, Ranks]:
    """Nothing of files that do not tell ranks apart."""
    group = root["statistics"]
    return {name: Ranks(**{field: group[name][field][...] for field in Ranks.__dataclass_fields__})
            for name in GROUPS if "leader" in group}


def _read_crack(root: h5py.File) -> CrackSurface:
    group = root["crack_surface"]
    notch_of_crack = np.append(group["cracks/notch"][...], -1)
    return CrackSurface(group["corners"][...].astype(np.float32), group["time"][...],
                        notch_of_crack[group["crack"][...]])


def _read_lines(root: h5py.File) -> list[CrackLine]:
    group = root["crack_lines"]
    position, table = group["position"][...], group["lines"]
    return [CrackLine(int(notch), parent >= 0, position[first:first + count]) for notch, parent, first, count in
            zip(*(table[name][...] for name in ("notch", "parent", "first", "count")))]


def _read_forks(root: h5py.File) -> Forks | None:
    """Nothing of files of version 2."""
    if "forks" not in root:
        return None
    return Forks(**{name: root["forks"][name][...] for name in Forks.__dataclass_fields__})


def _read_energy(root: h5py.File) -> Energy:
    return Energy(**{name: root["energy"][name][...] for name in Energy.__dataclass_fields__})


def _read_frames(root: h5py.File) -> Frames:
    group = root["frames"]
    broken, cut = root["breaks/tetrahedron"][...], root["breaks/cut"][...]
    n_broken = group["broken"][...]
    return Frames(root["mesh/nodes"][...], root["mesh/tetrahedra"][...], group["time"][...],
                  group["displacement"][...], group["velocity"][...], [broken[:n] for n in n_broken],
                  [cut[:n] for n in n_broken], [_released_edges(root, n) for n in n_broken],
                  input_text.has_contact(input_text.parse(text_of(root.attrs["input"]))),
                  float(group.attrs["youngs_modulus"]), float(group.attrs["poisson_ratio"]))


def _released_edges(root: h5py.File, n_broken: int) -> np.ndarray:
    """Of the first n_broken tetrahedra in /breaks when no more were broken."""
    if "ties" not in root:  # release by elements
        return np.full(n_broken, ALL_EDGES, np.uint8)
    breaks, ties = root["breaks"], root["ties"]
    released = CROSSED_EDGES[breaks["cut"][:n_broken]]
    if n_broken == 0:
        return released
    # Ties are in order of time, and each has the times of the break that caused it.
    loading, phase = (ties[name][...] for name in ("load_time", "phase_time"))
    last_loading, last_phase = (breaks[name][n_broken - 1] for name in ("load_time", "phase_time"))
    n_ties = np.count_nonzero((loading < last_loading) | ((loading == last_loading) & (phase <= last_phase)))
    broken = breaks["tetrahedron"][:n_broken]
    order = np.argsort(broken)
    place = order[np.searchsorted(broken, ties["tetrahedron"][:n_ties], sorter=order)]
    np.bitwise_or.at(released, place, ties["edges"][:n_ties])
    return released
