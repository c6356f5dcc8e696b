#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the mesh cannot represent, what is hardly meant and what would fail: said by `check` as by `run`."""
from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools")]

import command_lines  # noqa: E402
from crackle_launch import environment  # noqa: E402

PROGRAM = Path()
PLATE = """[ensemble]
samples = 1
[specimen]
size = ["1 mm", "10 mm", "20 mm"]
[mesh]
base = "shared"
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
duration = "3 us"
[sections]
y = ["5 mm"]
"""
PULLED = PLATE.replace("velocity = [{}]", 'force = ["0 N", "0 N", "0 N"]\nrate = ["0 N/s", "0 N/s", "1 N/s"]')
BENDING = "boundary[1] loads the plate across its thickness of 1 mm, which has 1 cell: bending out of the plane is about 3.9 times too stiff"
FAST = "but a wave takes 5.25 us along the body, so inertia cannot be neglected; set time.start = \"rest\""


class Limits(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def assert_no_warning(self, said: str) -> None:
        """None but that of a plate without a notch, whose toughness alone tells nothing of its surface."""
        self.assertEqual([line for line in said.splitlines() if line.startswith("Warning") and "with a toughness alone" not in line], [])

    def call(self, text: str, *arguments: str) -> subprocess.CompletedProcess[str]:
        (self.folder / "plate.toml").write_text(text)
        return command_lines.crackle(PROGRAM, arguments[0], "plate.toml", *arguments[1:], cwd=self.folder)

    def output(self, velocity: str, *arguments: str) -> str:
        done = self.call(PLATE.format(velocity), *arguments)
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
        self.assertLess(log.index(BENDING), log.index("samples to compute"), "said before the first sample")

    def test_a_slow_pull_gives_no_warning(self):
        said = self.output('"free", "free", "1 mm/s"', "check")
        self.assertNotIn("too stiff", said)
        self.assertNotIn("inertia", said)

    def assert_same_refusal(self, text: str, reason: str, options: tuple[str, ...] = ()) -> str:
        """What makes every sample of `run` fail makes `check` fail with the same words; returns what check prints."""
        checked = self.call(text, "check", *options)
        self.assertEqual(checked.returncode, 1, checked.stdout)
        self.assertIn(f"sample 0 would fail: computation: {reason}", checked.stderr)
        self.assertNotIn("is valid", checked.stdout)
        ran = self.call(text, "run", "-o", "out")
        self.assertEqual(ran.returncode, 2, ran.stdout + ran.stderr)
        self.assertIn(f"failed: sample 0: computation: {reason}", ran.stdout)
        shutil.rmtree(self.folder / "out")
        return checked.stdout

    def test_a_body_that_may_turn_is_refused(self):
        text = PULLED.replace('fix = ["x", "y", "z"]', 'fix = ["z"]') + """
[[boundary]]
on = "y-min"
region = { z = ["0 mm", "1 mm"] }
fix = ["x"]
[[boundary]]
on = "x-min"
region = { y = ["0 mm", "1 mm"], z = ["0 mm", "1 mm"] }
fix = ["y"]
"""
        reason = "rigid-body motion is not constrained (turn about z)"
        self.assert_same_refusal(text, reason)
        self.assert_same_refusal(text, reason, ("--no-measure",))

    def test_loads_above_the_first_break_are_refused(self):
        self.assert_same_refusal(PULLED.replace('"0 N"]', '"5 kN"]'), "the load at time 0, 5000 N, exceeds that of the first break")

    def test_lines_that_nearly_coincide_give_a_warning(self):
        halves = """[[boundary]]
on = "z-max"
region = {{ y = ["0 mm", "5 mm"] }}
velocity = ["free", "free", "1 mm/s"]
[[boundary]]
on = "z-max"
region = {{ y = ["{} mm", "10 mm"] }}
velocity = ["free", "free", "1 mm/s"]
"""
        whole = PLATE[PLATE.index('[[boundary]]\non = "z-max"'):PLATE.index("[time]")]
        told = ("the region of boundary[1] makes the mesh as fine as 0.019 mm, with 1 mm as the finest spacing given, and may need millions "
                "of points; lines and corners that should coincide need equal coordinates")
        near = PLATE.replace(whole, halves.format("5.019"))
        self.assertIn(f"Warning: {told}\n", self.call(near, "check", "--no-measure").stdout)
        self.assertIn(f"warning: {told}\n", self.call(near.replace("3 us", "0.1 us"), "run", "-o", "out").stdout)
        self.assert_no_warning(self.call(PLATE.replace(whole, halves.format("5")), "check", "--no-measure").stdout)

    def test_a_blow_is_not_taken_for_a_weak_load(self):
        blow = (ROOT / "jobs" / "verification" / "kalthoff.toml").read_text().replace('spacing = "2 mm"', 'spacing = "4 mm"')
        self.assertNotIn("far from breaking", self.call(blow, "check").stdout)
        self.assertIn("far from breaking", self.call(blow.replace("16.5 m/s", "16.5 um/s"), "check").stdout)

    def test_loads_that_break_nothing_give_a_warning(self):
        said = self.call(PULLED.replace("rate =", "# rate =").replace('"0 N"]', '"10 N"]'), "check").stdout
        self.assertRegex(said, r"Warning: the loads do not break the body: they reach 10 N, \d(\.\d)? % of the roughly [12]\d\d(\.\d)? N needed for the first break")
        ran = self.call(PULLED.replace("rate =", "# rate =").replace('"0 N"]', '"10 N"]'), "run", "-o", "held")
        self.assertIn("warning: no sample broke under its loads", ran.stdout)
        self.assertNotIn("no sample broke", self.call(PULLED, "run", "-o", "broken").stdout)
        slow = PULLED.replace("[time]", '[time]\nstart = "rest"')
        told = self.assert_same_refusal(slow, "time steps: strains of")
        self.assertRegex(told, r"in equilibrium they reach the first break after [12]\d\d(\.\d)? s, at about [12]\d\d(\.\d)? N, "
                               r"but the phase lasts 3 us")

    def test_a_start_from_rest_is_judged_by_waves(self):
        """A pulse of pressure on a bar whose far end is held comes back as tension from the loaded end."""
        bar = (PLATE[:PLATE.index("[[boundary]]")].replace('"10 mm", "20 mm"', '"2 mm", "40 mm"').replace('toughness = "30 J/m^2"', 'strength = "3 MPa"')
               + """[[boundary]]
on = "z-max"
fix = ["x", "y", "z"]
[[boundary]]
on = "z-min"
traction = ["0 Pa", "0 Pa", "5 MPa"]
history = [["0 us", 0], ["2 us", 1], ["6 us", 1], ["8 us", 0]]
""" + PLATE[PLATE.index("[time]"):].replace("[time]", '[time]\nstart = "rest"').replace("1 us", "20 us").replace('y = ["5', 'z = ["20'))
        waves = "waves of the loads reach about {} MPa (an estimate), up to twice that where they are reflected; the strength is {} MPa at least"
        said = self.call(bar, "check").stdout
        self.assertIn(waves.format(5, 3) + ".\n", said)
        self.assertNotIn("Warning: the loads", said)
        said = self.call(bar.replace("3 MPa", "500 MPa"), "check").stdout
        self.assertIn(waves.format(5, 500) + ".\n", said)
        self.assertIn("Warning: the loads hardly break the body: their waves reach 1 % of its strength; raise them\n", said)
        sudden = bar[:bar.index("history")] + bar[bar.index("[time]"):]
        self.assertIn("damping.bulk = [0.5, 1.2]", self.call(sudden, "check").stdout)
        damped = self.call(sudden + "[damping]\nbulk = [0.06, 1.2]\n", "check").stdout
        self.assertNotIn("damping.bulk = [0.5, 1.2] leaves", damped)
        self.assertIn(waves.format(5, 3) + ".\n", damped)

    def test_a_rate_without_effect_gives_a_warning(self):
        said = self.call(PULLED, "check").stdout
        self.assertRegex(said, r"loading += in equilibrium up to the first break \([\d.]+ N, after [\d.]+ s\); until then the loading rate has no effect")
        self.assert_no_warning(said)

    def test_loads_from_rest_that_break_the_body_are_no_slip(self):
        fast = PLATE.format('"free", "free", "20 m/s"').replace("[time]", '[time]\nstart = "rest"').replace("3 us", "20 us")
        unheld = fast.replace('fix = ["x", "y", "z"]', 'velocity = ["free", "free", "-20 m/s"]')
        for text in (fast, unheld):
            checked = self.call(text, "check")
            self.assertEqual((checked.returncode, checked.stderr), (0, ""), checked.stdout)
            self.assert_no_warning(checked.stdout)

    def test_own_values_of_random_inputs_refuse_nothing(self):
        """Values that no sample has are measured, or said to be not; the samples' draws decide."""
        text = PULLED.replace('toughness = "30 J/m^2"', 'strength = "0.1 MPa"').replace('"0 N"]', '"30 N"]') + """
[[random]]
key = "fracture.strength"
distribution = "uniform"
lower = "30 MPa"
upper = "40 MPa"
"""
        checked = self.call(text, "check")
        self.assertEqual(checked.returncode, 0, checked.stderr)
        self.assertIn("not measured, with the input's own values: the load at time 0", checked.stdout)
        self.assertEqual(self.call(text, "run", "-o", "out").returncode, 0)

    def test_every_case_of_a_sweep_is_begun(self):
        text = PULLED.replace('"0 N"]', '"100 N"]') + """
[[sweep]]
key = "fracture.toughness"
values = ["0.5 J/m^2", "30 J/m^2", "1 J/m^2"]
"""
        checked = self.call(text, "check", "--samples", "1")
        self.assertEqual(checked.returncode, 1)
        for line in ("sample 0 would fail: computation: the load at time 0", "case 2: sample 0 would fail: computation: the load"):
            self.assertIn(line, checked.stderr)
        self.assertNotIn("case 1:", checked.stderr)
        self.assertIn("Case 1: fracture.toughness = 30 J/m^2", checked.stdout.replace('"', ""))

    def test_samples_are_begun_by_their_own_draws(self):
        text = PULLED.replace("samples = 1", "samples = 6").replace('"0 N"]', '"100 N"]') + """
[[random]]
key = "fracture.toughness"
distribution = "uniform"
lower = "1 J/m^2"
upper = "30 J/m^2"
"""
        checked = self.call(text, "check", "--samples", "6")
        ran = self.call(text, "run", "-o", "out")
        failed = set(re.findall(r"failed: (sample \d+):", ran.stdout))
        self.assertTrue(0 < len(failed) < 6, ran.stdout)
        self.assertIn(f"Of 6 samples, {len(failed)} would fail.", checked.stdout)
        self.assertEqual(set(re.findall(r"(sample \d+) would fail", checked.stderr)), failed)
        self.assertEqual(checked.returncode, 1)

    def test_stresses_at_time_0_are_looked_at_in_more_samples(self):
        """A tempered plate: 50 MPa in its middle by the parabola, up to twice as much by the mesh, on which they scatter."""
        text = """[ensemble]
samples = 4
seed = 1
[specimen]
size = ["4 mm", "4 mm", "12 mm"]
[mesh]
spacing = "0.8 mm"
[material]
youngs_modulus = "70 GPa"
poisson_ratio = 0.0
density = "2500 kg/m^3"
[fracture]
strength = "{}"
nucleation = "own-stress"
impulse = "1e-8 MPa^2 s"
[[boundary]]
on = "z-min"
fix = ["z"]
[[boundary]]
on = "x-min"
region = {{ y = ["2 mm", "2 mm"] }}
fix = ["x", "y"]
[[boundary]]
on = "x-max"
region = {{ y = ["2 mm", "2 mm"] }}
fix = ["y"]
[[boundary]]
on = "z-max"
displacement = ["free", "free", "0 mm"]
rate = ["free", "free", "0.001 mm/s"]
[[initial.stress]]
along = "x"
surface = "-100 MPa"
[time]
duration = "20 us"
[sections]
z = ["6 mm"]
"""
        share = float(re.search(r"stress at time 0 += .*; ([\d.]+) % of the strength", self.call(text.format("400 MPa"), "check").stdout)[1])
        told = r"At time 0 the stress in sample 0 is [\d.e+]+ % of the strength; of 3 samples more, (\d) would fail\."
        failed = re.search(told, self.call(text.format(f"{4.1 * share} MPa"), "check").stdout)
        checked = self.call(text.format(f"{4.1 * share} MPa"), "check")
        every = self.call(text.format(f"{4.1 * share} MPa"), "check", "--samples", "4")
        n_failed = int(re.search(r"Of 4 samples, (\d) would fail", every.stdout)[1])
        self.assertTrue(0 < n_failed < 4, every.stdout)
        self.assertEqual(int(failed[1]), n_failed)
        self.assertEqual(checked.returncode, 1)
        self.assertRegex(checked.stderr, "sample [123] would fail: computation: at time 0 the initial stress")
        self.assertNotIn("At time 0", self.call(text.format("400 MPa"), "check").stdout)

    def test_large_strains_give_a_warning(self):
        """A strength of a quarter of Young's modulus in a bar that is pulled."""
        soft = PULLED.replace("32 GPa", "1.1 MPa").replace("30 J/m^2", "60 J/m^2").replace("3 us", "3 ms")
        self.assertRegex(self.call(soft, "check").stdout, r"Warning: at the first break \d+ % of the body is strained by more than 5 %")
        self.assertNotIn("strained by", self.call(PULLED, "check").stdout)
        said = self.call(soft, "run", "-o", "out").stdout
        self.assertRegex(said, r"warning: the peak load has moved by [\d.]+ mm, \d+ % of the body's longest extent")

    def test_a_single_sample_gives_a_note(self):
        self.assertIn("One sample shows no scatter", self.call(PULLED, "check", "--no-measure").stdout)
        self.assertNotIn("One sample", self.call(PULLED.replace("samples = 1", "samples = 2"), "check", "--no-measure").stdout)

    def test_a_mesh_that_takes_minutes_is_announced_at_once(self):
        """A spacing typed a tenth as large: said before the mesh is made, which the time limit cuts short."""
        fine = PULLED + '[[mesh.region]]\nz = ["5 mm", "15 mm"]\nspacing = "0.04 mm"\n'
        (self.folder / "plate.toml").write_text(fine)
        with subprocess.Popen([PROGRAM, "check", "plate.toml"], cwd=self.folder, env=environment(), stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, text=True) as check:
            assert check.stdout
            for line in check.stdout:
                if line.startswith(("Warning: a mesh", "nodes")):
                    break
            check.terminate()
        self.assertRegex(line, r"Warning: a mesh has about [\d.]+ million nodes and takes minutes or more to make: "
                               r"the spacing is 0\.04 mm at its finest \(mesh\.region\[0\]\)")

    def test_slips_are_named_by_check_and_run(self):
        soft = PULLED.replace("32 GPa", "32000 mPa").replace("3 us", "0.1 s")  # waves are as slow as in a gel
        for command in (("check", "--no-measure"), ("run", "-o", "out")):
            self.assertIn("did you mean 32 GPa? mPa is millipascal", self.call(soft, *command).stdout)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=Path, required=True)
    arguments, rest = parser.parse_known_args()
    PROGRAM = arguments.program.resolve()
    unittest.main(argv=[sys.argv[0], *rest])
