# SPDX-License-Identifier: GPL-3.0-or-later
"""How tools and tests in Python start the program: the launcher and the environment of tools/environment.sh."""
from __future__ import annotations

import functools
import os
import subprocess
from pathlib import Path

from crackle import single_rank

SETTINGS = Path(__file__).resolve().parent / "environment.sh"


@functools.cache
def _settings() -> dict[str, str]:
    """What the environment is after tools/environment.sh."""
    text = subprocess.run(["bash", "-c", 'source "$1" && env -0', "bash", str(SETTINGS)], check=True, capture_output=True,
                          text=True).stdout
    return dict(entry.split("=", 1) for entry in text.split("\0") if "=" in entry)


def environment(**more: str) -> dict[str, str]:
    """For one call of subprocess: this process' environment, what Open MPI needs on any one machine, and more."""
    needed = {name: value for name, value in _settings().items() if name.startswith(("OMPI_", "OMP_", "OPENBLAS_", "HWLOC_"))}
    return {**os.environ, **needed, **single_rank.settings(), **more}


def mpirun(n_ranks: int, binding: str | None = None) -> list[str]:
    """The words before the program's; `binding` is for --bind-to, such as "core", instead of none."""
    return [_settings()["MPIRUN"], *(["--bind-to", binding] if binding else []), "-n", str(n_ranks)]
