# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of the READMEs that programs print, and which file holds each.

A part stands between <!-- name:begin --> and <!-- name:end -->. Run as a program, this file writes the guide's keys of usual tests.
"""
from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BLOCKS = {
    "picture": "README.md",
    "keys": "jobs/input.md",  # crackle check --keys
    "tests": "jobs/guide.md",  # tools/crackle_readme.py
    "stats": "jobs/guide.md",  # crackle stats out/own
    "results": "jobs/results.md",  # crackle stats --columns
    "benchmark": "tests/benchmark/README.md",  # tools/benchmark
    "peers": "tests/benchmark/README.md",  # tools/benchmark --peers --readme
    "scaling": "tests/benchmark/README.md",  # tools/benchmark --scaling --readme
    **{name: "jobs/verification/README.md" for name in ("verification", "interface", "nucleation", "solids", "fast")},  # jobs/verification/verify --readme
    "campaigns": "jobs/paper/README.md",  # jobs/paper/campaigns --keep
    "studies": "jobs/paper/README.md",  # jobs/paper/studies --keep
    # jobs/gallery/gallery --keep
    **{name: "jobs/gallery/README.md" for name in ("paper-plate", "pmma-strip", "glass-plate", "compact-tension", "bend-bar", "knife-edge-disk", "twisted-rod",
                                                   "brazilian-disk", "uncertain-strip", "slotted-hole", "semicircular-bend",
                                                   "semicircular-bend-calibrated", "alumina-bars", "small-alumina-bars")},
}

# The usual tests, an input with each, and its tables that make it this test.
TESTS = {
    "Grips that move": ("gallery/layered-plate.toml", {"boundary": slice(None)}),
    "Three-point bend in plane strain": ("verification/bent-bar.toml", {"boundary": slice(None)}),
    "Four-point bend on rollers": ("gallery/bend-bar.toml", {"boundary": slice(None)}),
    "Compact tension": ("gallery/compact-tension.toml", {"specimen": ("hole", "notch"), "boundary": slice(None)}),
    "Disk between platens": ("gallery/brazilian-disk.toml", {"specimen": ("outline", "radius"), "boundary": slice(None)}),
    "Pressure in a bore": ("gallery/ring.toml", {"boundary": slice(None)}),
    "Impact": ("verification/kalthoff.toml", {"boundary": slice(3, 4), "time": ("start",)}),
    "Strained first, then cracked": ("verification/pmma-strip.toml", {"boundary": slice(None), "time": ("start",)}),
    "Quench": ("gallery/quenched-alumina.toml", {"initial.stress": slice(0, 1)}),
    "Layers": ("gallery/layered-plate.toml", {"specimen": ("region",), "material": slice(None), "interface": slice(None)}),
}
MOST_SHOWN = 4  # entries of an array


def tests_with_keys() -> str:
    """The part `tests`: of each usual test the keys that make it one, as its input has them."""
    return "\n".join(f"**{test}** ([{Path(file).name}]({file}))\n\n```text\n{_excerpt(ROOT / 'jobs' / file, tables)}```\n"
                     for test, (file, tables) in TESTS.items())


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


def _excerpt(file: Path, tables: dict[str, slice | tuple[str, ...]]) -> str:
    """Some tables of an input, or some keys of them, with each condition on one line."""
    lines = []
    for name, part in tables.items():
        table = tomllib.loads(file.read_text(encoding="utf-8"))
        for key in name.split("."):
            table = table[key]
        if isinstance(part, slice):
            lines.append(_assignment(name, table[part]))
        else:
            lines += [_assignment(f"{name}.{key}", table[key]) for key in part]
    return "".join(lines)


def _assignment(key: str, value: object) -> str:
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return f"{key} = [{(',' + chr(10) + ' ' * (len(key) + 4)).join(map(_inline, value))}]\n"
    return f"{key} = {_inline(value)}\n"


def _inline(value: object) -> str:
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {_inline(inner)}' for key, inner in value.items())} }}"
    if isinstance(value, list):
        shown = [*map(_inline, value)] if len(value) <= MOST_SHOWN else [*map(_inline, value[:2]), "..."]
        return f"[{', '.join(shown)}]"
    return json.dumps(value)


if __name__ == "__main__":
    put_block("tests", tests_with_keys())
