# SPDX-License-Identifier: GPL-3.0-or-later
"""Commands in Python, called in the test's own process: a process of their own would first import matplotlib for seconds."""
from __future__ import annotations

import contextlib
import io
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Callable, Sequence
from unittest import mock

import matplotlib

sys.path.append(str(Path(__file__).resolve().parents[2] / "tools"))

from crackle_report import command, style  # noqa: E402


def call(main: Callable[[], int], *arguments: object) -> subprocess.CompletedProcess:
    """The outcome that a process calling main() with these arguments would have."""
    out, err = io.StringIO(), io.StringIO()
    words = [str(argument) for argument in arguments]
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), warnings.catch_warnings(), \
            mock.patch.object(sys, "argv", ["called by a test", *words]):
        warnings.resetwarnings()  # as in a new process each shows once, but for those that are for developers
        for kind in (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning):
            warnings.simplefilter("ignore", kind)
        try:
            status = main()
        except SystemExit as end:
            status = end.code
            if isinstance(status, str):
                print(status, file=err)
                status = 1
    return subprocess.CompletedProcess(words, status or 0, out.getvalue(), err.getvalue())


def report(*arguments: object, kind: str | None = None, sections: Sequence[Callable] | None = None) -> subprocess.CompletedProcess:
    """crackle-report, for tests of what it says: it makes pictures of these sections of a plate (default: of all), and their files stay empty,
    except those of `kind` ("png" or "svg"), which are drawn coarsely."""
    apply, save = style.apply, matplotlib.figure.Figure.savefig

    def apply_coarsely() -> None:
        apply()
        matplotlib.rcParams["savefig.dpi"] = 40

    def save_once(figure: matplotlib.figure.Figure, file: io.BytesIO, **options: object) -> None:
        if options["format"] == kind:
            save(figure, file, **options)

    with matplotlib.rc_context(), mock.patch.object(style, "apply", apply_coarsely), \
            mock.patch.object(command, "SECTIONS", command.SECTIONS if sections is None else tuple(sections)), \
            mock.patch.object(matplotlib.figure.Figure, "savefig", save_once):
        return call(command.main, *arguments)
