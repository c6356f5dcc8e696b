# SPDX-License-Identifier: GPL-3.0-or-later
"""Starts a command in a Python that has its libraries."""
from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path

DISTRIBUTION = "/usr/bin/python3"  # has what tools/setup installs, where another Python comes first on the PATH


def start(module: str) -> int:
    """Calls the module's main(); the exit status."""
    try:
        main = importlib.import_module(module).main
    except ModuleNotFoundError as error:
        is_other = sys.prefix != sys.base_prefix or os.path.realpath(sys.executable) != os.path.realpath(DISTRIBUTION)
        if is_other and os.access(DISTRIBUTION, os.X_OK):
            os.execv(DISTRIBUTION, [DISTRIBUTION, *sys.argv])
        print(f"{Path(sys.argv[0]).name}: Python's package {error.name} is missing; tools/setup demo installs what is needed on "
              f"Debian, and 'pip install {Path(__file__).resolve().parent}' elsewhere", file=sys.stderr)
        return 1
    return main()
