#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of what tools/crackle-report computes."""
from __future__ import annotations

import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "cli")]

from crackle_report import confidence, input_text, reading  # noqa: E402
from crackle_report.plate import Notch, Plate  # noqa: E402
from crackle_report.ranks import LeaderFrame, leading_from_crossings, make_ranks  # noqa: E402
from crackle_report.results import CrossSection  # noqa: E402
from crackle_report.statistics import (look_schedule, make_statistics, wilson_half_width,  # noqa: E402
                                       wilson_interval)
from synthetic_ensemble import write_ensemble  # noqa: E402


class Numbers(unittest.TestCase):
    def test_students_quantiles_are_those_of_the_tables(self):
        for degrees, expected in ((1, 12.7062), (2, 4.30265), (3, 3.18245), (10, 2.22814), (199, 1.97196)):
            found = confidence.student_quantile(0.95, degrees)
            print(f"t(0.95, {degrees}) = {found:.6f}, tables {expected}")
            self.assertAlmostEqual(found, expected, delta=1e-5 * expected)

    def test_running_values_are_those_of_the_leading_samples(self):
        values = np.array([np.nan, 3.0, 1.0, np.nan, 2.5, 7.0])
        mean, half_width = confidence.running_mean(values), confidence.running_half_width(values, 0.9)
        self.assertTrue(np.isnan(mean[0]) and np.isnan(half_width[1]))
        for i in range(2, len(values)):
            leading = values[:i + 1][~np.isnan(values[:i + 1])]
            t = confidence.student_quantile(0.9, len(leading) - 1)
            self.assertAlmostEqual(mean[i], leading.mean(), places=14)
            self.assertAlmostEqual(half_width[i], t * leading.std(ddof=1) / np.sqrt(len(leading)), places=13)

    def test_wilsons_interval(self):
        # 8 of 20 at 95 %: 0.2188 to 0.6134.
        self.assertAlmostEqual(wilson_half_width(0.4, 20, 0.95), (0.6134 - 0.2188) / 2, delta=1e-4)
        self.assertGreater(wilson_half_width(0.0, 20, 0.95), 0.05)
        np.testing.assert_allclose(wilson_interval(8, 20, 0.95), (0.2188, 0.6134), atol=1e-4)
        self.assertEqual(wilson_interval(0, 5, 0.95)[0], 0)

    def test_looks_share_the_error_probability(self):
        self.assertEqual(look_schedule(200, 30), [30, 45, 68, 102, 153, 200])
        self.assertEqual(look_schedule(20, 30), [20])
        with tempfile.TemporaryDirectory() as folder:
            write_ensemble(Path(folder), 9)
            samples = reading.read_ensemble(Path(folder)).samples
        np.testing.assert_array_equal(make_statistics(samples, 0.9, n_looks=2).z_half_width,
                                      make_statistics(samples, 0.95).z_half_width)

    def test_lengths_are_read_with_their_units(self):
        for text, metres in (("24.5 mm", 24.5e-3), ("2.45 cm", 24.5e-3), ("5e3 um", 5e-3), ("1 inch", 0.0254),
                             ("0.14 m", 0.14), ("140 millimeters", 0.14), ("7mm", 7e-3), (".5 µm", 5e-7)):
            self.assertAlmostEqual(input_text.length(text), metres, delta=1e-12 * metres)
        for text in ("5 s", "mm", "5", "5 mm^2", "5 qm"):
            with self.assertRaises(ValueError, msg=text):
                input_text.length(text)

    def test_sections_are_numbered_y_first(self):
        np.testing.assert_allclose(input_text.sections({"sections": {"z": ["3 cm"], "y": ["7 mm", "9 mm"]}}),
                                   [(1, 7e-3), (1, 9e-3), (2, 0.03)])

    def test_the_outline_encloses_the_plate_without_its_slots(self):
        plate = Plate((5e-3, 24.5e-3, 140e-3), (
            Notch("y-min", 65e-3, 6e-3, 0.6e-3), Notch("y-max", 75e-3, 5e-3, 0.5e-3),
            Notch("y-min", 30e-3, 2e-3, 0.4e-3), Notch("z-max", 10e-3, 3e-3, 0.7e-3),
            Notch("z-min", 12e-3, 4e-3, 0.8e-3)))
        y, z = plate.outline().T
        area = 0.5 * np.sum(y * np.roll(z, -1) - np.roll(y, -1) * z)
        expected = 24.5e-3 * 140e-3 - sum(n.depth * n.height for n in plate.notches)
        print(f"area {area:.9e} m^2, exact {expected:.9e} m^2")
        self.assertAlmostEqual(area, expected, delta=1e-12 * expected)
        self.assertEqual(plate.tip(1), (24.5e-3 - 5e-3, 75e-3))

    def test_statistics_leave_out_what_failed(self):
        with tempfile.TemporaryDirectory() as folder:
            write_ensemble(Path(folder), 9, failed=(2, 5))
            samples = reading.read_ensemble(Path(folder)).samples
        expected = np.isfinite(samples.position).sum(axis=0)
        samples.position[[2, 5]] = 0.07
        statistics = make_statistics(samples, 0.95)
        np.testing.assert_array_equal(statistics.reached, expected)
        self.assertAlmostEqual(statistics.pattern_share.sum(), 1.0, places=14)
        self.assertEqual(statistics.running_mean.shape, samples.position.shape)


