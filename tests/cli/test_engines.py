#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs with engine = "petsc": what they say and store, on several ranks and resumed, and jobs/verification's comparison."""
from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import h5py
import pandas as pd

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "jobs" / "gallery"), str(ROOT / "jobs" / "verification")]

import cases  # noqa: E402
import crackle  # noqa: E402
from crackle_launch import environment, mpirun  # noqa: E402
from crackle_runs import with_keys  # noqa: E402

PROGRAM = ""
TIMEOUT = 400  # seconds that a run may take on a busy machine
NOTICE = "engine petsc: a sample has the same bits on the same number of ranks only"
PLATE = with_keys((ROOT / "jobs" / "demo.toml").read_text(), {
    "ensemble.samples": "2", "mesh.spacing": '"4 mm"', "mesh.notch_spacing": '"1.2 mm"', "mesh.growth": "0.2",
    "time.duration": '"60 us"', "output.frames": "2"})
PETSC = with_keys(PLATE, {"time.engine": '"petsc"'})


def call(*arguments, n_ranks=1):
    launcher = [] if n_ranks == 1 else mpirun(n_ranks)
    return subprocess.run([*launcher, PROGRAM, *map(str, arguments)], capture_output=True, text=True, check=False,
                          timeout=TIMEOUT, env=environment())


def breaks(file):
    """Where and when the tetrahedra of a sample broke."""
    return crackle.Sample(file).breaks[["tetrahedron", "load_time", "phase_time"]]


class Engines(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="crackle-engines-")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.input, self.fixed_point = self.folder / "petsc.toml", self.folder / "fixed-point.toml"
        self.input.write_text(PETSC)
        self.fixed_point.write_text(with_keys(PLATE, {"time.precision": '"double"'}))

    def succeed(self, *arguments, n_ranks=1):
        result = call(*arguments, n_ranks=n_ranks)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        return result.stdout

    def test_the_engine_is_reported(self):
        told = self.succeed("check", "--no-measure", self.input)
        self.assertIn(NOTICE + "\n", told)
        self.assertRegex(told, r"time.engine +=  ?petsc\n")
        self.assertRegex(told, r"time.precision +=  ?double\n")
        self.assertNotIn("same bits", self.succeed("check", "--no-measure", self.fixed_point))

    def test_the_cost_is_that_of_the_engine(self):
        def updates(setting):
            line = next(line for line in self.succeed("check", setting).splitlines() if line.startswith("dynamic phase"))
            return float(line.split("per step, ")[1].split()[0])
        petsc, fixed_point = updates(self.input), updates(self.fixed_point)
        print(f"million tetrahedron updates per second: {petsc} by PETSc, {fixed_point} in fixed-point numbers")
        self.assertLess(petsc, fixed_point)

    def test_shared_samples_break_as_the_other_engine_breaks_them(self):
        shared, other = self.folder / "shared", self.folder / "other"
        self.input.write_text(with_keys(PETSC, {"ensemble.ranks_per_sample": "2"}))
        told = self.succeed("run", self.input, "-o", shared, n_ranks=3)
        self.assertEqual(told.count(NOTICE), 1)
        self.assertNotIn("same bits", self.succeed("run", self.fixed_point, "-o", other))
        for folder, engine, same_bits in ((shared, "petsc", "on the same number of ranks only"),
                                          (other, "fixed-point", "on any number of ranks")):
            for file in ("ensemble.h5", "samples/0001.h5"):
                with h5py.File(folder / file) as root:
                    self.assertEqual((root.attrs["engine"], root.attrs["same_bits"]), (engine, same_bits))
        for sample in ("0000.h5", "0001.h5"):
            mine, theirs = (breaks(folder / "samples" / sample) for folder in (shared, other))
            print(f"{sample}: {len(mine)} breaks")
            self.assertGreater(len(mine), 50)
            pd.testing.assert_frame_equal(mine, theirs, check_exact=True)

    def test_a_suspended_sample_continues_on_other_ranks_but_not_with_the_other_engine(self):
        whole, parts = self.folder / "whole", self.folder / "parts"
        self.input.write_text(with_keys(PETSC, {"time.step": '"40 ns"'}))
        self.succeed("sample", self.input, "--sample", 0, "-o", whole)
        checkpoint = parts / "samples" / "0000.checkpoint"
        process = subprocess.Popen([PROGRAM, "sample", self.input, "--sample", "0", "-o", parts, "--checkpoint-interval", "0.05s"],
                                   stdout=subprocess.DEVNULL, env=environment())
        while not checkpoint.exists():
            self.assertIsNone(process.poll(), "the sample ended without a checkpoint")
            time.sleep(0.01)
        process.terminate()
        self.assertEqual(process.wait(TIMEOUT), 3)
        refused = call("sample", self.fixed_point, "--sample", 0, "-o", parts, "--resume")
        self.assertEqual(refused.returncode, 1)
        self.assertIn("time.engine is fixed-point, not petsc", refused.stderr)
        told = self.succeed("sample", self.input, "--sample", 0, "-o", parts, "--resume", n_ranks=2)
        self.assertRegex(told, r"continues at step \d+|is taken from the checkpoint")
        self.assertIn(NOTICE, told)
        pd.testing.assert_frame_equal(breaks(whole / "samples" / "0000.h5"), breaks(parts / "samples" / "0000.h5"), check_exact=True)

    def test_verification_compares_them(self):
        for figure in cases.compare_engines(PLATE, self.folder, Path(PROGRAM)):
            print(f"{figure.case}: {figure.quantity}: {figure.found}")
            self.assertIn("by `double` and by `mixed`, 2 samples", figure.case)
            of_double = figure.found.split(", ")[0]
            self.assertIn(of_double, ("2 of 2",) if figure.reference == "all" else ("0", "no path"), figure.quantity)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    options, rest = parser.parse_known_args()
    PROGRAM = options.program
    unittest.main(argv=[sys.argv[0], *rest])
