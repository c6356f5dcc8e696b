#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of jobs/calibrate-release: its interval on synthetic results, and the release speed that a small plate was computed with."""
from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "jobs")]

import calibrating  # noqa: E402
import in_process  # noqa: E402
from crackle_launch import environment  # noqa: E402
from crackle_runs import RunError, with_keys  # noqa: E402
from small_input import small_input  # noqa: E402

OPTIONS = None
SPEEDS = np.array([200.0, 400.0, 800.0, 1600.0, 3200.0])


def result(speed: np.ndarray) -> np.ndarray:
    return 180 + 130 * np.log(speed / SPEEDS[0])


class Interval(unittest.TestCase):
    def test_exact_results_give_the_release_speed(self):
        results = np.repeat(result(SPEEDS)[:, None], 5, axis=1)
        best, low, high = calibrating.release_speed(SPEEDS, results, result(np.array(500.0)), 13.0)
        self.assertAlmostEqual(best / 500, 1, places=12)
        self.assertAlmostEqual(low / 500, np.exp(-1.96 * 0.1), delta=0.01)
        self.assertAlmostEqual(high / 500, np.exp(1.96 * 0.1), delta=0.02)

    def test_the_interval_covers_and_says_where_it_ends(self):
        random, covered, n = np.random.default_rng(4), 0, 100
        for _ in range(n):
            results = result(SPEEDS)[:, None] + random.normal(0, 20, 8) + random.normal(0, 10, (5, 8))
            _, low, high = calibrating.release_speed(SPEEDS, results, random.normal(result(np.array(640.0)), 15), 15.0)
            covered += low < 640 < high
        print(f"95 % intervals cover the release speed in {covered} of {n} calibrations")
        self.assertTrue(86 <= covered <= 99)
        results = np.repeat(result(SPEEDS)[:, None], 5, axis=1)
        self.assertTrue(np.isnan(calibrating.release_speed(SPEEDS, results, 1000.0, 5.0)).all())
        low, high = calibrating.release_speed(SPEEDS, -results, -result(SPEEDS[0]), 20.0)[1:]  # a result that falls with the speed
        self.assertTrue(np.isnan(low) and SPEEDS[0] < high < 1.5 * SPEEDS[0])
        _, low, high = calibrating.release_speed(SPEEDS, results, result(SPEEDS[0]), 20.0)
        self.assertTrue(np.isnan(low) and SPEEDS[0] < high < 1.5 * SPEEDS[0])


class Command(unittest.TestCase):
    def test_inputs_with_other_values(self):
        text = '[ensemble]\nsamples = 3\n[fracture]\ntoughness = "60 J/m^2"\nrelease_time = "1 us"'
        self.assertNotIn("release_time", with_keys(text, {"fracture.release_time": None}))
        changed = tomllib.loads(with_keys(text, {"fracture.release_time": '"2 us"', "ensemble.seed": "4"}))
        self.assertEqual((changed["fracture"]["release_time"], changed["ensemble"]), ("2 us", {"samples": 3, "seed": 4}))
        for other in (text.replace("[fracture]", "[ fracture ]"), text.replace("release_time", "  release_time"), "[fracture"):
            for value in (None, '"2 us"'):
                with self.assertRaises(RunError):
                    with_keys(other, {"fracture.release_time": value})

    def test_a_small_plate(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            text = small_input()  # with cracks long enough to have a speed in each sample
            for old, new in (('"2 mm"\nnotch_spacing = "1 mm"', '"0.9 mm"'), ("30 mm", "20 mm"), ("15 mm", "10 mm"), ('"1 mm"', '"0.6 mm"'), ("20 us", "90 us")):
                self.assertIn(old, text)
                text = text.replace(old, new)
            (folder / "plate.toml").write_text(text)

            words = (str(folder / "plate.toml"), "-o", str(folder / "out"), "--program", OPTIONS.program, "--speeds", "300 m/s", "2000 m/s")

            def calibrate(*options: str) -> subprocess.CompletedProcess:
                return in_process.call(calibrating.main, *words, *options)
            first = subprocess.run([str(ROOT / "jobs" / "calibrate-release"), *words, "--measured", "300 m/s", "--error", "5 m/s"],
                                   capture_output=True, text=True, env=environment(), check=False)
            self.assertEqual(first.returncode, 0, first.stderr)
            means = [float(mean) for mean in re.findall(r"crack_speed_max ([\d.]+)", first.stdout)]
            print(first.stdout)
            self.assertEqual(len(means), 3)
            self.assertGreater(means[2], means[1] + 50)  # the release speed reaches the program
            measured = (means[1] + means[2]) / 2
            second = calibrate("--measured", f"{measured} m/s", "--error", "5 m/s").stdout
            found = float(re.search(r'release_speed = "([\d.]+) m/s"', second)[1])
            self.assertAlmostEqual(found, 600000**0.5, delta=10)
            with mock.patch.object(calibrating, "FACTORS", (1, 2)):  # of five
                started = in_process.call(calibrating.main, folder / "plate.toml", "-o", folder / "out", "--program", OPTIONS.program,
                                          "--measured", "300 m/s", "--error", "5 m/s", "--samples", "3")
            computed = [float(speed) for speed in re.findall(r"release speed ([\d.]+) m/s", started.stdout)]
            v, rayleigh = 300, 961.8  # epoxy's with nu = 0.3: Gamma / G = 2
            self.assertAlmostEqual(computed[0] / (v * (2.26 / (1 - v / rayleigh) ** 1.05) ** (1 / 1.68)), 1, delta=0.02)
            self.assertAlmostEqual(computed[1] / computed[0], 2, delta=0.01)
            self.assertTrue((folder / "out" / "calibration.png").is_file())
            wrong = calibrate("--measured", "300 m/s", "--error", "5 m/s", "--result", "crack_spead")
            self.assertEqual(wrong.returncode, 1)
            self.assertIn("no result 'crack_spead' with numbers", wrong.stderr)
            wrong = calibrate("--measured", "300 m/s", "--error", "5 m/s", "--result", "peak_load")
            self.assertEqual(wrong.returncode, 1)
            self.assertIn("--measured: 'peak_load' is in N", wrong.stderr)
            for options, reason in ((("--samples", "2"), "three or more"), (("--error=-5 m/s",), "must not be negative"),
                                    (("--speeds", "900 m/s"), "give two or more"), (("--error", "5 N"), "in the unit of --measured")):
                refused = calibrate("--measured", "300 m/s", "--error", "5 m/s", *options)
                self.assertEqual((refused.returncode, refused.stdout), (1, ""))
                self.assertIn(reason, refused.stderr)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0], *rest])
