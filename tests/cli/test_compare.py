#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of `crackle compare`: two ensembles, several, as text and as JSON, and folders that cannot be compared."""
from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import unittest
from functools import lru_cache
from pathlib import Path

import h5py
import numpy as np
from scipy import stats

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(Path(__file__).parent)]

from crackle_launch import environment  # noqa: E402
from synthetic_ensemble import write_ensemble  # noqa: E402

PROGRAM = Path()


def state(folder: Path) -> dict:
    return {str(file): (file.stat().st_mtime_ns, file.stat().st_size) for file in folder.rglob("*")}


class Compare(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.temporary.name)
        write_ensemble(cls.folder / "a", 12, failed=(4,))
        write_ensemble(cls.folder / "b", 30)
        with h5py.File(cls.folder / "b" / "ensemble.h5", "r+") as file:
            numbers = np.arange(30)
            for k, name in enumerate(("onset_force", "crack_area", "crack_speed_max")):
                file["samples"][name][:] = file["samples"][name][:] * (1.01 + 0.02 * np.sin(3.0 * numbers + k))
            # Forward in the frame of the crack that leads: a sample that the other one leads is turned.
            ahead = np.where(file["samples/leading_notch"][:] == 1, -1e-3, 1e-3)
            file["crack_path/position"][:] = file["crack_path/position"][:] + ahead[:, None, None]
        write_ensemble(cls.folder / "slots", 8, slots=(("y-min", 60, 6, 0.6), ("y-max", 75, 6, 0.6)))

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def compare(self, *arguments: str) -> subprocess.CompletedProcess:
        return subprocess.run([str(PROGRAM), "compare", *arguments], capture_output=True, text=True, check=False, cwd=self.folder,
                              env=environment(), timeout=300)

    @lru_cache
    def rows(self, name: str) -> dict:
        result = subprocess.run([str(PROGRAM), "stats", "--read-only", "--json", name], capture_output=True, text=True, check=True,
                                cwd=self.folder, env=environment(), timeout=300)
        return json.loads(result.stdout)["samples"]

    def values(self, name: str, result: str) -> np.ndarray:
        """NaN where a sample is not done."""
        rows = self.rows(name)
        values = np.array([np.nan if value is None else value for value in rows[result]], dtype=float)
        values[np.array(rows["status"]) != 1] = np.nan
        return values

    def test_the_same_bodies_are_compared_pair_by_pair(self):
        before = state(self.folder)
        result = self.compare("--json", "a", "b")
        self.assertEqual(result.returncode, 0, result.stderr)
        comparison = json.loads(result.stdout)["comparisons"][0]
        self.assertTrue(comparison["paired"])
        self.assertEqual(comparison["n_pairs"], 11)
        found = {entry["name"]: entry for entry in comparison["results"] if entry["share_of"] == ""}
        n_compared = 0
        for name, entry in found.items():
            differences = self.values("b", name)[:12] - self.values("a", name)
            differences = differences[~np.isnan(differences)]
            self.assertEqual(entry["n_first"], len(differences))
            self.assertAlmostEqual(entry["difference_of_means"]["value"], differences.mean(), delta=1e-9 * abs(differences).max())
            if differences.std() == 0:
                continue
            lower, upper = stats.t.interval(0.95, len(differences) - 1, differences.mean(), stats.sem(differences))
            np.testing.assert_allclose([entry["difference_of_means"][end] for end in ("lower", "upper")], [lower, upper], rtol=1e-6)
            n_compared += 1
        print(f"{n_compared} results of pairs compared with scipy's intervals")
        self.assertEqual(n_compared, 3)
        for paths in comparison["paths"]:
            self.assertLess(paths["p"], 0.01)
        self.assertEqual(state(self.folder), before, "it reads only")

    def test_other_bodies_are_independent(self):
        result = self.compare("--json", "--confidence", "0.9", "a", "slots", "b")
        self.assertEqual(result.returncode, 0, result.stderr)
        comparisons = json.loads(result.stdout)["comparisons"]
        self.assertEqual([one["second"] for one in comparisons], ["slots", "b"])
        self.assertFalse(comparisons[0]["paired"])
        self.assertIn("specimen.notch[0].at = 60 mm", comparisons[0]["note"])
        self.assertEqual(comparisons[0]["paths"], [])
        self.assertTrue(comparisons[1]["paths"])
        n_compared = 0
        for entry in comparisons[0]["results"]:
            if entry["share_of"] != "":
                continue
            first, second = ([value for value in self.values(name, entry["name"]) if not np.isnan(value)] for name in ("a", "slots"))
            if np.std(first) == 0 and np.std(second) == 0:
                continue
            squares = [np.var(values, ddof=1) / len(values) for values in (first, second)]
            degrees = sum(squares)**2 / sum(s**2 / (len(v) - 1) for s, v in zip(squares, (first, second)))
            reach = stats.t.ppf(0.95, degrees) * np.sqrt(sum(squares))
            ends = entry["difference_of_means"]
            np.testing.assert_allclose(ends["upper"] - ends["lower"], 2 * reach, rtol=1e-6)
            n_compared += 1
        print(f"{n_compared} results compared with Welch's intervals")
        self.assertGreater(n_compared, 3)
        for one in comparisons:
            for entry in one["results"] + one["paths"]:
                if entry["p"] is not None and entry["p_adjusted"] is not None:
                    self.assertLessEqual(entry["p"], entry["p_adjusted"])

    def test_the_text_names_what_is_compared(self):
        result = self.compare("a", "b", "slots")
        self.assertEqual(result.returncode, 0, result.stderr)
        for part in ("b minus a\n11 pairs of samples", "slots minus a\nnot paired, because the bodies differ", "onset force [N], mean",
                     "energy distance [mm]", "Holm"):
            self.assertIn(part, result.stdout)

    def test_an_ensemble_is_no_other_than_itself(self):
        comparison = json.loads(self.compare("--json", "b", "b").stdout)["comparisons"][0]
        for entry in comparison["results"]:
            self.assertEqual(entry["p"], 1, entry)
            self.assertEqual(entry["difference_of_means"]["value"], 0)
        for entry in comparison["paths"]:
            self.assertAlmostEqual(entry["energy_distance"], 0)

    def test_what_cannot_be_compared_is_refused(self):
        write_ensemble(self.folder / "none", 2, pending=(0, 1))
        (self.folder / "empty").mkdir()
        for arguments, message in ((("a", "nowhere"), "nowhere"), (("a", "empty"), "empty"), (("a",), "folders"),
                                   (("a", "none"), "'none' has no completed sample"), (("--confidence", "2", "a", "b"), "confidence")):
            result = self.compare(*arguments)
            self.assertEqual(result.returncode, 1, arguments)
            self.assertIn(message, result.stderr)
            self.assertEqual(result.stdout, "")


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=Path, required=True)
    options, rest = parser.parse_known_args()
    PROGRAM = options.program
    unittest.main(argv=[sys.argv[0], *rest])