class Ranks(unittest.TestCase):
    notches = (Notch("y-min", 67.5e-3, 5.5e-3, 0.6e-3), Notch("y-max", 72.5e-3, 5.5e-3, 0.6e-3))
    plate = Plate((5e-3, 24.5e-3, 140e-3), notches)
    sections = tuple(CrossSection(1, y) for y in (7e-3, 9e-3, 12.25e-3, 17.5e-3))  # 9 mm has no image

    def test_the_frame_is_that_of_the_body(self):
        frame = LeaderFrame(self.plate, self.sections)
        self.assertEqual(frame.reference, [0, 0])
        self.assertEqual([(t.reflects_y, t.reflects_z, t.notch) for t in frame.turns],
                         [(False, False, (0, 1)), (True, True, (1, 0))])
        np.testing.assert_allclose(frame.turned(np.array([[7e-3, 73e-3]]), 1), [[17.5e-3, 67e-3]])
        self.assertEqual([frame.row_of("leader", 1, 1), frame.row_of("leader", 1, 0), frame.row_of("follower", 1, 0)],
                         [0, None, 0])
        other = Plate(self.plate.size, (self.notches[0], Notch("y-max", 72.5e-3, 5e-3, 0.6e-3)))
        self.assertEqual(LeaderFrame(other, self.sections).reference, [0, 1])
        beside = Plate(self.plate.size, (self.notches[0], Notch("y-min", 72.5e-3, 5.5e-3, 0.6e-3)))
        self.assertEqual([(t.reflects_y, t.reflects_z) for t in LeaderFrame(beside, self.sections).turns],
                         [(False, False), (False, True)])

    def test_statistics_are_in_the_frame_of_the_leading_crack(self):
        with tempfile.TemporaryDirectory() as folder:
            write_ensemble(Path(folder), 3)
            samples = reading.read_ensemble(Path(folder)).samples
        no = np.nan
        samples.position = 1e-3 * np.array([[[67, 66.8, 66.5, 66.9], [no, no, no, 73]],
                                            [[67, no, 71, no], [no, no, 73.3, 72.8]], [[68, no, no, no]] * 2])
        samples.numbers["pattern"] = np.array([1, 2, 0])
        frame = LeaderFrame(self.plate, self.sections)
        ranks = make_ranks(frame, samples, np.array([0, 1, -1]), 0.95, 1)
        leader, follower = ranks["leader"], ranks["follower"]
        self.assertEqual(leader.reached.tolist(), [[2, 1, 2, 1]])
        self.assertEqual(leader.counted.tolist(), [[2, 1, 2, 2]])
        np.testing.assert_allclose(leader.z_mean, [[67.1e-3, 66.8e-3, 66.6e-3, 66.9e-3]])
        np.testing.assert_allclose(leader.z_half_width[0, 0], 12.7062047364 * 0.1e-3)
        self.assertEqual(follower.reached.tolist(), [[0, 0, 1, 2]])
        np.testing.assert_allclose(follower.z_mean[0, 2:], [69e-3, 73e-3])
        np.testing.assert_allclose(ranks["leader/one_crack"].z_mean[0, 2], 66.5e-3)
        np.testing.assert_allclose(ranks["leader/two_cracks"].z_mean[0, 2], 66.7e-3)

    def test_sections_across_z_are_turned_like_those_across_y(self):
        upright = Plate((5e-3, 140e-3, 24e-3), (Notch("z-min", 60e-3, 5e-3, 0.6e-3), Notch("z-max", 80e-3, 5e-3, 0.6e-3)))
        frame = LeaderFrame(upright, (CrossSection(1, 70e-3), CrossSection(2, 8e-3), CrossSection(2, 10e-3),
                                      CrossSection(2, 16e-3)))
        values = np.arange(16.0).reshape(2, 2, 4) * 1e-3
        found, counts = frame.ranked(values, np.array([0, 1]), "leader", are_positions=True)
        np.testing.assert_array_equal(found[0, 0], values[0, 0])
        np.testing.assert_allclose(found[1, 0], [12e-3, 125e-3, np.nan, 127e-3])
        self.assertEqual(counts[:, 0].tolist(), [[True] * 4, [True, True, False, True]])
        found, _ = frame.ranked(values, np.array([0, 1]), "leader")
        np.testing.assert_array_equal(found[1, 0], [values[1, 1, 0], values[1, 1, 3], np.nan, values[1, 1, 1]])
        no = np.nan  # shares of 3/19, 5/19, 11/19 and 11/19, 9/19, 3/19
        for position, expected in (([[1, 1, 1, 1], [1, no, no, 1]], 0), ([[1, 1, no, no], [1, 1, 1, 1]], 1)):
            self.assertEqual(leading_from_crossings(upright, frame.sections, np.array(position)), expected)

    def test_the_leading_notch_follows_from_crossings(self):
        no = np.nan
        for z, expected in (([[1, 1, 1, 1], [no, no, no, 1]], 0), ([[1, no, no, no], [no, 1, 1, 1]], 1),
                            ([[1, no, 1, no], [no, no, 1, 1]], -1), ([[no] * 4] * 2, -1)):
            self.assertEqual(leading_from_crossings(self.plate, self.sections, np.array(z, float)), expected, z)

    def test_the_kept_campaign_has_its_leaders(self):
        ensemble = reading.read_ensemble(ROOT / "jobs" / "paper")
        leader = ensemble.ranks["leader"]
        print("leaders", np.bincount(ensemble.leading + 1), "mean", 1e3 * leader.z_mean[0], "+-", 1e3 * leader.z_half_width)
        if ensemble.leading_is_derived:
            self.assertLess((ensemble.leading < 0).sum(), 0.02 * len(ensemble.samples))
        self.assertLess(leader.z_half_width.max(), 0.1e-3)
        self.assertGreater(ensemble.statistics.z_half_width[0, 2], 3 * leader.z_half_width[0, 2])


if __name__ == "__main__":
    unittest.main(verbosity=2)
