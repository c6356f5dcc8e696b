#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of `crackle compare`: two ensembles, several, as text and as JSON, and folders that cannot be compared."""
from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from functools import lru_cache
from pathlib import Path
from unittest import mock

import h5py
import numpy as np
from scipy import stats

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(Path(__file__).parent)]

import command_lines  # noqa: E402
import in_process  # noqa: E402
from crackle import commands  # noqa: E402
from synthetic_ensemble import write_ensemble  # noqa: E402

PROGRAM = Path()


def state(folder: Path) -> dict:
    return {str(file): (file.stat().st_mtime_ns, file.stat().st_size) for file in folder.rglob("*")}


class Compare(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.temporary.name)
        cls.addClassCleanup(os.chdir, os.getcwd())
        os.chdir(cls.folder)
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

    def program(self, *arguments: str) -> subprocess.CompletedProcess:
        return command_lines.crackle(PROGRAM, "compare", *arguments, cwd=self.folder)

    def compare(self, *arguments: str) -> subprocess.CompletedProcess:
        """What the program starts Python for, without a start of Python for each."""
        with mock.patch.dict(os.environ, CRACKLE=str(PROGRAM)):
            return in_process.call(commands.main, "compare", *arguments)

    @lru_cache
    def rows(self, name: str) -> dict:
        result = command_lines.crackle(PROGRAM, "stats", "--read-only", "--json", name, cwd=self.folder)
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
        result = self.program("--json", "--confidence", "0.9", "a", "slots", "b")
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
            if np.ptp(first) == 0 and np.ptp(second) == 0:
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

    def test_a_body_without_patterns_has_no_shares_of_them(self):
        shutil.copytree(self.folder / "b", self.folder / "solid")
        with h5py.File(self.folder / "solid" / "ensemble.h5", "r+") as file:
            file["samples/pattern"][:] = -1
        for names, shares in ((("a", "b"), True), (("a", "solid"), False)):
            results = json.loads(self.compare("--json", *names).stdout)["comparisons"][0]["results"]
            self.assertEqual("pattern" in {entry["name"] for entry in results}, shares, names)

    def test_the_text_names_what_is_compared(self):
        result = self.program("a", "b", "slots")
        self.assertEqual(result.returncode, 0, result.stderr)
        for part in ("b minus a\n11 pairs of samples", "slots minus a\nnot paired, because the bodies differ", "onset force [N], mean",
                     "energy distance [mm]", "Westfall", "as onset time", "least p possible: "):
            self.assertIn(part, result.stdout)
        self.assertEqual(result.stdout, self.compare("a", "b", "slots").stdout)

    def variant(self, name: str, source: str, base: str = "shared", **keys: int) -> Path:
        """The folder of a copy of an ensemble, with other keys in its input."""
        shutil.copytree(self.folder / source, self.folder / name)
        with h5py.File(self.folder / source / "ensemble.h5") as file:
            text = file.attrs["input"]
        for key, value in keys.items():
            text = re.sub(rf"(?m)^{key} = .*$", f"{key} = {value}", text)
        text = re.sub(r"(?m)^base = .*\n", "", text).replace("[mesh]\n", f'[mesh]\nbase = "{base}"\n')
        (self.folder / name / "input.toml").write_text(text)
        return self.folder / name

    def test_a_shared_base_and_samples_left_out_are_named(self):
        self.variant("shared", "a")
        self.variant("own", "b", base="own")
        self.variant("also-own", "b", base="own", seed=7)
        text = self.compare("shared", "own").stdout
        self.assertIn("hold for the first ensemble's base points only", text)
        self.assertIn("Failed samples are in no number: 1 in the first, 0 in the second.", text)
        comparison = json.loads(self.compare("--json", "shared", "own").stdout)["comparisons"][0]
        self.assertTrue(comparison["has_shared_base"])
        self.assertIn("with another base the answer may differ", " ".join(comparison["notes"]))
        self.assertEqual(comparison["samples"][0], {"n_done": 11, "n_undecided": 0, "n_unbroken": 0, "n_held": 0, "n_failed": 1, "n_left": 0})
        self.assertGreater(comparison["n_looks"], 5)
        self.assertEqual(comparison["p_least"], 1e-4)
        scaled = json.loads(self.compare("--json", "a", "slots").stdout)["comparisons"][0]["results"]
        same = {entry["name"]: entry["same_as"] for entry in scaled if not entry["share_of"]}
        self.assertEqual((same["onset_time"], same["onset_force"]), ("", "onset time"))
        self.assertFalse(json.loads(self.compare("--json", "own", "also-own").stdout)["comparisons"][0]["has_shared_base"])

    def test_several_shared_bases_give_intervals_for_the_material(self):
        folders = [self.variant(f"seed-{seed}", "b", seed=seed) for seed in (1, 2, 3)]
        for number, folder in enumerate(folders):
            with h5py.File(folder / "ensemble.h5", "r+") as file:
                file["samples/onset_force"][:] = file["samples/onset_force"][:] + 10 * number**2
        before = state(self.folder)
        text, answer = (command_lines.crackle(PROGRAM, "stats", *options, *folders).stdout for options in ((), ("--json",)))
        self.assertEqual(state(self.folder), before, "it reads only")
        document = json.loads(answer)
        found = next(entry for entry in document["results"] if entry["name"] == "onset_force")
        means = [np.mean(h5py.File(folder / "ensemble.h5")["samples/onset_force"][:]) for folder in folders]
        np.testing.assert_allclose(found["base_means"], means)
        np.testing.assert_allclose([found["lower"], found["upper"]], stats.t.interval(0.95, 2, np.mean(means), stats.sem(means)))
        self.assertAlmostEqual(found["variance_between"], np.var(means, ddof=1) - found["variance_within"] / 30, places=6)
        self.assertEqual(document["seeds"], [1, 2, 3])
        for part in ("3 bases, of seeds 1, 2, 3: 90 samples done", "t of 2 degrees of freedom", "\nonset force [N] ", "design effect",
                     "\nleader, start 0, y = 7 mm [mm] "):
            self.assertIn(part, text)
        slots = self.variant("shared-slots", "slots", seed=9)
        for others, reason in (((folders[0], folders[0]), "have the same seed, 1"), ((folders[0], slots), "differ in more")):
            refused = command_lines.crackle(PROGRAM, "stats", *others)
            self.assertEqual((refused.returncode, refused.stdout), (1, ""))
            self.assertIn(reason, refused.stderr)

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
            result = self.program(*arguments)
            self.assertEqual(result.returncode, 1, arguments)
            self.assertIn(message, result.stderr)
            self.assertEqual(result.stdout, "")


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=Path, required=True)
    options, rest = parser.parse_known_args()
    PROGRAM = options.program.resolve()
    unittest.main(argv=[sys.argv[0], *rest])
