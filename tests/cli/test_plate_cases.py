#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of the plates in jobs/verification: their inputs and references, and coarse runs of two of them."""
from __future__ import annotations

import argparse
import math
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "jobs" / "gallery"), str(ROOT / "jobs" / "verification")]

import command_lines  # noqa: E402
import interface  # noqa: E402
import plates  # noqa: E402
from crackle_runs import JOBS, run, with_keys  # noqa: E402


class References(unittest.TestCase):
    def test_kinks_are_those_of_the_closed_form(self):
        self.assertEqual(plates.kink(0), 0)
        self.assertAlmostEqual(plates.kink(90), -math.degrees(math.acos(1 / 3)), delta=2e-3)
        for mixing in (15, 45, 60):
            k1, k2 = math.cos(math.radians(mixing)), math.sin(math.radians(mixing))
            closed = 2 * math.degrees(math.atan((k1 - math.sqrt(k1 ** 2 + 8 * k2 ** 2)) / (4 * k2)))
            self.assertAlmostEqual(plates.kink(mixing), closed, delta=2e-3)
        self.assertAlmostEqual(plates.kink_at_one_spacing(45), plates.kink(45), delta=2e-3)  # where the stress along it vanishes
        self.assertGreater(plates.kink_at_one_spacing(15), plates.kink(15))
        self.assertLess(plates.kink_at_one_spacing(60), plates.kink(60))

    def test_the_disk_has_the_stress_of_point_loads_in_its_middle(self):
        point_loads = 8 * 1000 / (math.pi * 2 * plates.DISK_RADIUS * plates.DISK_THICKNESS)
        self.assertAlmostEqual(plates.hondros(1000, np.array([0.0]))[0] / point_loads, 1, delta=0.02)

    def test_shallow_notches_have_the_stress_of_a_half_plane(self):
        self.assertAlmostEqual(plates.semicircular_notches(0), 3.065)


class Runs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder, self.program = Path(folder.name), Path(OPTIONS.program)

    def test_the_inputs_are_right(self):
        blunt = (JOBS / "blunt-notch.toml").read_text()
        for text in (plates.inclined_slot(60), plates.level_slot(60), plates.beam(0.9),
                     *(with_keys(blunt, keys) for keys in plates.BLUNT_LAWS.values())):
            source = self.folder / "input.toml"
            source.write_text(text)
            result = command_lines.crackle(OPTIONS.program, "check", "--no-measure", source)
            self.assertEqual(result.returncode, 0, result.stderr)

    def test_a_weak_interface_deflects_a_crack_and_a_strong_one_does_not(self):
        text = with_keys((JOBS / "interface.toml").read_text(), {"ensemble.samples": "1"})
        for toughness, expected in ((3, True), (30, False)):
            samples = run(with_keys(text, {"interface.toughness": f'"{toughness} J/m^2"'}), self.folder / f"interface-{toughness}", self.program)
            self.assertEqual(interface.is_deflected(samples[0]), expected, toughness)

    def test_fringes_of_a_disk_are_those_of_hondros(self):
        text = with_keys((JOBS / "disk.toml").read_text(), {"ensemble.samples": "1", "mesh.spacing": '"1.5 mm"'})
        ratio = plates.diameter_fringes(text, self.folder / "disk", self.program)
        print(f"fringe order over Hondros': {ratio.mean():.3f}, each place +- {ratio.std():.3f}")
        self.assertAlmostEqual(ratio.mean(), 1, delta=0.02)
        self.assertLess(ratio.std(), 0.02)

    def test_cracks_leave_slots_in_the_direction_of_the_largest_hoop_stress(self):
        for text, inclination, expected in ((plates.inclined_slot(60), 60, plates.kink_at_one_spacing(60)),
                                            (plates.level_slot(30), 0, plates.kink(30))):
            samples = run(with_keys(text, {"ensemble.samples": "3"}), self.folder / f"slot-{inclination}", self.program)
            found = [angle for sample in samples for angle in plates.kink_angles(sample, inclination)]
            print(f"mean kink of {len(found)} cracks {np.mean(found):.1f} degrees, expected {expected:.1f}")
            self.assertGreaterEqual(len(found), 3)
            self.assertAlmostEqual(np.mean(found), expected, delta=6)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", required=True)
    OPTIONS, remaining = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0], *remaining], verbosity=2)
