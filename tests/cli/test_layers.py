#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The folders of the source include each other in one direction only, and nothing below apps/ knows the world."""
from __future__ import annotations

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ORDER = ["common", "parallel", "solid", "plane", "input", "uncertainty", "geometry", "kernels", "mechanics", "fracture", "dynamics", "cracks", "analysis", "io",
         "ensemble"]
"""A folder may include itself and those before it; src/README.md says what each is about."""

INCLUDE = re.compile(r'^#include "(\w+)/[\w/]+\.h"', re.MULTILINE)
PROCESS_WIDE = re.compile(r"\bMPI_COMM_WORLD\b|\bPETSC_COMM_WORLD\b|\b(?:std::)?exit\(|\bMPI_Init(?:_thread)?\(|\bPetscInitialize")


def sources(folder: str) -> list[Path]:
    return [file for file in sorted((ROOT / "src" / folder).glob("*")) if file.suffix in (".h", ".cpp")]


class Layers(unittest.TestCase):
    def test_every_folder_has_its_place(self):
        folders = {path.name for path in (ROOT / "src").iterdir() if path.is_dir()}
        self.assertEqual(folders, set(ORDER))

    def test_includes_go_one_way(self):
        for place, folder in enumerate(ORDER):
            for file in sources(folder):
                for included in INCLUDE.findall(file.read_text()):
                    with self.subTest(file=str(file.relative_to(ROOT))):
                        self.assertIn(included, ORDER[:place + 1], "includes a folder above its own")

    def test_no_file_is_included_that_does_not_exist(self):
        for folder in ORDER:
            for file in sources(folder):
                for name in re.findall(r'^#include "([^"]+)"', file.read_text(), re.MULTILINE):
                    with self.subTest(file=str(file.relative_to(ROOT)), included=name):
                        self.assertTrue(any((top / name).is_file() for top in (ROOT / "src", file.parent))
                                        or name == "git_commit.h")

    def test_switches_name_every_value(self):
        """A default would hide a new value of an enumeration from -Wswitch."""
        for top in ("apps", "include", "src"):
            for file in sorted((ROOT / top).rglob("*")):
                if file.suffix in (".h", ".cpp"):
                    with self.subTest(file=str(file.relative_to(ROOT))):
                        self.assertNotRegex(re.sub(r"//.*", "", file.read_text()), r"(?m)^\s*default:")

    def test_only_the_program_starts_and_ends_things(self):
        for folder in ORDER:
            for file in sources(folder):
                with self.subTest(file=str(file.relative_to(ROOT))):
                    self.assertIsNone(PROCESS_WIDE.search(re.sub(r"//.*", "", file.read_text())))


if __name__ == "__main__":
    unittest.main()
