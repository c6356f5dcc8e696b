# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands of the program that are carried out here; it has checked their options."""
from __future__ import annotations

import argparse
import sys

from .files import ResultsError


def main() -> int:
    """The exit status."""
    parser = argparse.ArgumentParser(prog="crackle")
    commands = parser.add_subparsers(dest="command", required=True)
    compare = commands.add_parser("compare")
    compare.add_argument("folders", nargs="+")
    compare.add_argument("--confidence", type=float, default=0.95)
    compare.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    try:
        print({"compare": _compare}[arguments.command](arguments), end="", flush=True)
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
