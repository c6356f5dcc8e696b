# SPDX-License-Identifier: GPL-3.0-or-later
"""What tools and studies share: inputs derived from another one, runs of the program, what they gave, tables of it."""
from __future__ import annotations

import argparse
import contextlib
import functools
import re
import shutil
import signal
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import IO, Callable, Iterable

import crackle
import numpy as np
from crackle.files import ENSEMBLE_KIND, results as opened
from crackle_launch import environment, mpirun

ROOT = Path(__file__).resolve().parents[1]
JOBS = ROOT / "jobs" / "verification"


class RunError(Exception):
    """A run of the program failed; the message says why."""


def command(parser: argparse.ArgumentParser, name: str, work: Callable[[argparse.Namespace], int]) -> int:
    """The main function of a study: adds --output (out/`name`) and --program, builds the program where there is none.

    @return exit status: that of `work`, or 1 when it raises RunError, whose message is printed
    """
    in_source = (ROOT / "tools" / "build").is_file()
    program = ROOT / "build" / "bin" / "crackle" if in_source else ROOT.parents[1] / "bin" / "crackle"
    parser.add_argument("-o", "--output", type=Path, default=(ROOT if in_source else Path.cwd()) / "out" / name,
                        help="folder of the runs (%(default)s)")
    parser.add_argument("--program", type=Path, default=program)
    arguments = parser.parse_args()
    if in_source and not arguments.program.is_file():
        subprocess.run([str(ROOT / "tools" / "build")], check=True)
    try:
        return work(arguments)
    except RunError as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return 1


def markdown(titles: Iterable[str], lines: Iterable[Iterable[str]]) -> str:
    """A table; each line ends with a line feed."""
    titles = list(titles)
    rows = [f"| {' | '.join(line)} |\n" for line in (titles, *lines)]
    return "".join([rows[0], "|" + "---|" * len(titles) + "\n", *rows[1:]])


def median_range(values: Iterable[float | None], form: str, unit: str = "", shares: tuple[float, float] = (0, 1)) -> str:
    """Median and range of those that are there, or other quantiles, and how many when some are not."""
    values = list(values)
    there = [value for value in values if value is not None and not np.isnan(value)]
    if not there:
        return "none"
    low, high = np.quantile(there, shares)
    text = f"{np.median(there):{form}}{unit} ({low:{form}} to {high:{form}})"
    return text if len(there) == len(values) else f"{text}, {len(there)} of {len(values)}"


@functools.cache
def model_of(program: Path) -> int:
    """The number that changes whenever results of some inputs do."""
    printed = subprocess.run([str(program), "--version"], capture_output=True, text=True, env=environment(), check=False).stdout
    if (found := re.search(r"(?m)^results of model (\d+),", printed)) is None:
        raise RunError(f"'{program} --version' names no model of its results")
    return int(found[1])


def with_keys(text: str, keys: dict[str, str]) -> str:
    """The input text with other values: {"mesh.spacing": '"1 mm"'}; a missing key is added to its table.

    Of several [[tables]] of one name the first one changes. A value None removes the key.

    @raise RunError: the text is no TOML, or writes the table or the key in another way than as a heading and a line
    """
    text = text if text.endswith("\n") else text + "\n"
    for key, value in keys.items():
        table, name = key.rsplit(".", 1)
        match = re.search(rf"(?m)^\[\[?{re.escape(table)}\]\]?.*$", text)
        if match is None:
            raise RunError(f"the input has no line [{table}], under which {name} could stand")
        start = match.end()
        following = re.search(r"(?m)^\[", text[start:])
        end = start + following.start() if following else len(text)
        body = re.sub(rf"(?m)^{re.escape(name)} *=.*\n", "", text[start:end])
        if value is not None:
            body = f"\n{name} = {value}" + body
        text = text[:start] + body + text[end:]
    try:
        found = tomllib.loads(text)
        for key, value in keys.items():
            *path, name = key.split(".")
            place = found
            for step in path:
                place = place[step] if isinstance(place, dict) else place[0][step]
            place = place if isinstance(place, dict) else place[0]
            if (name in place) != (value is not None):
                raise RunError(f"{key} must stand in a line of its own, beginning with {name} =")
    except tomllib.TOMLDecodeError as error:
        raise RunError(f"the input with other values of {', '.join(keys)}: {error}") from None
    return text


