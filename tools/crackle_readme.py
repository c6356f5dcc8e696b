# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of the READMEs that programs print, and which file holds each.

A part stands between <!-- name:begin --> and <!-- name:end -->.
"""
from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BLOCKS = {
    "picture": "README.md",
    "keys": "jobs/input.md",  # crackle check --keys
    "results": "jobs/results.md",  # crackle stats --columns
    "benchmark": "tests/benchmark/README.md",  # tools/benchmark
    **{name: "jobs/verification/README.md" for name in ("verification", "interface", "nucleation", "fast")},  # jobs/verification/verify --readme
    # jobs/gallery/gallery --keep
    **{name: "jobs/gallery/README.md" for name in ("paper-plate", "pmma-strip", "glass-plate", "compact-tension", "bend-bar", "knife-edge-disk",
                                                   "brazilian-disk", "uncertain-strip", "slotted-hole", "semicircular-bend",
                                                   "semicircular-bend-calibrated", "alumina-bars", "small-alumina-bars")},
}


def file_of(name: str) -> Path:
    """The README that holds a block."""
    return ROOT / BLOCKS[name]


def block(name: str) -> str:
    """What a block holds now.

    @raise ValueError: its file does not have it, or has it more than once
    """
    file = file_of(name)
    found = re.findall(_pattern(name), file.read_text(encoding="utf-8"), re.DOTALL)
    if len(found) != 1:
        raise ValueError(f"{file} has {len(found)} blocks '{name}'")
    return found[0]


def put_block(name: str, text: str, file: Path | None = None) -> None:
    """Replaces what a block holds, in its own file or in another one that has it.

    @raise ValueError: the file does not have it, or has it more than once
    """
    file = file or file_of(name)
    begin, end = _marks(name)
    whole, n = re.subn(_pattern(name), lambda _: begin + text + end, file.read_text(encoding="utf-8"), flags=re.DOTALL)
    if n != 1:
        raise ValueError(f"{file} has {n} blocks '{name}'")
    file.write_text(whole, encoding="utf-8")


def _marks(name: str) -> tuple[str, str]:
    return f"<!-- {name}:begin -->\n", f"<!-- {name}:end -->"


def _pattern(name: str) -> str:
    begin, end = _marks(name)
    return f"{re.escape(begin)}(.*?){re.escape(end)}"
