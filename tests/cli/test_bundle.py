#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The source bundle holds every library that the program is made of but those that a cluster has, each with its licence."""
from __future__ import annotations

import contextlib
import io
import re
import sys
import tempfile
import unittest
from importlib.machinery import SourceFileLoader
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
bundle = SourceFileLoader("source_bundle", str(ROOT / "tools" / "packaging" / "source-bundle")).load_module()


def sources() -> list[str]:
    files = [file for top in ("src", "include", "apps") for file in sorted((ROOT / top).rglob("*"))]
    return [file.read_text() for file in files if bundle.is_source(str(file.relative_to(ROOT)))]


class Bundle(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.names = bundle.includes(sources())
        cls.external = sorted(name for name in cls.names if name.split("/")[0] in bundle.OWNERS)
        cls.headers = bundle.external_headers(cls.names)

    def test_the_compiler_needs_no_other_header_of_these_libraries(self):
        with tempfile.TemporaryDirectory() as temporary:
            for name, path in self.headers.items():
                (Path(temporary) / name).parent.mkdir(parents=True, exist_ok=True)
                (Path(temporary) / name).symlink_to(path)
            read = bundle.dependencies(self.external, "-DNDEBUG", "-DCGAL_NDEBUG", folder=Path(temporary))
        self.assertTrue(self.external)
        self.assertEqual([path for path in read if not path.is_relative_to(temporary) and path not in bundle.system_files()], [])

    def test_a_library_that_it_does_not_hold_is_named(self):
        message = io.StringIO()
        with self.assertRaisesRegex(SystemExit, "/gmp.h is included"), contextlib.redirect_stderr(message):
            bundle.external_headers({"gmp.h"})

    def test_every_target_that_is_linked_exists_with_a_bundle_too(self):
        linked = set()
        for folder in ("src", "apps"):
            linked |= set(re.findall(r"\b\w+::\w+", (ROOT / folder / "CMakeLists.txt").read_text()))
        here = set(re.findall(r"\b\w+::\w+", (ROOT / "tools" / "cmake" / "Bundled.cmake").read_text()))
        self.assertEqual(linked - here, {"MPI::MPI_CXX", "crackle::PETSc", "crackle::HDF5", "crackle::METIS"})

    def test_every_library_has_a_licence(self):
        self.assertEqual(set(bundle.OWNERS.values()), set(bundle.PACKAGES))
        self.assertLessEqual(set(bundle.C_HEADERS.values()), set(bundle.SOURCES))
        for package, *_ in bundle.PACKAGES.values():
            self.assertIn("License", Path(f"/usr/share/doc/{package}/copyright").read_text(), package)
        for library, (_, licence, archives, *_) in bundle.SOURCES.items():
            self.assertTrue(licence and archives, library)

    def test_the_same_files_give_the_same_bytes(self):
        files = {"top/b": (b"2", 0o755), "top/a": (b"1", 0o644)}
        first = bundle.archive(files, 1_700_000_000)
        self.assertEqual(first, bundle.archive(dict(reversed(files.items())), 1_700_000_000))
        self.assertEqual(first[4:8], bytes(4), "the time of packing is in it")


if __name__ == "__main__":
    unittest.main()
