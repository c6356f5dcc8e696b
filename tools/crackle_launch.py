# SPDX-License-Identifier: GPL-3.0-or-later
"""How tools and tests in Python start the program: the launcher and the environment of tools/environment.sh."""
from __future__ import annotations

import atexit
import functools
import itertools
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

SETTINGS = Path(__file__).resolve().parent / "environment.sh"
_CALLS = itertools.count()


@functools.cache
def _session_folder() -> str:
    folder = tempfile.mkdtemp(prefix="crackle-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def _without_daemon() -> dict[str, str]:
    """How a single rank starts without Open MPI's daemon, which takes a third of a short run.

    Without a daemon the session directory has the name that every such process gives its own, and the first to end removes it;
    so each call has a place for it.
    """
    return {"OMPI_MCA_ess_singleton_isolated": "1", "OMPI_MCA_orte_tmpdir_base": f"{_session_folder()}/{next(_CALLS)}"}


@functools.cache
def _settings() -> dict[str, str]:
    """What the environment is after tools/environment.sh."""
    text = subprocess.run(["bash", "-c", 'source "$1" && env -0', "bash", str(SETTINGS)], check=True, capture_output=True,
                          text=True).stdout
    return dict(entry.split("=", 1) for entry in text.split("\0") if "=" in entry)


def environment(**more: str) -> dict[str, str]:
    """For one call of subprocess: this process' environment, what Open MPI needs on any one machine, and more."""
    needed = {name: value for name, value in _settings().items() if name.startswith(("OMPI_", "OMP_", "OPENBLAS_", "HWLOC_"))}
    return {**os.environ, **needed, **_without_daemon(), **more}


def mpirun(n_ranks: int, binding: str | None = None) -> list[str]:
    """The words before the program's; `binding` is for --bind-to, such as "core", instead of none."""
    return [_settings()["MPIRUN"], *(["--bind-to", binding] if binding else []), "-n", str(n_ranks)]
