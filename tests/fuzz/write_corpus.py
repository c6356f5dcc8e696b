#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes what libFuzzer starts from: jobs/*.toml, the table of wrong inputs, and a dictionary of the keys and words.

    write_corpus.py FOLDER      makes FOLDER/seeds/ and FOLDER/words
"""
import hashlib
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "cli"), str(ROOT / "tools")]

from crackle_readme import block  # noqa: E402
from input_text import InputText  # noqa: E402
from wrong_inputs import CASES, FILES  # noqa: E402

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


def main():
    folder = pathlib.Path(sys.argv[1])
    (folder / "seeds").mkdir(parents=True, exist_ok=True)
    n_written = 0
    for content in seeds():
        if len(content) <= MAX_SIZE:
            (folder / "seeds" / hashlib.sha1(content).hexdigest()).write_bytes(content)
            n_written += 1
    with open(folder / "words", "w", encoding="ascii") as file:
        for word in words():
            file.write('"' + "".join(f"\\x{byte:02x}" for byte in word.encode()) + '"\n')
    print(f"{n_written} inputs to start from")


if __name__ == "__main__":
    main()