SOME_FAILED = 2


def run(text: str, folder: Path, program: Path, may_fail: bool = False, ranks: int = 1, beside: Iterable[Path] = ()) -> crackle.Ensemble:
    """The samples of an input, computed in `folder`; a run that was stopped goes on, finished ones are not computed again. Samples are
    added where the folder has the same input with fewer; where it has more, they stay.

    @param may_fail: some samples may fail; without it that is a RunError
    @param ranks: of mpirun, a master and workers; 1 without mpirun
    @param beside: files that the input finds beside itself
    """
    folder.mkdir(parents=True, exist_ok=True)
    source = folder / "input.toml"
    copies = [(file, folder / file.name) for file in beside]
    before = source.read_text() if source.is_file() else ""
    unchanged = without_samples(before) == without_samples(text) and all(
        copy.is_file() and copy.read_bytes() == file.read_bytes() for file, copy in copies)
    is_enough = unchanged and _n_samples(before) >= _n_samples(text)
    results = folder / "out"
    if not (is_enough and (results / "ensemble.h5").is_file() and (folder / "done").is_file()):
        source.write_text(text)
        for file, copy in copies:
            shutil.copy(file, copy)
        (folder / "done").unlink(missing_ok=True)
        if not unchanged:
            shutil.rmtree(results, ignore_errors=True)
        resume = ["--resume"] if results.is_dir() else []
        with open(folder / "log.txt", "a" if resume else "w") as log:
            launcher = mpirun(ranks) if ranks > 1 else []
            status = status_of([*launcher, str(program), "run", str(source), "-o", str(results), *resume], log)
        if status != 0 and not (may_fail and status == SOME_FAILED):
            raise RunError(f"'{program} run {source}' ended with status {status}; see {folder / 'log.txt'}")
        (folder / "done").touch()
    else:
        _tell_other_commit(results / "ensemble.h5", program)
    return crackle.open(results)


def without_samples(text: str) -> str:
    """An input without the number of its samples: what makes a sample what it is."""
    return re.sub(r"(?m)^samples *=.*\n", "", text)


def _n_samples(text: str) -> int:
    return tomllib.loads(text)["ensemble"]["samples"]


def status_of(command: list[str], log: IO) -> int:
    """Runs the program, its lines in the log. At SIGINT and SIGTERM it is asked to suspend what is under way, and waited for.

    @raise RunError: one of them came
    """
    came: list[int] = []

    def pass_on(number: int, _: object) -> None:
        came.append(number)
        # mpirun hands SIGUSR1 on, and soon kills what others do not end at once; a second signal is to end it.
        with contextlib.suppress(NameError):  # it has not started yet
            process.send_signal(signal.SIGUSR1 if len(came) == 1 else number)

    before = {number: signal.signal(number, pass_on) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        # In a session of its own: the terminal's Ctrl-C would come on top of the one that is passed on.
        process = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT, env=environment(), start_new_session=True)
        if came:
            process.send_signal(signal.SIGUSR1)
        status = process.wait()
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    if came:
        raise RunError(f"stopped by {signal.Signals(came[0]).name}; the same command continues")
    return status


def _tell_other_commit(ensemble: Path, program: Path) -> None:
    """Says so when results that are there come from another commit of the program; most commits change no figure."""
    version = subprocess.run([str(program), "--version"], capture_output=True, text=True, env=environment()).stdout
    with opened(ensemble, ENSEMBLE_KIND) as root:
        commit = root.attrs["git_commit"]
    if commit not in version:
        print(f"{ensemble.parent} is kept from commit {commit[:7]}; remove it to compute it again", file=sys.stderr)
