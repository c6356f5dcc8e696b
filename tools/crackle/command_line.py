# SPDX-License-Identifier: GPL-3.0-or-later
"""Commands of the program that are written in Python, which it starts: `python -m crackle.command_line PROGRAM COMMAND WORDS...`."""
from __future__ import annotations

import argparse
import importlib.util
import sys
from pathlib import Path
from typing import NoReturn

COMMANDS = {"experiments-template": "experiments_template", "match": "match_command"}
NEEDED = ("h5py", "matplotlib", "numpy", "pandas", "scipy", "xarray")


for _name in NEEDED:  # before the command's own Python is chosen: tools/crackle_start.py
    if importlib.util.find_spec(_name) is None:
        raise ModuleNotFoundError(_name, name=_name)


class Parser(argparse.ArgumentParser):
    """As the program's own commands: errors on one line, with exit status 1."""

    def __init__(self, command: str, description: str) -> None:
        super().__init__(prog=f"crackle {command}", description=description, allow_abbrev=False,
                         epilog="Exit status: 0 whatever is found; 1 usage error, or an error in the experiments or the ensemble.")

    def error(self, message: str) -> NoReturn:
        print(f"crackle: {message}; see {self.prog} --help", file=sys.stderr)
        sys.exit(1)


def main() -> int:
    program, command, *words = sys.argv[1:]
    from . import ResultsError
    from .experiments import ExperimentsError
    try:
        status = importlib.import_module(f".{COMMANDS[command]}", __package__).main(words, Path(program))
        sys.stdout.flush()
        return status
    except ExperimentsError as error:  # its lines start with the file's name
        print(error, file=sys.stderr)
    except ResultsError as error:
        print(f"crackle: {error}", file=sys.stderr)
    except ModuleNotFoundError as error:
        print(f"crackle: {error}", file=sys.stderr)
    except OSError as error:
        print(f"crackle: standard output cannot be written: {error.strerror}", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
