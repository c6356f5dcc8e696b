#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What `crackle stats --json` says, against Python's own statistics of the same samples, and how the report reads it."""
from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from scipy import stats

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "cli")]

import command_lines  # noqa: E402
from crackle import program  # noqa: E402
from crackle_report import reading  # noqa: E402
from synthetic_ensemble import SLOTS, WIDTH, write_ensemble  # noqa: E402


def document_of(folder: Path, *options: str) -> dict:
    return json.loads(command_lines.crackle(os.environ["CRACKLE"], "stats", folder, "--json", "--read-only", *options).stdout)


def numbers(values: list) -> np.ndarray:
    return np.array(values, float)


class Folders(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name) / "out"


class Document(Folders):
    def test_statistics_are_those_of_the_rows(self):
        write_ensemble(self.folder, 12, failed=(2, 5), pending=(9,))
        found = document_of(self.folder)
        self.assertEqual([found[name] for name in ("n_samples", "n_needed", "n_done", "n_failed", "n_left")], [12, 12, 9, 2, 1])
        rows, statistics = found["samples"], found["statistics"]
        self.assertEqual([number for number, status in enumerate(rows["status"]) if status != 1], [2, 5, 9])
        self.assertIn("diverged after 500", rows["error"][2])
        position = numbers(found["crack_path"]["position"])
        mean, half_width = (numbers(statistics[name]) for name in ("z_mean", "z_half_width"))
        running, running_half_width = (numbers(statistics[name]) for name in ("running_mean", "running_half_width"))
        spread = numbers(found["crack_path"]["z_spread"])
        for notch, section in np.ndindex(*mean.shape):
            column = position[:, notch, section]
            present = column[np.isfinite(column)]
            n = len(present)
            self.assertEqual(statistics["reached"][notch][section], n)
            if n > 1:
                np.testing.assert_allclose(mean[notch, section], present.mean(), rtol=1e-14)
                np.testing.assert_allclose(statistics["z_std"][notch][section], present.std(ddof=1), rtol=1e-9)
                expected = stats.t.ppf(0.975, n - 1) * stats.sem(present)
                np.testing.assert_allclose(half_width[notch, section], expected, rtol=1e-9)
                np.testing.assert_allclose(statistics["z_quantile"][notch][section], np.quantile(present, [0, 0.25, 0.5, 0.75, 1]))
                np.testing.assert_allclose(statistics["spread_mean"][notch][section], np.nanmean(spread[:, notch, section]))
            for i in range(12):
                so_far = column[:i + 1][np.isfinite(column[:i + 1])]
                if len(so_far) > 1:
                    self.assertAlmostEqual(running[i, notch, section], so_far.mean(), places=14)
                    np.testing.assert_allclose(running_half_width[i, notch, section],
                                               stats.t.ppf(0.975, len(so_far) - 1) * stats.sem(so_far), rtol=1e-9)
                else:
                    self.assertTrue(np.isnan(running_half_width[i, notch, section]))
        done = np.array(rows["status"]) == 1
        for pattern in range(4):
            n = int((np.array(rows["pattern"])[done] == pattern).sum())
            self.assertEqual(statistics["pattern_share"][pattern], n / 9)
            interval = stats.binomtest(n, 9).proportion_ci(0.95, "wilson")
            np.testing.assert_allclose([statistics["pattern_lower"][pattern], statistics["pattern_upper"][pattern]], interval,
                                       atol=1e-12)
        results = {result["name"]: result for result in found["results"]}
        force = numbers(rows["onset_force"])[done]
        np.testing.assert_allclose(results["onset_force"]["quantiles"], np.quantile(force, [0, 0.25, 0.5, 0.75, 1]))
        branching = np.array(rows["bifurcations"])[done]
        n_any = int((branching > 0).sum())
        self.assertEqual([results["bifurcations"][name] for name in ("mean", "n_any", "share")],
                         [branching.mean(), n_any, n_any / 9])
        np.testing.assert_allclose([results["bifurcations"][name] for name in ("lower", "upper")],
                                   stats.binomtest(n_any, 9).proportion_ci(0.95, "wilson"), atol=1e-12)
        outcomes = np.array(rows["outcome"])[done]
        self.assertEqual(results["outcome"]["counts"], [int((outcomes == k).sum()) for k in range(5)])

    def test_what_older_files_lack_is_missing(self):
        write_ensemble(self.folder, 4)
        found = document_of(self.folder)
        self.assertNotIn("first_break_x", found["samples"])
        self.assertNotIn("first_break_x", [result["name"] for result in found["results"]])
        self.assertNotIn("first_break_x", reading.read_ensemble(self.folder).samples.numbers)

    def test_the_outline_encloses_the_plate_without_its_slots(self):
        slots = (("y-min", 65, 6, 0.6), ("y-max", 75, 5, 0.5), ("y-min", 30, 2, 0.4), ("z-max", 10, 3, 0.7),
                 ("z-min", 12, 4, 0.8))
        write_ensemble(self.folder, 1, slots=slots)
        plate = reading.read_ensemble(self.folder).plate
        (polygon,) = plate.polygons
        y, z = polygon.T
        area = 0.5 * np.sum(y * np.roll(z, -1) - np.roll(y, -1) * z)
        expected = WIDTH * 140e-3 - 1e-6 * sum(depth * height for _, _, depth, height in slots)
        print(f"area {area:.9e} m^2, exact {expected:.9e} m^2")
        self.assertAlmostEqual(area, expected, delta=1e-12 * expected)
        self.assertEqual(len(polygon), 4 + 4 * len(slots))
        np.testing.assert_allclose(plate.notch_tip, [[6e-3, 65e-3], [WIDTH - 5e-3, 75e-3], [2e-3, 30e-3], [10e-3, 137e-3],
                                                     [12e-3, 4e-3]])
        self.assertEqual([plate.notch_axis.tolist(), plate.notch_direction.tolist()], [[1, 1, 1, 2, 2], [1, -1, 1, -1, 1]])
        np.testing.assert_allclose(plate.notch_slot[1], [[WIDTH - 5e-3, WIDTH], [74.75e-3, 75.25e-3]])
        np.testing.assert_allclose(plate.slot_ends[:2], [64.7e-3, 65.3e-3])

    def test_the_frame_of_the_leading_crack_is_that_of_the_body(self):
        write_ensemble(self.folder, 3)
        ensemble = reading.read_ensemble(self.folder)
        self.assertEqual([(s.reference, s.reflects_y, s.reflects_z, s.notch) for s in ensemble.symmetries],
                         [(0, False, False, [0, 1]), (0, True, True, [1, 0])])
        np.testing.assert_allclose(ensemble.symmetries[1].mapped(np.array([[7e-3, 73e-3]]), ensemble.plate), [[17.5e-3, 67e-3]])
        ranks = ensemble.ranks
        self.assertEqual([ranks["leader"].row_of(0, 0), ranks["leader"].row_of(0, 1), ranks["follower"].row_of(0, 1)], [0, None, 0])
        first, second = SLOTS
        for other, expected in ((("y-max", 75, 5, 0.6), [(0, False, False), (1, False, False)]),
                                (("y-min", 75, *second[2:]), [(0, False, False), (0, False, True)])):
            write_ensemble(self.folder, 1, slots=(first, other))
            symmetries = reading.read_ensemble(self.folder).symmetries
            self.assertEqual([(s.reference, s.reflects_y, s.reflects_z) for s in symmetries], expected)

    def test_statistics_by_rank_are_in_that_frame(self):
        rows = write_ensemble(self.folder, 9, failed=(3,))
        ensemble = reading.read_ensemble(self.folder)
        z = np.array([row["position"] for row in rows])
        turned = 140e-3 - z[:, ::-1, ::-1]
        leading = ensemble.leading[:, None]
        path = np.where(leading[..., None] == 1, turned, z)
        path[ensemble.leading < 0] = np.nan
        for group, notch, chosen in (("leader", 0, np.ones(9, bool)), ("follower", 1, np.ones(9, bool)),
                                     ("leader/one_crack", 0, ensemble.samples.pattern == 1),
                                     ("leader/two_cracks", 0, ensemble.samples.pattern == 2)):
            positions = path[chosen & (ensemble.leading >= 0), notch]
            reached = np.isfinite(positions).sum(axis=0)
            np.testing.assert_array_equal(ensemble.ranks[group].reached[0], reached)
            np.testing.assert_array_equal(ensemble.ranks[group].counted[0], [len(positions)] * 5)
            for k in np.flatnonzero(reached):
                np.testing.assert_allclose(ensemble.ranks[group].z_mean[0, k], np.nanmean(positions[:, k]), rtol=1e-13)

    def test_how_well_the_mean_is_known(self):
        write_ensemble(self.folder, 12)
        found = document_of(self.folder)
        leader, precision = found["statistics"]["leader"], found["statistics"]["precision"]
        counts = np.array(leader["reached"]) >= 2
        widths = np.where(counts, numbers(leader["z_half_width"]), -np.inf)
        self.assertEqual([precision["row"], precision["section"]], list(np.unravel_index(widths.argmax(), widths.shape)))
        self.assertEqual(precision["half_width"], widths.max())
        self.assertEqual((precision["half_width_wanted"], precision["is_of_the_input"]), (0.01 * WIDTH, False))
        needed = []
        for deviation, reached in zip(numbers(leader["z_std"])[counts], np.array(leader["reached"])[counts]):
            n = next(n for n in range(2, 100_000) if stats.t.ppf(0.975, n - 1) * deviation / np.sqrt(n) <= 0.01 * WIDTH)
            needed.append(n * 12 / reached)
        self.assertGreaterEqual(precision["n_samples_needed"], max(needed))
        self.assertLess(precision["n_samples_needed"], 1.02 * max(needed) + 1)
        write_ensemble(self.folder, 40, stop='half_width = "0.4 mm"\nconfidence = 0.9\nmin_samples = 10')
        statistics = document_of(self.folder)["statistics"]
        self.assertEqual((statistics["looks"], statistics["n_looks"], statistics["confidence"]), ([10, 15, 23, 35, 40], 5, 0.9))
        self.assertEqual((statistics["precision"]["half_width_wanted"], statistics["precision"]["is_of_the_input"]), (0.4e-3, True))
        n = statistics["reached"][0][0]
        np.testing.assert_allclose(statistics["z_half_width"][0][0],
                                   stats.t.ppf(0.99, n - 1) * statistics["z_std"][0][0] / np.sqrt(n), rtol=1e-9)


class Program(Folders):
    def test_a_missing_program_is_named(self):
        with mock.patch.dict(os.environ, {"CRACKLE": "/nowhere/crackle"}):
            with self.assertRaisesRegex(program.ResultsError, "^there is no program '/nowhere/crackle'$"):
                reading.read_ensemble(self.folder)
        with mock.patch.dict(os.environ, {"CRACKLE": "", "PATH": "/nowhere"}), mock.patch.object(program, "_PLACES", ()):
            with self.assertRaisesRegex(program.ResultsError, "build it with tools/build, or"):
                reading.read_ensemble(self.folder)
        self.assertEqual(program.find_program(Path("/bin/sh")), "/bin/sh")

    def test_only_the_statistics_need_it(self):
        write_ensemble(self.folder, 2)
        with mock.patch.dict(os.environ, {"CRACKLE": "/nowhere/crackle"}):
            files = reading.SampleFiles(self.folder)
            self.assertGreater(len(files.crack(1).time), 100)
            self.assertEqual(len(files.frames(1).time), 4)
            self.assertIsNone(files.crack(7))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    options, rest = parser.parse_known_args()
    os.environ["CRACKLE"] = os.path.abspath(options.program)
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
