# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands of the program that are carried out here; it has checked their options."""
from __future__ import annotations

import argparse
import sys
from pathlib import Path

from .experiments import ExperimentsError
from .files import ResultsError


def main() -> int:
    """The exit status."""
    parser = argparse.ArgumentParser(prog="crackle")
    commands = parser.add_subparsers(dest="command", required=True)
    compare = commands.add_parser("compare")
    compare.add_argument("folders", nargs="+")
    compare.add_argument("--confidence", type=float, default=0.95)
    compare.add_argument("--json", action="store_true")
    calibrate = commands.add_parser("calibrate")
    calibrate.add_argument("folder", type=Path)
    calibrate.add_argument("experiments", type=Path)
    calibrate.add_argument("-o", "--output", type=Path)
    for option in ("--discrepancy", "--between-specimens", "--equal-specimens", "--json"):
        calibrate.add_argument(option, action="store_true")
    arguments = parser.parse_args()
    try:
        print({"compare": _compare, "calibrate": _calibrate}[arguments.command](arguments), end="", flush=True)
    except ExperimentsError as error:
        print(error, file=sys.stderr)
        return 1
    except ResultsError as error:
        print(f"crackle: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"crackle: standard output cannot be written: {error.strerror}", file=sys.stderr)
        return 1
    return 0


def _compare(arguments: argparse.Namespace) -> str:
    from .comparison import compare
    found = compare(*arguments.folders, confidence=arguments.confidence)
    return found.json if arguments.json else str(found)


def _calibrate(arguments: argparse.Namespace) -> str:
    from .calibration import calibrate
    _refuse_existing(arguments.output)
    found = calibrate(arguments.folder, arguments.experiments, arguments.discrepancy,
                      True if arguments.between_specimens else False if arguments.equal_specimens else None)
    if arguments.output:
        _refuse_existing(arguments.output)
        arguments.output.write_text(found.tables)
    return found.json if arguments.json else str(found)


def _refuse_existing(file: Path | None) -> None:
    if file is not None and file.exists():
        raise ResultsError(f"{file} already exists; give another name")
