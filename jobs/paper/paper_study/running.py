# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs of the studies, in pieces that go on where the last one stopped."""
from __future__ import annotations

import subprocess
import time
from pathlib import Path

import h5py
import numpy as np

from crackle_launch import environment, mpirun
from crackle_runs import SOME_FAILED, RunError

from .studies import Run

STOPPED_EARLY = 3


def is_finished(folder: Path) -> bool:
    """Whether the ensemble in `folder` has no pending sample."""
    file = folder / "ensemble.h5"
    if not file.is_file():
        return False
    with h5py.File(file) as ensemble:
        return bool(np.all(ensemble["samples/status"][...] != 0))


def compute(run: Run, output: Path, program: Path, ranks: int, deadline: float | None) -> bool:
    """Goes on with a run until it is finished or the deadline [s, time.monotonic()] is near.

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
    if is_finished(results):
        return True
    command = [*mpirun(ranks), str(program), "run", str(source), "-o", str(results)]
    if results.is_dir():
        command.append("--resume")
    if deadline is not None:
        left = deadline - time.monotonic()
        if left < 30:
            return False
        command += ["--time-limit", f"{left:.0f}s"]
    with open(folder / "log.txt", "a") as log:
        status = subprocess.run(command, stdout=log, stderr=subprocess.STDOUT, env=environment()).returncode
    if status == SOME_FAILED:
        print(f"{run.name}: some samples failed, see {folder / 'log.txt'}", flush=True)
    elif status not in (0, STOPPED_EARLY):
        raise RunError(f"'{' '.join(command)}' ended with status {status}; see {folder / 'log.txt'}")
    return status != STOPPED_EARLY
