# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands of the program that are carried out here; it has checked their options."""
from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from .experiments import ExperimentsError
from .files import ResultsError
from .text import json_text


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
    match = commands.add_parser("match")
    match.add_argument("folder", type=Path)
    match.add_argument("experiments", type=Path, nargs="?")
    match.add_argument("--held-out")
    match.add_argument("--of", type=Path)
    match.add_argument("--json", action="store_true")
    init = commands.add_parser("init")
    init.add_argument("input", type=Path)
    init.add_argument("--from-ensemble", required=True)
    arguments = parser.parse_args()
    try:
        text = {"compare": _compare, "calibrate": _calibrate, "match": _match, "init": _init}[arguments.command](arguments)
    except ExperimentsError as error:
        print(error, file=sys.stderr)
        return 1
    except (ResultsError, OSError) as error:
        print(f"crackle: {error}", file=sys.stderr)
        return 1
    try:
        print(text, end="", flush=True)
    except OSError as error:
        print(f"crackle: standard output cannot be written: {error.strerror}", file=sys.stderr)
        return 1
    return 0


def _compare(arguments: argparse.Namespace) -> str:
    from .comparison import compare
    found = compare(*arguments.folders, confidence=arguments.confidence)
    return _printed(found, arguments)


def _calibrate(arguments: argparse.Namespace) -> str:
    from .calibration import calibrate
    if arguments.output:
        _write_new(arguments.output, "")
        arguments.output.unlink()
    found = calibrate(arguments.folder, arguments.experiments, arguments.discrepancy,
                      True if arguments.between_specimens else False if arguments.equal_specimens else None)
    if arguments.output:
        _write_new(arguments.output, found.tables)
    return _printed(found, arguments)


def _match(arguments: argparse.Namespace) -> str:
    from . import match_text, matching
    from .observations import observed_samples
    if arguments.held_out is None:
        found = matching.match(arguments.folder, arguments.experiments)
        return _printed(found, arguments)
    samples = observed_samples(arguments.folder, True)
    if arguments.held_out != "each":
        found = matching.match_with(*matching.hold_out(samples, int(arguments.held_out)))
        return _printed(found, arguments)
    rows = matching.p_values_of(observed_samples(arguments.of, True) if arguments.of else samples, samples)
    if arguments.json:
        return json_text([{"sample": number, "p_value": p} for number, p in rows.items()])
    return match_text.held_out_text(rows, str(arguments.of or ""), samples.share_base)


def _init(arguments: argparse.Namespace) -> str:
    from .experiments_template import template
    from .observations import observed_samples
    file, folder = arguments.input, arguments.from_ensemble
    _refuse_existing(file)
    _write_new(file, template(observed_samples(Path(folder), False), folder))
    return (f"{file}: a made-up experiment, to be replaced by yours; to set another key, take away the # before it\n"
            f"crackle match {folder} {file}\n")


def _printed(found: Any, arguments: argparse.Namespace) -> str:
    return found.json if arguments.json else str(found)


def _write_new(file: Path, text: str) -> None:
    _refuse_existing(file)
    try:
        with open(file, "x", encoding="utf-8") as stream:
            stream.write(text)
    except OSError as error:
        raise ResultsError(f"'{file}' cannot be written: {error.strerror}") from error


def _refuse_existing(file: Path) -> None:
    if file.exists():
        raise ResultsError(f"{file} already exists; give another name")
