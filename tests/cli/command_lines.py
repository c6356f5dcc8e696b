# SPDX-License-Identifier: GPL-3.0-or-later
"""Command lines of the program without a start of the program for each: one process runs them one after the other.

It is the driver of command_lines.cpp, which lies beside the program; what a command does in Python is done by a copy of another
process. Tests of signals, of several ranks, of limits on a process
and of what MPI does when it starts need the program itself.
"""
from __future__ import annotations

import atexit
import functools
import json
import os
import select
import shutil
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2] / "tools"))

from crackle_launch import environment  # noqa: E402
from python_server import Server  # noqa: E402

TIMEOUT = 300  # seconds


class _Driver:
    def __init__(self, program: Path):
        self.program = str(program)
        self.folder = Path(tempfile.mkdtemp(prefix="crackle-commands-"))
        atexit.register(shutil.rmtree, self.folder, ignore_errors=True)
        self.process = subprocess.Popen([program.with_name("command_lines")], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        env=environment(), cwd="/")
        atexit.register(self.end)

    def end(self) -> int:
        """Waits for the process, which ends with its requests; a status as subprocess has it."""
        assert self.process.stdin and self.process.stdout
        if self.process.poll() is None:
            self.process.stdin.close()
        status = self.process.wait(timeout=TIMEOUT)
        self.process.stdout.close()
        return status

    def answer(self, words: list[str], folder: Path, variables: dict[str, str], timeout: float) -> int:
        assert self.process.stdin and self.process.stdout
        request = {"words": [self.program, *words], "folder": str(folder), "environment": variables,
                   "out": str(self.folder / "out"), "err": str(self.folder / "err")}
        self.process.stdin.write(json.dumps(request).encode() + b"\n")
        self.process.stdin.flush()
        if not select.select([self.process.stdout], [], [], timeout)[0]:
            self.process.kill()
            self.end()
            raise subprocess.TimeoutExpired(words, timeout)
        return int(answer) if (answer := self.process.stdout.readline()) else self.end()


def _is_in_python(words: list[str]) -> bool:
    return words[:1] in (["calibrate"], ["compare"], ["match"]) or "--from-ensemble" in words


@functools.cache
def _server() -> Server:
    server = Server(environment())
    atexit.register(server.end)
    return server


def with_server() -> dict[str, str]:
    """The environment variable with which the program finds Python's server."""
    return {"PATH": f"{_server().path}:{os.environ['PATH']}"}


_drivers: dict[Path, _Driver] = {}
_one_at_a_time = threading.Lock()


def crackle(program: os.PathLike | str, *words: object, cwd: os.PathLike | str | None = None, errors: str = "strict",
            timeout: float = TIMEOUT, **variables: str) -> subprocess.CompletedProcess[str]:
    """What `program *words` prints and returns, as subprocess.run(..., capture_output=True, text=True) would tell.

    @param variables of the environment, besides those of crackle_launch.environment()
    """
    program, texts = Path(os.path.abspath(program)), [str(word) for word in words]
    with _one_at_a_time:
        driver = _drivers.get(program)
        if driver is None or driver.process.poll() is not None:
            driver = _drivers[program] = _Driver(program)
        if _is_in_python(texts):
            variables = {**with_server(), **variables}
        status = driver.answer(texts, Path(cwd or Path.cwd()).resolve(), variables, timeout)
        out, err = ((driver.folder / name).read_text(errors=errors) for name in ("out", "err"))
    return subprocess.CompletedProcess([str(program), *texts], status, out, err)
