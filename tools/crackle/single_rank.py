# SPDX-License-Identifier: GPL-3.0-or-later
"""How a single rank of the program starts without Open MPI's daemon, in half of the time."""
from __future__ import annotations

import atexit
import functools
import itertools
import shutil
import tempfile

_CALLS = itertools.count()


@functools.cache
def _session_folder() -> str:
    folder = tempfile.mkdtemp(prefix="crackle-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def settings() -> dict[str, str]:
    """Environment variables for one call.

    Without a daemon the session directory has the name that every such process gives its own, and the first to end removes it;
    so each call has a place for it.
    """
    return {"OMPI_MCA_ess_singleton_isolated": "1", "OMPI_MCA_orte_tmpdir_base": f"{_session_folder()}/{next(_CALLS)}"}
