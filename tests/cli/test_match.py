#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of `crackle match` on a small ensemble, and of the experiments file that `crackle init` writes for it."""
from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(Path(__file__).parent)]

import command_lines  # noqa: E402
import in_process  # noqa: E402
from crackle import commands  # noqa: E402
from small_input import run, small_input  # noqa: E402

PROGRAM = Path()
N = 26


def state(folder: Path) -> dict:
    return {str(file): (file.stat().st_mtime_ns, file.stat().st_size) for file in folder.rglob("*")}


class Match(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.temporary.name)
        cls.addClassCleanup(os.chdir, os.getcwd())
        os.chdir(cls.folder)
        text = small_input(samples=N).replace('base = "shared"', 'base = "own"')
        cls.out = run(PROGRAM, text, cls.folder / "out")
        with h5py.File(cls.out / "ensemble.h5") as file:
            undecided = file["samples/outcome"][:] == 4
            cls.used = [int(i) for i in np.flatnonzero(~undecided)]
            cls.undecided = [int(i) for i in np.flatnonzero(undecided)]
            cls.loads = file["samples/peak_load"][:][cls.used]
        assert len(cls.used) >= 10
        for cls.seven in cls.used[5:]:
            with h5py.File(cls.out / "samples" / f"{cls.seven:04}.h5") as file:
                lines = file["crack_lines/lines"]
                first, last = int(lines["first"][0]), int(lines["first"][0]) + int(lines["count"][0])
                cls.line, cls.time = file["crack_lines/position"][first:last], file["crack_lines/time"][first:last]
            if len(cls.line) >= 3:
                break
        with h5py.File(cls.out / "samples" / f"{cls.seven:04}.h5") as file:
            cls.peak = float(file["summary/peak_load"][()])
            cls.onset = float(file["summary/onset_force"][()])
        rows = "".join(f"{1e3 * y:.9f},{1e3 * z - 15:.9f}\n" for y, z in cls.line)
        (cls.folder / "seven.csv").write_text("y_mm,z_mm\n" + rows)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def crackle(self, *arguments: str, status: int = 0) -> subprocess.CompletedProcess:
        """What the program starts Python for, without a start of Python for each."""
        with mock.patch.dict(os.environ, CRACKLE=str(PROGRAM)):
            done = in_process.call(commands.main, *arguments)
        self.assertEqual(done.returncode, status, done.stderr)
        return done

    def program(self, *arguments: str, status: int = 0) -> subprocess.CompletedProcess:
        done = command_lines.crackle(PROGRAM, *arguments, cwd=self.folder)
        self.assertEqual(done.returncode, status, done.stderr)
        return done

    def match(self, text: str, *options: str, out: str = "out") -> str:
        (self.folder / "experiments.toml").write_text(text)
        return self.crackle("match", out, "experiments.toml", *options).stdout

    def json(self, text: str, out: str = "out") -> dict:
        return json.loads(self.match(text, "--json", out=out))

    SEVEN = """[[experiment]]
name = "seven"
path = "seven.csv"
origin = ["0 mm", "15 mm"]
"""

    def test_finds_a_sample_by_its_crack(self):
        tip = f'[[experiment.tip]]\ntime = "{self.time[1]} s"\nat = ["{self.line[1][0]} m", "{self.line[1][1] - 15e-3} m"]\n'
        found = self.json(self.SEVEN + f'peak_load = "{self.peak} N"\nonset_load = "{self.onset} N"\n' + tip)
        one, = found["experiments"]
        self.assertEqual(set(one["by"]), {"path", "onset_load", "peak_load", "tip_times", "jointly"})
        for name, limit in (("path", 1e-6), ("onset_load", 1e-9), ("peak_load", 1e-9), ("tip_times", 1e-12), ("jointly", 1e-2)):
            nearest = one["by"][name]["nearest"]
            self.assertEqual(nearest[0]["sample"], self.seven, name)
            self.assertLess(nearest[0]["distance"], limit, name)
            self.assertEqual(one["by"][name]["n_samples"], len(one["path"]["samples"]) if name in ("path", "jointly") else len(self.used))
        self.assertAlmostEqual(one["least_p_value"], 1 / (len(self.used) + 1))
        self.assertEqual(one["samples_needed"], 19)
        self.assertEqual(sum(way["n_samples"] for way in one["way"]["ways"]), len(self.used))
        self.assertGreaterEqual(one["p_value"], one["by"]["jointly"]["p_value"] * one["way"]["n_samples"] / len(self.used) - 1e-9)
        self.assertEqual(one["nearest"], one["by"]["jointly"]["nearest"])
        self.assertIsNone(found["set"])
        self.assertTrue(all("cannot give a p-value" in warning for warning in found["warnings"]))
        loads = found["samples"].pop("loads")
        self.assertEqual([each["sample"] for each in loads], self.used)
        self.assertEqual([each["peak_load"] for each in loads], list(self.loads))
        self.assertEqual(found["samples"], {"planned": N, "used": len(self.used), "failed": [], "undecided": self.undecided, "missing": [],
                                            "unbroken": []})
        self.assertEqual(one["observed"]["peak_load"], self.peak)
        np.testing.assert_allclose(one["observed"]["lines"], [self.line], atol=1e-9)
        np.testing.assert_allclose(np.array(one["path"]["sample_offsets"][one["path"]["samples"].index(self.seven)], float), np.array(one["path"]["offset"], float), atol=1e-6)
        self.assertEqual((len(one["path"]["samples"]), one["path"]["turned"]), (one["way"]["n_samples"], []))
        # The offsets of the path are those that the same line has in the file.
        path = one["path"]
        self.assertEqual(len(path["offset"]), 50)
        place, normal = np.array(path["place"]), np.array(path["normal"])
        foot = place + np.array(path["offset"])[:, None] * normal
        a, b = self.line[:-1], self.line[1:]
        for p in foot:
            share = np.clip(np.sum((p - a) * (b - a), axis=1) / np.sum((b - a)**2, axis=1), 0, 1)
            self.assertLess(np.min(np.linalg.norm(p - a - share[:, None] * (b - a), axis=1)), 1e-6)

    def test_a_path_farther_off_is_never_more_probable(self):
        least, p_values, apart = 1 / (len(self.used) + 1), [], "seven: its path does not run along those of the samples"
        for z in (15, 17, 19, 23, 27):
            text = self.SEVEN.replace("15 mm", f"{z} mm")
            p_values.append(self.json(text)["experiments"][0]["p_value"])
        self.assertEqual(p_values, sorted(p_values, reverse=True))
        self.assertLess(p_values[2], p_values[0])
        y = [1e3 * self.line[:, 0].min(), 1e3 * self.line[:, 0].max()]
        middle = 1e3 * self.line[:, 1].mean()
        (self.folder / "across.csv").write_text(f"y_mm,z_mm\n{y[0]},{middle}\n{y[0] + (y[1] - y[0]) / 8},{middle + 2 * (y[1] - y[0])}\n")
        text = '[[experiment]]\nname = "seven"\npath = "across.csv"\n'
        self.assertIn(apart, self.match(text))
        self.assertLessEqual(self.json(text)["experiments"][0]["p_value"], 2 * least)

    def test_held_out_samples_are_found_to_be_of_the_ensemble(self):
        found = json.loads(self.crackle("match", "out", "--held-out", "3", "--json").stdout)
        names = [one["name"] for one in found["experiments"]]
        self.assertEqual(len(set(names)), 3)
        self.assertEqual(found["samples"]["used"], len(self.used) - 3)
        for one in found["experiments"]:
            self.assertNotIn(int(one["name"].split()[1]), [near["sample"] for near in one["nearest"]])
        self.assertGreater(found["set"]["p_value"], 0.005)
        self.assertEqual(found, json.loads(self.crackle("match", "out", "--held-out", "3", "--json").stdout))
        of_other = self.crackle("match", "out", "--held-out", "each", "--of", "out").stdout
        self.assertIn(f"{len(self.used)} samples of out, each as an experiment against these", of_other)
        lines = self.crackle("match", "out", "--held-out", "each").stdout.splitlines()
        each = json.loads(self.crackle("match", "out", "--held-out", "each", "--json").stdout)
        self.assertEqual([one["sample"] for one in each], self.used)
        self.assertTrue(all(0 < one["p_value"] <= 1 for one in each))
        self.assertEqual(lines[0], f"{len(self.used)} samples, each as an experiment against the others")
        self.assertIn("checks the code only", lines[-1])
        for line in lines[1:-1]:
            level, share = float(line.split()[2]), float(line.split()[3]) / 100
            self.assertLessEqual(share, level + 2 / len(self.used), line)  # fewer where some have no crack, which others lie far from

    def test_held_out_samples_are_no_experiments_file(self):
        for arguments, message in (((), "match takes either an experiments file or --held-out"), (("x.toml", "--held-out", "3"), "either"),
                                   (("--held-out", "some"), "neither a number"), (("--held-out", "3", "--of", "out"), "goes with --held-out each"),
                                   (("x.csv",), "is a table")):
            self.assertIn(message, self.program("match", "out", *arguments, status=1).stderr)
        too_many = self.crackle("match", "out", "--held-out", str(len(self.used) - 1), status=1)
        self.assertIn(f"of {len(self.used)} samples 1 to {len(self.used) - 2}", too_many.stderr)

    def test_p_value_of_loads_by_numpy(self):
        loads = self.loads
        for load in (loads.min() - 1, np.median(loads), loads.max() + 0.01):
            pooled = np.append(load, loads)
            means = np.abs(pooled[:, None] - pooled).sum(axis=1) / len(loads)
            found = self.json(f'[[experiment]]\nname = "a"\npeak_load = "{load} N"\n')["experiments"][0]
            self.assertAlmostEqual(found["by"]["peak_load"]["p_value_of_mean"], np.mean(means >= means[0] - 1e-9))
            self.assertEqual(found["by"]["peak_load"]["nearest"][0]["sample"], self.used[int(np.argmin(np.abs(loads - load)))])

    def test_offset_from_the_samples(self):
        load = self.loads.mean() + 7
        by = self.json(f'[[experiment]]\nname = "a"\npeak_load = "{load} N"\n')["experiments"][0]["by"]["peak_load"]
        self.assertAlmostEqual(by["offset"], 7, places=9)
        self.assertAlmostEqual(by["standard_deviation"], self.loads.std(ddof=1), places=9)
        path = self.json(self.SEVEN)["experiments"][0]["by"]["path"]
        self.assertLess(abs(path["offset"]), 3 * path["standard_deviation"])

    def test_the_same_load_counts_once(self):
        """Onset and peak are the same where no crack stops."""
        with h5py.File(self.out / "ensemble.h5") as file:
            onset = file["samples/onset_force"][:][self.used]
        same = bool(np.all(np.abs(onset - self.loads) <= 1e-3 * onset))
        found = self.json(f'[[experiment]]\nname = "a"\npeak_load = "{self.peak} N"\nonset_load = "{self.onset} N"\n')["experiments"][0]
        self.assertEqual("jointly" in found["by"], not same)

    def test_loads_alone(self):
        loads = self.loads
        (self.folder / "loads.csv").write_text("peak_load_kN\n" + "".join(f"{1e-3 * (1.5 * load)}\n" for load in loads[:10]))
        text = self.match('loads = "loads.csv"\n')
        self.assertIn("row 10", text)
        self.assertIn("By peak load: ", text)
        found = self.json('loads = "loads.csv"\n')
        self.assertEqual(len(found["experiments"]), 10)
        by = found["set"]["by"]["peak_load"]
        self.assertLess(found["set"]["p_value"], 0.01)
        self.assertAlmostEqual(by["shift"]["value"], 1.5 * loads[:10].mean() - loads.mean(), places=6)
        self.assertAlmostEqual(by["scatter_ratio"]["value"], 1.5 * loads[:10].std(ddof=1) / loads.std(ddof=1), places=6)
        self.assertIn("no disturbance will cure that", by["advice"])
        self.assertEqual(by["n_experiments"], 10)
        self.assertEqual(by["power"]["n_trials"], 200)

    def test_the_same_and_nothing_written(self):
        before = state(self.out)
        text = self.SEVEN + 'path_error = "0.1 mm"\n'
        (self.folder / "experiments.toml").write_text(text)
        self.assertEqual(self.program("match", "out", "experiments.toml").stdout, self.match(text))
        self.assertEqual(state(self.out), before)
        self.assertIn(f"{len(self.used)} of {N} samples", self.match(text))

    def test_template_goes_through_match(self):
        done = self.crackle("init", "new.toml", "--from-ensemble", "out")
        self.assertIn("crackle match out new.toml", done.stdout)
        text = (self.folder / "new.toml").read_text()
        self.assertIn("# The body goes from y = 0 mm, z = 0 mm to y = 12 mm, z = 30 mm.", text)
        self.assertIn("y = 3 mm, z = 15 mm", text)
        self.assertIn("# Sections: y = 5 mm; y = 8 mm.", text)
        found = json.loads(self.crackle("match", "out", "new.toml", "--json").stdout)
        self.assertGreater(found["experiments"][0]["by"]["peak_load"]["p_value_of_mean"], 0.3)
        again = self.crackle("init", "new.toml", "--from-ensemble", "out", status=1)
        self.assertIn("already exists", again.stderr)
        # Every key but those of names and files, which do not exist, can be taken as it stands.
        lines = [line[1:] if line.startswith("#") and not line.startswith("# ") else line for line in text.splitlines()]
        (self.folder / "all.toml").write_text("\n".join(lines))
        errors = self.crackle("match", "out", "all.toml", status=1).stderr
        for line in errors.strip().splitlines():
            self.assertRegex(line, r"no such file|picture|loads")

    def test_all_errors_are_reported_at_once(self):
        (self.folder / "bad.csv").write_text("y_mm,z_mm\n1,2\n1,x\n")
        (self.folder / "experiments.toml").write_text('[[experiment]]\nname = "a"\npath = "bad.csv"\npeak_load = "3 mm"\n[[experiment]]\n'
                                                      'name = "b"\n')
        done = self.crackle("match", "out", "experiments.toml", status=1)
        self.assertEqual(done.stdout, "")
        lines = done.stderr.strip().splitlines()
        self.assertEqual(len(lines), 3)
        for line, part in zip(lines, ("3: experiment[0].path: bad.csv: line 3", "4: experiment[0].peak_load", "5: experiment[1]")):
            self.assertTrue(line.startswith("experiments.toml:" + part), line)
        (self.folder / "experiments.toml").write_text(self.SEVEN.replace('"15 mm"', '"80 mm"'))
        self.assertIn("set origin, angle and mirror", self.crackle("match", "out", "experiments.toml", status=1).stderr)
        self.assertIn("there is no such file", self.crackle("match", "out", "none.toml", status=1).stderr)
        (self.folder / "empty").mkdir()
        self.assertIn("is not the folder of an ensemble", self.crackle("match", "empty", "experiments.toml", status=1).stderr)

    def test_missing_samples_are_named(self):
        shutil.copytree(self.out, self.folder / "part")
        gone = self.used[1:3]
        for number in gone:
            (self.folder / "part" / "samples" / f"{number:04}.h5").unlink()
        found = self.json(self.SEVEN, out="part")
        self.assertEqual(found["samples"]["missing"], gone)
        self.assertEqual(found["samples"]["used"], len(self.used) - 2)
        self.assertIn("cannot give a p-value below", found["warnings"][0])
        self.assertIn(f"2 missing ({gone[0]}, {gone[1]})", self.match(self.SEVEN, out="part"))
        # Loads are in ensemble.h5.
        shutil.rmtree(self.folder / "part" / "samples")
        load = '[[experiment]]\nname = "a"\npeak_load = "90 N"\n'
        self.assertEqual(self.json(load, out="part")["samples"]["used"], len(self.used))
        (self.folder / "seven.toml").write_text(self.SEVEN)
        self.assertIn("holds no sample files", self.crackle("match", "part", "seven.toml", status=1).stderr)

    def test_a_shared_base_is_warned_of(self):
        shared = run(PROGRAM, small_input(samples=3), self.folder / "shared")
        load = '[[experiment]]\nname = "a"\npeak_load = "90 N"\n'
        self.assertIn("not valid", self.json(load, out=shared.name)["warnings"][0])
        self.assertIn("warning: the samples share their base", self.match(load, out=shared.name))
        self.assertIn("no conclusion follows", self.crackle("match", shared.name, "--held-out", "each").stdout)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=Path, required=True)
    known, rest = parser.parse_known_args()
    PROGRAM = known.program.resolve()
    unittest.main(argv=[sys.argv[0], *rest])
