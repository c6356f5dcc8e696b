# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes files."""
from __future__ import annotations

import os
import re
from pathlib import Path


def write_whole(file: Path, content: bytes) -> None:
    """Replaces a file in one step, so that a reader never sees half of it."""
    partial = file.with_name(file.name + ".partial")
    partial.write_bytes(content)
    os.replace(partial, file)


def put_between_marks(file: Path, place: str, text: str) -> None:
    """Replaces what is between <!-- place:begin --> and <!-- place:end --> in a Markdown file.

    @raise ValueError: the file has no such place
    """
    begin, end = f"<!-- {place}:begin -->\n", f"<!-- {place}:end -->"
    whole, n = re.subn(f"{begin}.*?{end}", lambda _: begin + text + end, file.read_text(), flags=re.DOTALL)
    if n != 1:
        raise ValueError(f"{file} has no place for '{place}'")
    write_whole(file, whole.encode())
