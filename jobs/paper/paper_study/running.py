# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs of the studies, in pieces that go on where the last one stopped."""
from __future__ import annotations

import subprocess
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Iterator

import h5py
import numpy as np

from crackle_launch import environment, mpirun
from crackle_report.writing import write_whole
from crackle_runs import SOME_FAILED, RunError, status_of

from . import rows
from .studies import CAMPAIGN, STUDY_OF, Run

STOPPED_EARLY = 3


@dataclass(frozen=True)
class Known:
    """What is known of a run whose sample files are elsewhere, or gone."""

    samples: frozenset[int] = frozenset()
    ensemble: Path | None = None  # their ensemble.h5


def known_of(run: Run, folder: Path) -> Known:
    """What the tables of a folder, such as jobs/paper, hold of a run's input."""
    table = folder / f"{STUDY_OF[run.name]}.csv"
    found = [one for one in rows.read_csv(table) if one.name == run.name] if table.is_file() else []
    if not found:
        return Known()
    if found[0].input != rows.digest(run.input_text()):
        print(f"{run.name}: the {len(found[0])} samples in {table} are of another input, or do not say of which; all are computed", flush=True)
        return Known()
    ensemble = folder / "ensemble.h5"
    return Known(frozenset(found[0].sample.tolist()), ensemble if run is CAMPAIGN and ensemble.is_file() else None)


def done_samples(ensemble: Path) -> frozenset[int]:
    """Those of an ensemble.h5; none where there is no such file."""
    if not ensemble.is_file():
        return frozenset()
    with h5py.File(ensemble) as file:
        return frozenset(np.nonzero(file["samples/status"][...] == 1)[0].tolist())


def is_finished(folder: Path, known: Known = Known()) -> bool:
    """Whether the ensemble in `folder` has no pending sample but known ones."""
    file = folder / "ensemble.h5"
    if not file.is_file():
        return False
    with h5py.File(file) as ensemble:
        return known.samples.issuperset(np.nonzero(ensemble["samples/status"][...] == 0)[0].tolist())


def gaps(n_samples: int, known: frozenset[int]) -> Iterator[tuple[int, int]]:
    """First and last of the samples that are not known, range by range."""
    first = None
    for sample in range(n_samples + 1):
        is_open = sample < n_samples and sample not in known
        if is_open and first is None:
            first = sample
        elif not is_open and first is not None:
            yield first, sample - 1
            first = None


def compute(run: Run, output: Path, program: Path, ranks: int, deadline: float | None, known: Known = Known()) -> bool:
    """Goes on with a run until it is finished or the deadline [s, time.monotonic()] is near. Known samples are left out.

    @return whether it is finished
    """
    folder = output / run.name
    results = folder / "out"
    text = run.input_text()
    folder.mkdir(parents=True, exist_ok=True)
    source = folder / "input.toml"
    if source.is_file() and source.read_text() != text:
        raise RunError(f"{source} is of another input than {run.source_file} now gives; remove {folder} to compute it again")
    source.write_text(text)
    is_merged = known.ensemble is None or known.samples <= done_samples(results / "ensemble.h5")
    if is_merged and is_finished(results, known):
        return True
    if not known.samples:
        return _run(run, folder, program, ranks, deadline)
    if not is_merged:
        # Rows of samples that have files here come from these when the two are merged.
        results.mkdir(exist_ok=True)
        write_whole(results / "ensemble.h5", known.ensemble.read_bytes())
    is_whole = all([_run(run, folder, program, ranks, deadline, f"{first}-{last}")
                    for first, last in gaps(run.samples, known.samples)])
    if (results / "input.toml").is_file():
        _merge(folder, program)
    return is_whole


def _merge(folder: Path, program: Path) -> None:
    """Brings ensemble.h5 up to date, the rows of known samples staying."""
    with open(folder / "log.txt", "a") as log:
        status = subprocess.run([str(program), "stats", "--keep-rows", str(folder / "out")], stdout=subprocess.DEVNULL, stderr=log,
                                env=environment()).returncode
    if status != 0:
        raise RunError(f"the results in {folder / 'out'} cannot be merged; see {folder / 'log.txt'}")


def _run(run: Run, folder: Path, program: Path, ranks: int, deadline: float | None, samples: str = "") -> bool:
    results = folder / "out"
    command = [*mpirun(ranks), str(program), "run", str(folder / "input.toml"), "-o", str(results)]
    if samples:
        command += ["--samples", samples]
    if results.is_dir():
        command.append("--resume")
    if deadline is not None:
        left = deadline - time.monotonic()
        if left < 30:
            return False
        command += ["--time-limit", f"{left:.0f}s"]
    with open(folder / "log.txt", "a") as log:
        status = status_of(command, log)
    if status == SOME_FAILED:
        print(f"{run.name}: some samples failed, see {folder / 'log.txt'}", flush=True)
    elif status not in (0, STOPPED_EARLY):
        raise RunError(f"'{' '.join(command)}' ended with status {status}; see {folder / 'log.txt'}")
    return status != STOPPED_EARLY
