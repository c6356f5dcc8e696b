# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of a command that is in Python, for command_lines.py: in a copy of a process that has loaded SciPy and pandas before.

The folder of a Server is put first on the PATH. Its `python3` sends what it was called with, and its streams, to the process,
which carries it out in a copy of itself.
"""
from __future__ import annotations

import atexit
import gc
import json
import os
import runpy
import select
import shlex
import socket
import subprocess
import sys
import tempfile
import traceback
from pathlib import Path

ADDRESS = "socket"


class Server:
    """A Python process, in the environment of crackle_launch."""

    def __init__(self, environment: dict[str, str]) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="crackle-python-")
        self.path = Path(self._folder.name)
        words = [sys.executable, "-I", "-B", __file__, str(self.path / ADDRESS)]
        self.process = subprocess.Popen([*words, "serve"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment, cwd="/")
        assert self.process.stdout
        self.process.stdout.readline()  # it listens
        shim = self.path / "python3"
        shim.write_text(f'#!/bin/sh\nexec {shlex.join(words)} call "$@"\n')
        shim.chmod(0o755)

    def end(self) -> None:
        """The process ends with its standard input."""
        self.process.communicate()
        self._folder.cleanup()


def call(address: str, words: list[str]) -> int:
    """In the place of `python3 words`; the exit status."""
    with socket.socket(socket.AF_UNIX) as connection:
        connection.connect(address)
        request = json.dumps([words, os.getcwd(), dict(os.environ)]).encode()
        socket.send_fds(connection, [request[:1]], [0, 1, 2])
        connection.sendall(request[1:])
        connection.shutdown(socket.SHUT_WR)
        answer = connection.recv(1)
    return answer[0] if answer else 70  # it was killed


def carry_out(connection: socket.socket) -> int:
    first, streams, _, _ = socket.recv_fds(connection, 1, 3)
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    with connection.makefile("rb") as rest:
        words, folder, environment = json.loads(first + rest.read())
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    sys.argv = [word for word in words if word != "-B"]
    try:
        runpy.run_path(sys.argv[0], run_name="__main__")
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0 if end.code is None else 1
    except BaseException:
        traceback.print_exc()
        return 1
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
    return 0


def serve(address: str) -> None:
    import h5py, pandas, scipy.cluster.hierarchy, scipy.optimize, scipy.signal, scipy.stats, xarray  # noqa: E401, F401
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(address)
        listener.listen()
        print(flush=True)
        gc.freeze()  # a collection in a copy would write to every object, and so copy the memory
        while listener in select.select([listener, sys.stdin], [], [])[0]:
            connection, _ = listener.accept()
            if os.fork() == 0:
                listener.close()
                status = carry_out(connection)
                atexit._run_exitfuncs()  # removes what it made
                connection.send(bytes([status]))
                os._exit(0)  # to take all modules apart would copy the memory as well
            connection.close()
            os.wait()


if __name__ == "__main__":
    if sys.argv[2] == "serve":
        serve(sys.argv[1])
    else:
        sys.exit(call(sys.argv[1], sys.argv[3:]))
