#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes what libFuzzer starts from: jobs/*.toml, the table of wrong inputs, solids of each format, and dictionaries of their words.

    write_corpus.py FOLDER      makes in FOLDER input-seeds/, input-words, solid-seeds/ and solid-words
"""
import hashlib
import pathlib
import random
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "cli"), str(ROOT / "tools")]

from crackle_readme import block  # noqa: E402
from input_text import InputText  # noqa: E402
from solid_files import HUGE, WORDS, damaged, every_format  # noqa: E402
from wrong_inputs import CASES, FILES  # noqa: E402

EXTENSIONS = (".stl", ".obj", ".off", ".ply", ".msh", ".vtk")  # as in solid.h
MAX_SIZE = 16384  # longer seeds only slow the fuzzer down


def seeds():
    demo = (ROOT / "jobs" / "demo.toml").read_text()
    for setting in sorted((ROOT / "jobs").rglob("*.toml")):
        yield setting.read_bytes()
    bare = re.sub(r"(?m)\s*#.*$", "", demo)  # comments would only be mutated in vain
    for case in CASES:
        yield case.edit(InputText(bare)).text().encode()
    for _, content, _ in FILES:
        yield content


def words():
    """Keys, tables, words and units out of the table of keys, and what TOML itself is made of."""
    table = block("keys")
    found = set(re.findall(r"`([^`]*)`", table))
    quoted = set(re.findall(r'"([^"]*)"', table))
    found |= quoted | {f'"{word}"' for word in quoted}
    found |= {'"""', "'''", "[[", "]]", "inf", "nan", "true", "1e400", "-1", "0x", "1979-05-27", "\\u00e9", "\u00b5m",
              "{ y = [", "\r\n", "MPa^2.5 s", "MPa m^(1/2)", "sqrt(m)", "+", "_"}
    return sorted(word for word in found if word)


def solid_seeds():
    """Sound and damaged files, each after the number of its format (fuzz_solid.cpp)."""
    stream = random.Random(1)
    for extension, content in every_format():
        for one in (content, *(damaged(stream, content) for _ in range(20))):
            yield bytes([EXTENSIONS.index(extension)]) + one


def solid_words():
    of_files = {word for _, content in every_format() for word in re.findall(r"[$\w]+", content.decode("latin-1")) if word.isascii()}
    return sorted(of_files.union(WORDS, map(str, HUGE)))


def write(folder, name, all_seeds, all_words):
    seeds_folder = folder / f"{name}-seeds"
    seeds_folder.mkdir(parents=True, exist_ok=True)
    short = [content for content in all_seeds if len(content) <= MAX_SIZE]
    for content in short:
        (seeds_folder / hashlib.sha1(content).hexdigest()).write_bytes(content)
    with open(folder / f"{name}-words", "w", encoding="ascii") as file:
        for word in all_words:
            file.write('"' + "".join(f"\\x{byte:02x}" for byte in word.encode()) + '"\n')
    print(f"{len(short)} of {name} to start from")


def main():
    folder = pathlib.Path(sys.argv[1])
    write(folder, "input", seeds(), words())
    write(folder, "solid", solid_seeds(), solid_words())


if __name__ == "__main__":
    main()
