#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What `cmake --install` leaves runs from anywhere, without the source tree."""
from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "cli")]

from crackle_launch import environment  # noqa: E402
from synthetic_ensemble import write_ensemble  # noqa: E402

BUILD = Path()


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = Path(cls.temporary.name)
        cls.prefix = cls.folder / "prefix"
        subprocess.run(["cmake", "--install", str(BUILD), "--prefix", str(cls.prefix)], check=True, capture_output=True)

    def call(self, *command: object) -> str:
        """Runs a command with what is installed first on the PATH, in an empty folder; its output."""
        path = f"{self.prefix / 'bin'}:/usr/bin:/bin"
        variables = {**environment(), "PATH": path, "PYTHONDONTWRITEBYTECODE": "1", "PYTHONPATH": ""}
        variables.pop("CRACKLE", None)
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False, cwd=self.folder, env=variables)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_the_program_and_the_tools_beside_it(self):
        self.call("crackle", "init", "plate.toml", "--from", "ring")
        self.assertIn("ensemble.samples", self.call("crackle", "check", "plate.toml"))
        write_ensemble(self.folder / "out", 1)
        # What draws random inputs is found where it is installed.
        self.call("crackle", "init", "strip.toml", "--from", "uncertain-strip")
        self.assertIn("median 298.5", self.call("crackle", "check", "--no-measure", "strip.toml"))
        self.assertEqual(self.call("crackle-report", "out", "--no-animation", "--no-fringes"), "report: out/report.html\n")
        self.assertIn(" files in ", self.call("crackle-paraview", "out", "--sample", "0"))

    def test_the_jobs_find_the_tools(self):
        share = self.prefix / "share" / "crackle"
        texts = [self.call(share / "jobs" / job, "--help") for job in ("gallery/gallery", "verification/verify")]
        self.assertNotIn(str(ROOT), "".join(texts))
        self.assertIn(str(self.folder), "".join(texts[0].split()))
        for name in ("ensemble.sbatch", "array.sbatch", "demo.toml", "figures.py", "gallery/ring.toml"):
            self.assertTrue((share / "jobs" / name).is_file(), name)
        self.assertTrue(os.access(share / "jobs" / "figures.py", os.X_OK))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--build", type=Path, required=True)
    options, rest = parser.parse_known_args()
    BUILD = options.build.resolve()
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
