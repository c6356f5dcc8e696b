#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every wrong input ends with exit status 1, one line for each error, and nothing written.

Every case goes through each of the commands in one process, and every 32nd case through a start of the program too.
"""
import argparse
import os
import pathlib
import re
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))

import command_lines  # noqa: E402
from crackle_launch import environment  # noqa: E402
from input_text import InputText  # noqa: E402
from wrong_inputs import CASES, FILES  # noqa: E402

TIMEOUT = 60  # seconds; a run that waits for ever is a failure
REAL_EACH = 32  # cases, of which one starts the program


def invoke(program, command, name, folder):
    """Runs the command on the file `name` in `folder`; `command` may end with " in a process of its own"."""
    command, _, starts = command.partition(" ")
    arguments = [command, name] + (["-o", "out"] if command == "run" else [])
    if not starts:
        return command_lines.crackle(program, *arguments, cwd=folder, errors="replace", timeout=TIMEOUT)
    return subprocess.run([program, *arguments], cwd=folder, env=environment(), timeout=TIMEOUT, check=False,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="replace")


def general_faults(result, folder, before, n_errors):
    """What every refusal of an input must have in common."""
    faults = []
    if result.returncode != 1:
        faults.append(f"exit status {result.returncode} instead of 1")
    if result.stdout:
        faults.append(f"standard output: {result.stdout!r}")
    lines = result.stderr.splitlines()
    if len(lines) != n_errors:
        faults.append(f"{len(lines)} lines instead of {n_errors}")
    after = sorted(path.name for path in folder.rglob("*"))
    if after != before:
        faults.append(f"files written: {after}")
    return faults


def run_case(program, command, demo, case):
    with tempfile.TemporaryDirectory(prefix="crackle-cli-") as name:
        folder = pathlib.Path(name)
        text = case.edit(InputText(demo))
        (folder / "bad.toml").write_text(text.text())
        result = invoke(program, command, "bad.toml", folder)
        faults = general_faults(result, folder, ["bad.toml"], case.errors)
        lines = result.stderr.splitlines()
        places = [re.match(r"bad\.toml:(\d+): ", line) for line in lines]
        if not all(places):
            faults.append("a line does not begin with file:line:")
        else:
            numbers = [int(place.group(1)) for place in places]
            if numbers != sorted(numbers):
                faults.append(f"lines are not in order: {numbers}")
        expected = f"bad.toml:{text.line}: {case.key}"
        found = [line for line in lines if re.match(re.escape(expected) + r"[:; ]", line)
                 and all(part in line for part in case.parts)]
        if not found:
            faults.append(f"no line with {expected!r} and {case.parts}")
        if any(len(line) > 500 for line in lines):
            faults.append("a line is longer than 500 characters")
        return case.name, command, faults, result.stderr


def run_file(program, command, description, content, expected):
    with tempfile.TemporaryDirectory(prefix="crackle-cli-") as name:
        folder = pathlib.Path(name)
        (folder / "bad.toml").write_bytes(content)
        result = invoke(program, command, "bad.toml", folder)
        faults = general_faults(result, folder, ["bad.toml"], 1)
        if "bad.toml" + expected not in result.stderr:
            faults.append(f"no line with {expected!r}")
        return description, command, faults, result.stderr


def run_path(program, command, description, path, expected):
    """An input path at which there is no file; `folder` exists and is a folder."""
    with tempfile.TemporaryDirectory(prefix="crackle-cli-") as name:
        folder = pathlib.Path(name)
        (folder / "folder").mkdir()
        result = invoke(program, command, path, folder)
        faults = general_faults(result, folder, ["folder"], 1)
        if not re.match(rf"{re.escape(path)}: ?{re.escape(expected)}", result.stderr):
            faults.append(f"no line with {expected!r}")
        return description, command, faults, result.stderr


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", required=True)
    parser.add_argument("--demo", required=True, help="the input that is spoilt")
    parser.add_argument("--commands", nargs="+", default=["check"])
    parser.add_argument("--verbose", action="store_true", help="print every message")
    parser.add_argument("--only", default="", help="run the cases that have this in their names")
    parser.add_argument("--count", action="store_true", help="print the number of cases and run none")
    options = parser.parse_args()
    program = os.path.abspath(options.program)
    demo = pathlib.Path(options.demo).read_text()

    jobs = [(run_case, demo, case) for case in CASES]
    jobs += [(run_file, *file) for file in FILES]
    jobs += [(run_path, "missing file", "nowhere.toml", "there is no such file"),
             (run_path, "folder", "folder", "is a directory"),
             (run_path, "device without end", "/dev/zero", "1: longer than 131072 bytes"),
             (run_path, "empty device", "/dev/null", "1: the file has no keys")]
    jobs = [job for job in jobs if options.only in getattr(job[-1], "name", job[1])]
    if options.count:
        print(len(jobs))
        return 0
    if not jobs:
        sys.exit(f"no case has {options.only!r} in its name")
    n_failed = 0
    for i, (function, *arguments) in enumerate(jobs):
        commands = list(options.commands)
        if i % REAL_EACH == 0:
            commands.append(f"{commands[i // REAL_EACH % len(commands)]} in a process of its own")
        found = [function(program, command, *arguments) for command in commands]
        n_failed += any(faults for _, _, faults, _ in found)
        for name, command, faults, messages in found:
            if faults or options.verbose:
                print(f"{'FAILED' if faults else 'ok'}: {name} ({command})")
                for fault in faults:
                    print(f"    {fault}")
                for line in messages.splitlines():
                    print(f"    | {line}")
    print(f"{len(jobs) - n_failed} of {len(jobs)} wrong inputs are refused as they should be")
    return 1 if n_failed else 0


if __name__ == "__main__":
    sys.exit(main())
