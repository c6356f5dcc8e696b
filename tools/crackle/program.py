# SPDX-License-Identifier: GPL-3.0-or-later
"""Asks the program: what follows from an ensemble's files or its input is computed there, and nowhere else."""
from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any, Optional

from .files import ResultsError, check_folder

_HERE = Path(__file__).resolve()
# In the source tree, and beside share/crackle where it is installed.
_PLACES = tuple(_HERE.parents[k].joinpath(*place) for k, place in ((2, ("build", "bin", "crackle")), (4, ("bin", "crackle")))
                if len(_HERE.parents) > k)


def find_program(given: str | Path | None = None) -> str:
    """The one that is given, else that of the environment's CRACKLE, of the project's build, or on the PATH."""
    if wanted := given or os.environ.get("CRACKLE"):
        if found := shutil.which(str(wanted)):
            return found
        raise ResultsError(f"there is no program '{wanted}'")
    for place in (*_PLACES, "crackle"):
        if found := shutil.which(str(place)):
            return found
    raise ResultsError("the program crackle is neither at build/bin/crackle nor on the PATH: build it with "
                       "tools/build, or give its path with --program or in the environment variable CRACKLE")


def statistics_of(folder: Path, program: str | Path | None = None, sensitivities: bool = True) -> dict[str, Any]:
    """What `crackle stats --json` says of an ensemble, whose files stay as they are. Raises ResultsError."""
    if folder.is_dir():
        check_folder(folder)
    return _ask(program, "stats", str(folder), "--json", "--read-only", *([] if sensitivities else ["--without-sensitivities"]),
                tells=not sensitivities)


def observed_of(folder: Path, program: str | Path | None = None) -> dict[str, Any]:
    """The document of `crackle observe`: the body of an ensemble and the samples that count. Raises ResultsError."""
    return _ask(program, "observe", str(folder), tells=True)


def _ask(program: str | Path | None, command: str, *arguments: str, tells: bool = False) -> dict[str, Any]:
    result = subprocess.run([find_program(program), command, *arguments], capture_output=True, text=True, check=False)
    if result.returncode != 0:
        reason = result.stderr.strip().removeprefix("crackle: ")
        raise ResultsError(reason or f"crackle {command} ended with status {result.returncode}")
    if tells:
        sys.stderr.write(result.stderr)  # samples that are left out
    return json.loads(result.stdout)
