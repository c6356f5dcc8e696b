# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes files."""
from __future__ import annotations

import os
from pathlib import Path


def write_whole(file: Path, content: bytes) -> None:
    """Replaces a file in one step, so that a reader never sees half of it."""
    partial = file.with_name(file.name + ".partial")
    partial.write_bytes(content)
    os.replace(partial, file)
