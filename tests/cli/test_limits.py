#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the mesh cannot represent is said by `check`, and at the start of `run` in its log."""
from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools")]

from crackle_launch import environment  # noqa: E402

PROGRAM = Path()
PLATE = """[ensemble]
samples = 1
[specimen]
size = ["1 mm", "10 mm", "20 mm"]
[mesh]
spacing = "1 mm"
[material]
youngs_modulus = "32 GPa"
poisson_ratio = 0.2
density = "2450 kg/m^3"
[fracture]
toughness = "30 J/m^2"
impulse = "1e-8 MPa^2 s"
[[boundary]]
on = "z-min"
fix = ["x", "y", "z"]
[[boundary]]
on = "z-max"
velocity = [{}]
[time]
duration = "1 us"
[sections]
y = ["5 mm"]
"""
BENDING = "boundary[1] loads the plate across its thickness of 1 mm, which has 1 cell: bending out of the plane is about 3.9 times too stiff"
FAST = "but a wave takes 5.25 us along the body: equilibria leave out inertia that matters; set time.start = \"rest\""


class Limits(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def output(self, velocity: str, *arguments: str) -> str:
        (self.folder / "plate.toml").write_text(PLATE.format(velocity))
        done = subprocess.run([PROGRAM, arguments[0], "plate.toml", *arguments[1:]], cwd=self.folder, env=environment(),
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_check_and_run_say_the_same(self):
        bent_fast = '"20 m/s", "free", "free"'
        checked = self.output(bent_fast, "check")
        self.assertIn(f"Warning: {BENDING}", checked)
        self.assertIn(FAST, checked)
        ran = self.output(bent_fast, "run", "-o", "out")
        log = (self.folder / "out/run.log").read_text()
        for said in (ran, log):
            self.assertIn(f"warning: {BENDING}", said)
            self.assertIn(FAST, said)
        self.assertLess(log.index(BENDING), log.index("samples to do"), "said before the first sample")

    def test_nothing_is_said_of_a_slow_pull(self):
        said = self.output('"free", "free", "1 mm/s"', "check")
        self.assertNotIn("too stiff", said)
        self.assertNotIn("inertia", said)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=Path, required=True)
    arguments, rest = parser.parse_known_args()
    PROGRAM = arguments.program.resolve()
    unittest.main(argv=[sys.argv[0], *rest])
