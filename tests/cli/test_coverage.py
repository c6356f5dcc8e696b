#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""jobs/verification/coverage: how often intervals cover, counted right, on ensembles that are computed once."""
import argparse
import importlib.util
import os
import subprocess
import sys
import tempfile
import unittest
from importlib.machinery import SourceFileLoader
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
TOOL = ROOT / "jobs" / "verification" / "coverage"
PROGRAM = ""


def load():
    loader = SourceFileLoader("coverage_tool", str(TOOL))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("coverage_tool", loader))
    sys.modules["coverage_tool"] = module
    loader.exec_module(module)
    return module


class Coverage(unittest.TestCase):
    def test_counts_the_intervals_that_cover(self):
        tool = load()
        # Student's t for three samples is 4.303: half widths of 2.484, and means of 10, 12 and 20.
        found = tool.coverage([np.array([9.0, 10, 11]) + shift for shift in (0, 2, 10)])
        np.testing.assert_allclose(found.means, [10, 12, 20])
        np.testing.assert_allclose(found.half_widths, 4.302653 / np.sqrt(3), rtol=1e-6)
        self.assertEqual([found.n_covering(truth) for truth in (11, 10, 7.6, 7.4, 17.6)], [2, 2, 1, 0, 1])
        self.assertEqual(tool.row("own", found, 11.0),
                         ["`own`", "3", "14.000", "5.292", "2.484", "2 of 3: 67 % (21 to 94)"])

    def test_intervals_of_dependent_samples_cover_too_seldom(self):
        tool = load()
        random = np.random.Generator(np.random.PCG64(1))
        within, between, n = 1.0, 0.6, 400
        own = tool.coverage([random.normal(0, np.hypot(within, between), 10) for _ in range(n)])
        shared = tool.coverage([random.normal(random.normal(0, between), within, 10) for _ in range(n)])
        self.assertGreater(own.n_covering(0.0) / n, 0.92)
        self.assertLess(shared.n_covering(0.0) / n, 0.75)

    def test_ensembles_are_computed_once(self):
        with tempfile.TemporaryDirectory(prefix="crackle-coverage-") as name:
            def call():
                return subprocess.run([TOOL, "--ensembles", "1", "--samples", "2", "-o", name, "--program", PROGRAM],
                                      capture_output=True, text=True, check=False, timeout=500,
                                      env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})
            first = call()
            self.assertEqual(first.returncode, 0, first.stderr)
            for kind in ("shared", "own"):
                self.assertRegex(first.stdout, rf"(?m)^\| `{kind}` \| 1 \| \d+\.\d+ \| - \| \d+\.\d+ \| [01] of 1: ")
                with h5py.File(Path(name) / "2-samples" / f"{kind}-001" / "out" / "ensemble.h5") as root:
                    self.assertEqual("mother_points" in root, kind == "shared")
                    self.assertGreater(root["samples/onset_force"][...].min(), 0)
            written = {file: file.stat().st_mtime_ns for file in Path(name).rglob("*.h5")}
            second = call()
            self.assertEqual(second.stdout, first.stdout)
            self.assertEqual({file: file.stat().st_mtime_ns for file in Path(name).rglob("*.h5")}, written)
            self.assertRegex(second.stdout, r"2 samples in each ensemble")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", required=True)
    options, rest = parser.parse_known_args()
    PROGRAM = os.path.abspath(options.program)
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
