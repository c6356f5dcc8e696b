#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of `crackle calibrate` on a small ensemble with random inputs."""
from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Callable
from unittest import mock

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(Path(__file__).parent)]

import command_lines  # noqa: E402
import crackle  # noqa: E402
import in_process  # noqa: E402
from crackle import commands  # noqa: E402
from small_input import run, small_input  # noqa: E402

PROGRAM = Path()
N = 40
RANDOM = """[[random]]
key = "fracture.strength"
distribution = "uniform"
lower = "20 MPa"
upper = "50 MPa"
[[random]]
key = "specimen.notch[0].at"
distribution = "truncated"
standard_deviation = "2 mm"
lower = "12 mm"
"""


def drawn_inputs(file: h5py.File) -> np.ndarray:
    return np.stack([file["samples/inputs"][key][:] for key in ("fracture.strength", "specimen.notch[0].at")], axis=1)


class Calibrate(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.temporary.name)
        cls.addClassCleanup(os.chdir, os.getcwd())
        os.chdir(cls.folder)
        cls.text = small_input(RANDOM, samples=N, ensemble='plan = "sobol"\n').replace('base = "shared"', 'base = "own"').replace('duration = "20 us"', 'duration = "80 us"')
        cls.out = run(PROGRAM, cls.text, cls.folder / "out")
        with h5py.File(cls.out / "ensemble.h5") as file:
            decided = np.flatnonzero((file["samples/status"][:] == 1) & (file["samples/outcome"][:] != 4))
            cls.inputs = drawn_inputs(file)
            cls.loads = file["samples/peak_load"][:]
        cls.number = int(next(i for i in decided if 28e6 < cls.inputs[i][0] < 42e6))
        with h5py.File(cls.out / "samples" / f"{cls.number:04}.h5") as file:
            lines = file["crack_lines/lines"]
            first = int(lines["first"][0])
            line = file["crack_lines/position"][first:first + int(lines["count"][0])]
        (cls.folder / "path.csv").write_text("y_mm,z_mm\n" + "".join(f"{1e3 * y:.9f},{1e3 * z:.9f}\n" for y, z in line))
        (cls.folder / "experiments.toml").write_text(
            f'[[experiment]]\nname = "one"\npath = "path.csv"\npath_error = "0.1 mm"\npeak_load = "{cls.loads[cls.number]} N"\n'
            'load_error = "0.5 N"\n')
        (cls.folder / "load.toml").write_text(f'[[experiment]]\nname = "load"\npeak_load = "{cls.loads[cls.number]} N"\n')

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def crackle(self, *arguments: str, status: int = 0) -> subprocess.CompletedProcess:
        done = command_lines.crackle(PROGRAM, *arguments, cwd=self.folder)
        self.assertEqual(done.returncode, status, done.stderr)
        return done

    def calibrate(self, *arguments: str, status: int = 0) -> subprocess.CompletedProcess:
        """What the program starts Python for, without a start of Python for each."""
        with mock.patch.dict(os.environ, CRACKLE=str(PROGRAM)):
            done = in_process.call(commands.main, "calibrate", *arguments)
        self.assertEqual(done.returncode, status, done.stderr)
        return done

    def test_a_sample_as_an_experiment(self):
        before = {str(file): (file.stat().st_mtime_ns, file.stat().st_size) for file in self.out.rglob("*")}
        found = json.loads(self.crackle("calibrate", "out", "experiments.toml", "--json").stdout)
        self.assertEqual(before, {str(file): (file.stat().st_mtime_ns, file.stat().st_size) for file in self.out.rglob("*")})
        self.assertEqual([each["key"] for each in found["inputs"]], ["fracture.strength", "specimen.notch[0].at"])
        strength, place = found["inputs"]
        self.assertAlmostEqual(strength["prior"]["mean"], 35e6, delta=1e4)
        self.assertLess(strength["ratio"], 0.6, "the load tells the strength")
        self.assertLess(place["ratio"], 0.6, "the path tells the notch")
        # The sample is among those that the emulator was made from, so its inputs are well inside.
        for each, truth in zip(found["inputs"], self.inputs[self.number]):
            self.assertLess(abs(each["posterior"]["mean"] - truth), 3.5 * each["posterior"]["standard_deviation"])
            self.assertLess(each["posterior"]["lower"], each["posterior"]["upper"])
        by = {each["quantity"]: each for each in found["contributions"]}
        self.assertEqual(set(by), {"path", "peak_load"})
        self.assertGreater(by["path"]["without"]["inputs"][1]["standard_deviation"], by["path"]["alone"]["inputs"][1]["standard_deviation"])
        self.assertGreater(by["path"]["alone"]["inputs"][0]["standard_deviation"], by["path"]["without"]["inputs"][0]["standard_deviation"])
        self.assertEqual([each["name"] for each in found["predictions"]], ["peak_load", "path, mean offset", "path, offset at its end"])
        self.assertAlmostEqual(found["predictions"][0]["observed"], self.loads[self.number])
        for each in found["predictions"]:
            self.assertTrue(0.001 < each["place"] < 0.999, each)
        self.assertEqual(len(found["path"]["mean"]), len(found["path"]["observed"]))
        checks = found["checks"]
        self.assertEqual(len(checks["coverage"]), 4)
        self.assertEqual(checks["coverage"][0]["n_draws"], found["samples"]["draws"])
        self.assertGreater(checks["effective_size"], 1000)
        self.assertGreater(checks["distance"]["p_value"], 0.02)
        self.assertEqual(sum(found["draws"]["weights"]), 500)
        draws = np.array(found["draws"]["values"])
        mean = np.average(draws, axis=0, weights=found["draws"]["weights"])
        for k, each in enumerate(found["inputs"]):
            self.assertLess(abs(mean[k] - each["posterior"]["mean"]), 0.2 * each["posterior"]["standard_deviation"])
        text = self.calibrate("out", "experiments.toml").stdout
        for part in ("fracture.strength", "All together", "prediction", "coverage of", "Effective size", "standard deviations apart", "even scatter, p"):
            self.assertIn(part, text)

    def test_the_posterior_is_an_input(self):
        found = json.loads(self.crackle("calibrate", "out", "experiments.toml", "--output", "posterior.toml", "--discrepancy", "--json").stdout)
        tables = (self.folder / "posterior.toml").read_text()
        self.assertIn('distribution = "beta"', tables)
        start = self.text.index("[[random]]")
        (self.folder / "again.toml").write_text(self.text[:start] + tables)
        checked = self.crackle("check", "again.toml").stdout
        self.assertIn("fracture.strength", checked)
        again = run(PROGRAM, (self.folder / "again.toml").read_text().replace(f"samples = {N}", "samples = 2"), self.folder / "again")
        with h5py.File(again / "ensemble.h5") as file:
            drawn = drawn_inputs(file)
        prior = np.std(self.inputs, axis=0)
        for k, each in enumerate(found["inputs"]):
            self.assertTrue(np.all(np.abs(drawn[:, k] - each["posterior"]["mean"]) < 4 * each["posterior"]["standard_deviation"]))
            self.assertLess(each["posterior"]["standard_deviation"], 1.1 * prior[k])
        self.assertEqual({each["kind"] for each in found["scales"]}, {"discrepancy"})
        # Existing files are kept.
        self.assertIn("already exists", self.calibrate("out", "load.toml", "-o", "posterior.toml", status=1).stderr)
        self.assertEqual((self.folder / "posterior.toml").read_text(), tables)

    def test_errors(self):
        def error(*arguments: str, call: Callable = self.calibrate) -> str:
            done = call(*arguments, "-o", "unwritten.toml", status=1)
            self.assertEqual(done.stdout, "")
            self.assertFalse((self.folder / "unwritten.toml").exists())
            self.assertEqual(len(done.stderr.strip().splitlines()), 1)
            return done.stderr

        few = run(PROGRAM, re.sub("samples = 40", "samples = 5", self.text), self.folder / "few")
        self.assertRegex(error(few.name, "load.toml"), r"[0-5] draws .* too few .*; 12 or more")
        plain = run(PROGRAM, small_input(samples=2), self.folder / "plain")
        self.assertIn("no random inputs", error(plain.name, "load.toml"))
        self.assertIn("needs two experiments", error("calibrate", "out", "load.toml", "--between-specimens", call=self.crackle))
        (self.folder / "nothing.toml").write_text('[[experiment]]\nname = "a"\n[[experiment.tip]]\ntime = "1 us"\nat = ["0 mm", "29 mm"]\n'
                                                  '[[experiment]]\nname = "b"\n[[experiment.tip]]\ntime = "1 us"\nat = ["0 mm", "29 mm"]\n')
        self.assertIn("nothing in common", error("out", "nothing.toml"))
        # Before the experiments are even read.
        refused = self.crackle("calibrate", "out", "none.toml", "-o", "/no/such/posterior.toml", status=1)
        self.assertEqual((refused.stdout, refused.stderr), ("", "crackle: '/no/such/posterior.toml' cannot be written: No such file or directory\n"))

    def test_several_specimens(self):
        loads = self.loads[self.number] * np.array([0.8, 0.9, 1.1, 1.2])
        (self.folder / "loads.csv").write_text("peak_load_N\n" + "".join(f"{load}\n" for load in loads))
        (self.folder / "several.toml").write_text('loads = "loads.csv"\n')
        found = json.loads(self.calibrate("out", "several.toml", "--json").stdout)
        self.assertEqual(len(found["experiments"]), 4)
        self.assertTrue(found["between_specimens"])
        scale, = found["scales"]
        self.assertEqual((scale["kind"], scale["quantity"]), ("between_specimens", "peak_load"))
        self.assertGreater(scale["posterior"]["upper"], np.std(loads, ddof=1) / 2)
        self.assertLess(found["checks"]["contradictions"][0]["p_value"], 0.05)
        equal = json.loads(self.crackle("calibrate", "out", "several.toml", "--equal-specimens", "--json").stdout)
        self.assertEqual((equal["scales"], equal["between_specimens"]), ([], False))
        self.assertIn("contradict each other", " ".join(equal["warnings"]))
        self.assertLess(equal["inputs"][0]["ratio"], found["inputs"][0]["ratio"])

    def test_a_specimen_that_did_not_break(self):
        load = self.loads[self.number]
        (self.folder / "run-out.toml").write_text(f'[[experiment]]\nname = "run-out"\npeak_load = "{load} N"\nrun_out = true\n')
        bound, value = (json.loads(self.calibrate("out", name, "--json").stdout)["inputs"][0]["posterior"] for name in ("run-out.toml", "load.toml"))
        self.assertGreater(bound["mean"], value["mean"])
        self.assertGreater(bound["upper"], 47e6)  # nothing bounds the strength from above but its prior

    def test_in_python(self):
        found = crackle.open(self.out).calibrate(self.folder / "load.toml", program=PROGRAM)
        self.assertEqual(list(found.inputs.index), ["fracture.strength", "specimen.notch[0].at"])
        self.assertEqual(str(found), self.crackle("calibrate", "out", "load.toml").stdout)
        self.assertEqual(found.draws["weight"].sum(), 500)
        self.assertEqual(found.plot().get_xlabel(), "fracture.strength [Pa]")
        effects = crackle.open(self.out).sensitivities(PROGRAM)
        self.assertGreater(effects.table.loc[("peak_load", "", "fracture.strength"), "total"], 0.3)
        self.assertEqual(len(effects.plot().get_legend().get_texts()), 2)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=Path, required=True)
    known, rest = parser.parse_known_args()
    PROGRAM = known.program.resolve()
    unittest.main(argv=[sys.argv[0], *rest])
