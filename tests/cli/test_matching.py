#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Experiments beside samples, without the program: statistics by hand, paths as numbers, whole matches of made-up experiments, and
what p-values and powers promise."""
from __future__ import annotations

import io
import sys
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from typing import Any, Callable, Optional

import numpy as np
from PIL import Image
from scipy import stats

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path.append(str(ROOT / "tools"))

from crackle import match_text, matching, weibull  # noqa: E402
from crackle import path_frame as paths  # noqa: E402
from crackle import rank_tests as tests  # noqa: E402
from crackle.experiments import TABLES, Experiment, ExperimentsError, read_experiments  # noqa: E402
from crackle.ways import Ways  # noqa: E402
from effort import repetitions  # noqa: E402
from crackle.observations import (Arm, ObservedSample, ObservedSamples, Start, Symmetry, arrival_at, check_places,  # noqa: E402
                                  crack_start_of, observe)

NAN, MM = np.nan, 1e-3


def picture(width: int, height: int, kind: str = "PNG") -> bytes:
    file = io.BytesIO()
    Image.new("L", (width, height)).save(file, kind)
    return file.getvalue()


def column(*values: float) -> np.ndarray:
    return np.array(values, float)[:, None]


class Statistics(unittest.TestCase):
    def test_distances(self):
        def one(a: list, b: list, missing: float = 9) -> float:
            return float(tests.distances(np.array([a], float), np.array([b], float), missing)[0, 0])

        self.assertAlmostEqual(one([0, 3], [4, 6]), np.sqrt(25 / 2))
        self.assertAlmostEqual(one([0, NAN], [4, 6]), np.sqrt((16 + 81) / 2), msg="not arriving is a value")
        self.assertAlmostEqual(one([0, NAN], [4, NAN]), np.sqrt(16 / 2))
        self.assertEqual(tests.largest_difference(np.array([[0, 5], [3, NAN], [1, 9]])), 4)
        self.assertEqual(tests.largest_difference(column(2, 2, NAN)), 1, "something, so that it differs")
        # Distances of 1 and 2 parts in another unit count alike: each has a root mean square of 1.
        one_d, other = tests.distances_of(column(0, 1)), tests.distances_of(column(0, 1000))
        self.assertAlmostEqual(tests.joint_distances([one_d, other])[0, 1], 1)

    def test_ranks(self):
        def test(*values: float) -> tests.RankTest:
            return tests.rank_test(tests.distances_of(column(*values)))

        self.assertEqual(test(10, 0, 1, 2, 3).p, 1 / 5, "the least there is")
        np.testing.assert_allclose(test(0, 1, 5).mean, (3, 2.5, 4.5))
        self.assertEqual(test(0, 1, 2, 3).p_mean, 2 / 4, "mean distances 2, 4/3, 4/3, 2: ties count")
        self.assertEqual(test(1.5, 0, 1, 2, 3).p_mean, 1)
        # In the middle of two groups no mean distance is small, but the nearest are far: of 17 rows, the fourth.
        between = test(50, *range(8), *range(100, 108))
        self.assertEqual((between.k, between.p_mean, between.p_near), (4, 1, 1 / 17))
        self.assertLessEqual(between.p, 2 / 17)
        self.assertEqual((tests.samples_needed(0.05), tests.samples_needed(0.01), tests.least_p_value(4)), (19, 99, 1 / 5))

    def test_groups(self):
        # 2 * 3.5 - 0.5 - 16 / 9; of the 10 ways to choose two, {4, 6} is farther apart; by depth six are.
        test = tests.group_test(tests.distances_of(column(0, 1, 2, 4, 6)), 2)
        self.assertAlmostEqual(test.energy, 7 - 0.5 - 16 / 9)
        self.assertEqual((test.are_all, test.n_permutations, test.p_energy, test.p_depth, test.p), (True, 10, 0.2, 0.6, 0.4))
        many = tests.group_test(tests.distances_of(column(90, 91, 92, 93, 94, *range(40))), 5)
        self.assertEqual((many.are_all, many.n_permutations), (False, 10_000))
        self.assertLessEqual(max(many.p_energy, many.p_depth), 2e-4)
        # Many experiments are counted in another way, with the same result.
        found = tests.distances_of(column(*np.random.default_rng(1).normal(size=20)))
        rows = np.array([np.arange(15), np.arange(5, 20)])
        by_hand = [2 * found[np.ix_(a, b)].mean() - found[np.ix_(a, a)].mean() - found[np.ix_(b, b)].mean()
                   for a in rows for b in [np.setdiff1d(np.arange(20), a)]]
        np.testing.assert_allclose(tests._energies(rows, found), by_hand)

    def test_scatter(self):
        # Variances 2 of the experiments and 5 / 3 of four samples; F(1, 3) from tables.
        found = tests.scatter(column(11, 13), column(1, 2, 3, 4), 0)
        self.assertEqual((found.shift.value, found.degrees), (9.5, 1))
        self.assertAlmostEqual(found.ratio.value, np.sqrt(2 / (5 / 3)))
        self.assertAlmostEqual(found.ratio.lower, np.sqrt(1.2 / 17.4434433), places=6)
        self.assertAlmostEqual(found.ratio.upper, np.sqrt(1.2 / 1.15718913e-3), places=4)
        # An error of reading of variance 1 leaves 1 of 2, and with one of 4 nothing is left to see.
        self.assertAlmostEqual(tests.scatter(column(11, 13), column(1, 2, 3, 4), 1).ratio.value, np.sqrt(1 / (5 / 3)))
        self.assertEqual(tests.scatter(column(11, 13), column(1, 2, 3, 4), 2).ratio.value, 0)
        # Two independent columns of equal variance count twice, the same one twice once.
        for samples, degrees in (([[1, 1], [1, -1], [-1, 1], [-1, -1]], 2), ([[1, 1], [2, 2], [3, 3], [7, 7]], 1)):
            self.assertAlmostEqual(tests.scatter(np.array([[0, 0], [1, 1.0]]), np.array(samples, float), 0).degrees, degrees)
        ended = tests.scatter(np.array([[0, 0], [2, NAN]]), np.array([[1, 1], [2, 2], [3, 3.0]]), 0)
        self.assertEqual((ended.n_columns, ended.n_samples), (1, 3), "an experiment ended before")
        self.assertEqual(tests.scatter(np.array([[0, 0], [2, 1.0]]), np.array([[1, 1], [2, 2], [3, NAN]]), 0).n_columns, 1, "a third did")



def curves(random: np.random.Generator, n: int, scale: float = 1, shift: float = 0) -> np.ndarray:
    """Of random offset, slope and bend; their variance is 1 + 1 / 3 + 1 / 2 on average."""
    s = np.linspace(0, 1, 12)
    return shift + scale * random.normal(size=(n, 3)) @ np.array([np.ones(12), s, np.sin(2 * np.pi * s)])


class Promises(unittest.TestCase):
    """Sizes over N trials."""
    N = repetitions(200, 400)
    MOST = 0.05 + 3 * np.sqrt(0.05 * 0.95 / N)  # three standard errors above 5 %

    def test_p_values_of_left_out_samples_are_uniform(self):
        random, n = np.random.default_rng(1), 39
        for scale, is_uniform in ((1, True), (3, False)):
            p = [tests.rank_test(tests.distances_of(np.vstack([curves(random, 1, scale), curves(random, n)]))) for _ in range(self.N)]
            for values in ([each.p for each in p], [each.p_near for each in p]):
                counts = np.histogram(np.ceil(np.array(values) * (n + 1) - 1e-9), np.arange(0.5, n + 2, 4))[0]
                if is_uniform:  # `p` lies above uniform where two rows share the least rank, never below
                    self.assertLessEqual(np.mean(np.array(values) <= 0.05), self.MOST)
                    self.assertLess(((counts - counts.mean()) ** 2 / counts.mean()).sum(), 60)
                else:
                    self.assertGreater(np.mean(np.array(values) <= 0.05), 0.3)

    def test_groups_have_their_size_and_the_power_that_is_printed(self):
        random, m, n = np.random.default_rng(2), 5, 25
        deviation, found = np.sqrt(1 + 1 / 3 + 1 / 2), np.zeros(3)
        rows = np.array([np.arange(m), *(random.choice(m + n, m, replace=False) for _ in range(199))])
        for _ in range(self.N):
            samples = curves(random, n)
            for k, experiments in enumerate((curves(random, m), curves(random, m, 1, deviation), curves(random, m, 2))):
                apart = tests.distances_of(np.vstack([experiments, samples]))
                found[k] += any((statistic >= statistic[0] - 1e-9).sum() <= 5
                                for statistic in (tests._energies(rows, apart), tests._depth_ranks(apart)[rows].sum(axis=1)))
        self.assertLess(found[0] / self.N, self.MOST)
        promised = [tests.power(curves(random, n), m) for _ in range(3)]
        for share, counts in ((found[1], [one.of_shift for one in promised]), (found[2], [one.of_scatter for one in promised])):
            self.assertAlmostEqual(np.mean(counts) / tests.N_TRIALS, share / self.N, delta=0.12)
        # As many experiments as samples leave as many samples as there are.
        self.assertGreater(tests.power(curves(random, 20), 18).of_shift, 0.4 * tests.N_TRIALS)

    def test_intervals_cover(self):
        random, covered = np.random.default_rng(3), np.zeros(2)
        for _ in range(self.N):
            found = tests.scatter(curves(random, 6, 1.5, 0.4) + random.normal(0, 0.5, (6, 12)), curves(random, 60), 0.5, 0.9)
            covered += [one.lower <= truth <= one.upper for one, truth in ((found.ratio, 1.5), (found.shift, 0.4))]
        np.testing.assert_allclose(covered / self.N, 0.9, atol=0.065)


class Paths(unittest.TestCase):
    def test_projections(self):
        line = np.array([[0, 0], [3, 0], [3, 4.0]])
        self.assertEqual(paths.length_of(line), 7)
        at, distance = paths.project(line, np.array([[2, 1], [4, 9.0]]))
        np.testing.assert_allclose(at, (2, 7))
        np.testing.assert_allclose(distance, (1, np.hypot(1, 5)))
        np.testing.assert_allclose(paths.point_at(line, 5), (3, 2))
        np.testing.assert_allclose(paths.extended(line, 1)[[0, -1]], ((-1, 0), (3, 5)))

    def test_offsets_are_those_along_the_normals(self):
        c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)  # parallel lines at 30 degrees; the middle one is the medoid
        lines = [np.array([[-s * shift, c * shift], [10 * c - s * shift, 10 * s + c * shift]]) for shift in (-0.2, 0.0, 0.3)]
        frame = paths.path_frame(lines, [paths.Window(np.zeros(2), np.array([10 * c, 10 * s]))])
        self.assertFalse(frame.is_along_y)
        for line, offset in zip(lines, (-0.2, 0, 0.3)):
            np.testing.assert_allclose(paths.offsets(frame, line), offset, atol=1e-12)
        half = paths.offsets(frame, np.array([[0, 0], [5 * c, 5 * s]]))
        self.assertEqual(np.isnan(half).sum(), paths.N_STATIONS / 2)

    def test_stations_are_in_the_window(self):
        lines = [np.array([[0, z], [10, z]], float) for z in (0, 1, 2)]

        def ends(*windows: tuple) -> Optional[np.ndarray]:
            frame = paths.path_frame(lines, [paths.Window(np.array(first, float), np.array(last, float), *more) for first, last, *more in windows])
            return frame and frame.place[[0, -1], 0]

        step = 0.5 / paths.N_STATIONS
        np.testing.assert_allclose(ends(((2, 0), (6, 0))), (2 + 4 * step, 6 - 4 * step))
        self.assertAlmostEqual(ends(((2, 0), (6, 0), True))[1], 10 - 8 * step)
        self.assertAlmostEqual(ends(((6, 0), (2, 0), True))[0], 6 * step)
        both = ends(((2, 0), (6, 0)), ((4, 0), (9, 0)))
        self.assertTrue(4 < both[0] < both[1] < 6)
        self.assertIsNone(ends(((2, 0), (4, 0)), ((5, 0), (9, 0))))
        # A path across the others meets no station, and its window does not count.
        np.testing.assert_allclose(ends(((2, 0), (6, 0)), ((4, -6), (5, 8))), ends(((2, 0), (6, 0))))
        frame = paths.path_frame(lines, [])
        self.assertTrue(np.isnan(paths.offsets(frame, np.array([[4, -6], [5, 8.0]]))).all())
        self.assertFalse(np.isnan(paths.offsets(frame, np.array([[0, 0], [8, 9.0]]))).all())
        self.assertTrue(paths.runs_along(frame.curve, np.array([-20, 3.0]), np.array([30, 1.0])), "longer than all others")

    def test_errors_of_reading_have_their_deviation_and_correlation(self):
        line, random = np.array([[0, 0], [40, 0.0]]), np.random.default_rng(1)
        read = np.array([paths.with_reading_error(line, 0.1, 2, random) for _ in range(2000)])
        np.testing.assert_allclose(read[:, 11, 0] - read[:, 10, 0], 1)  # half a correlation length
        self.assertAlmostEqual((read[:, 10, 1] ** 2).mean(), 0.01, delta=0.001)
        self.assertAlmostEqual((read[:, 10, 1] * read[:, 12, 1]).mean(), 0.01 * np.exp(-1), delta=0.001)
        self.assertIs(paths.with_reading_error(line, 0, 2, random), line)


def wall(*corners: tuple[float, float]) -> np.ndarray:
    ends = MM * np.array(corners, float)
    return np.stack([ends, np.roll(ends, -1, axis=0)], axis=1)


def start(name: str, tip: tuple = (0, 0), end: tuple = (0, 0), walls: Optional[np.ndarray] = None, **kind: bool) -> Start:
    walls = np.zeros((0, 2, 2)) if walls is None else walls
    slot = np.array([walls.min(axis=(0, 1)), walls.max(axis=(0, 1))]) if len(walls) else np.zeros((2, 2))
    return Start(name, **{"is_straight": False, "is_free_surface": False, "is_hole": False, **kind}, tip=MM * np.array(tip, float),
                 end=MM * np.array(end, float), slot=slot, walls=walls)


NOTCH = start("notch-0", (4, 9), (16, 9), is_straight=True)
HOLE = start("hole-0", walls=wall((7, 8), (9, 8), (9, 10), (7, 10)), is_hole=True)


def path(f: Callable[[np.ndarray], Any], end: float = 12) -> np.ndarray:
    """z = 9 + f from y = 4 to 12 mm."""
    y = np.arange(4, end + 1e-9, 0.25)
    return MM * np.stack([y, 9 + f(y - 4) + 0 * y], axis=1)


class Made:
    """Samples of a plate with one notch, whose cracks are random curves, and experiments like them."""

    def __init__(self, seed: int, n: int, starts: tuple[Start, ...] = (NOTCH,), symmetries: tuple[Symmetry, ...] = ()) -> None:
        self.random = np.random.default_rng(seed)
        samples = [self.sample(i, self.crack(), len(starts)) for i in range(n)]
        document = {"seed": seed, "planned": n, "failed": [], "undecided": [], "base": "own", "has_points": False, "replicates": 1}
        self.samples = ObservedSamples(samples, list(starts), list(symmetries), np.zeros(2), MM * np.array([16, 24.0]), document, [])

    def crack(self, scale: float = 1, shift: float = 0) -> np.ndarray:
        a, b, c = self.random.normal(size=3)
        return path(lambda s: shift + scale * (0.1 * a + 0.05 * b * s + 0.1 * c * np.sin(s)) + 0.02 * s * s)

    def loads(self) -> dict[str, float]:
        onset = 100 + 5 * self.random.normal()
        return {"onset_load": onset, "peak_load": onset + 1 + abs(self.random.normal())}

    def sample(self, number: int, points: np.ndarray, n_starts: int = 1) -> ObservedSample:
        return ObservedSample(number, 0, **self.loads(), arms=[[Arm(points, 1e-6 * np.arange(len(points)))], *([] for _ in range(n_starts - 1))])

    def experiment(self, name: str, scale: float = 1, shift: float = 0) -> Experiment:
        line = paths.with_reading_error(self.crack(scale, shift), 0.05 * MM, MM, self.random)
        return Experiment(name, [line], 0.05 * MM, MM, **self.loads())

    def match(self, *experiments: Experiment) -> dict[str, Any]:
        return matching.match_with(experiments, self.samples).document

    def one(self, experiment: Experiment) -> dict[str, Any]:
        return self.match(experiment)["experiments"][0]


class Matches(unittest.TestCase):
    def test_the_farther_of_two_that_are_alone_is_more_unusual(self):
        places = np.array([*range(8), 20.0])  # of samples; the last one has a way of its own

        def p_value(own: float, way: int = 2) -> float:
            rows = np.abs(np.append(own, places)[:, None] - places)
            return Ways(["most", "one", "new"], [way], np.array([0] * 8 + [1]), rows).p_value(0)

        self.assertEqual([p_value(own) for own in (40, 20, 12)], [1 / 10, 2 / 10, 2 / 10])
        self.assertEqual((p_value(3, 0), p_value(20, 1)), (1, 2 / 10))

    def test_stiffness_is_a_quantity(self):
        made = Made(5, 30)
        for i, sample in enumerate(made.samples.samples):
            sample.stiffness = np.nan if i == 3 else 1e6 + 1e3 * i
        by = made.one(Experiment("soft", stiffness=9e5, stiffness_error=100.0))["by"]["stiffness"]
        self.assertEqual((by["p_value"], by["unit"], by["left_out"], by["nearest"][0]["sample"]), (1 / 30, "N/m", [3], 0))
        found = made.match(Experiment("a", stiffness=1.01e6), Experiment("b", stiffness=1.02e6), Experiment("c", peak_load=1.0))
        self.assertEqual(found["set"]["by"]["stiffness"]["n_experiments"], 2)
        self.assertIn("Left out by stiffness: c, no stiffness.", match_text.text(found))

    def test_finds_the_sample_that_is_the_experiment(self):
        made = Made(4, 30)
        same = made.samples.samples[17]
        line = same.arms[0][0].points
        experiment = Experiment("same", [line], tip_times=np.array([4e-6, 10e-6]), tip_places=line[[4, 10]], onset_load=same.onset_load,
                                peak_load=same.peak_load + 0.5)
        one = made.one(experiment)
        self.assertEqual(list(one["by"]), ["path", "onset_load", "peak_load", "tip_times", "jointly"])
        for name in ("path", "onset_load", "tip_times"):
            nearest = one["by"][name]["nearest"]
            self.assertEqual(nearest[0]["sample"], 17, name)
            self.assertAlmostEqual(nearest[0]["distance"], 0, places=7)
            self.assertGreater(nearest[1]["distance"], 2 * nearest[0]["distance"])
        self.assertEqual(one["p_value"], one["by"]["jointly"]["p_value"])
        self.assertEqual((one["path"]["departures"], one["note"], len(one["way"]["ways"])), ([], "", 1))
        # Usual is that of the samples alone, whatever the experiment.
        far = made.one(replace(experiment, peak_load=1000.0))["by"]["peak_load"]
        self.assertEqual(far["usual_distance"], one["by"]["peak_load"]["usual_distance"])

    def test_tells_where_a_path_leaves_the_samples(self):
        made = Made(5, 39)
        kinked = Experiment("kinked", [path(lambda s: 0.02 * s * s + np.where(s > 5, 0.4 * (s - 5), 0))])
        one = made.one(kinked)
        departure, = one["path"]["departures"]
        self.assertTrue(9 * MM < departure["from"][0] < 11.5 * MM and departure["to"][0] > 11.5 * MM)
        self.assertGreater(departure["beyond"], 0.15 * MM, "towards +z")
        self.assertGreater(one["path"]["beyond"], one["path"]["most_beyond"])
        self.assertEqual(one["path"]["band_p_value"], 1 / 40)
        text = str(matching.match_with([kinked], made.samples))
        self.assertRegex(text, r"kinked: its path leaves the band of 39 samples from .* towards (larger|smaller) z; none of these samples leave .*: outside")
        # The band is that of the samples alone, so that an experiment cannot widen it.
        low, high = (np.array(one["path"][name], float) for name in ("band_lower", "band_upper"))
        of_samples = np.array(one["path"]["sample_offsets"], float)
        np.testing.assert_allclose((low, high), (np.nanmin(of_samples, axis=0), np.nanmax(of_samples, axis=0)))

    def test_a_crack_that_ended_is_a_value(self):
        made = Made(6, 39)
        ended = Experiment("ended", [path(lambda s: 0.02 * s * s, 8)])
        self.assertGreater(made.one(ended)["by"]["path"]["p_value"], 0.3, "the picture ends there")
        ended.arrested = True
        one = made.one(ended)
        self.assertEqual(one["by"]["path"]["p_value"], 1 / 40, "all others went on")
        self.assertEqual(one["path"]["band_p_value"], 1 / 40)
        self.assertTrue(one["path"]["departures"][-1]["is_missing"])
        self.assertIn("where it has ended; none", match_text.path_text(one))
        for sample in made.samples.samples[::2]:
            arm = sample.arms[0][0]
            sample.arms[0][0] = Arm(arm.points[:17], arm.time[:17])
        made.samples.paths.clear()
        one = made.one(ended)
        self.assertGreater(one["by"]["path"]["p_value"], 0.2, "half of the others ended there, too")
        self.assertFalse([part for part in one["path"]["departures"] if part["is_missing"]])

    def test_ways_round_a_hole(self):
        made = Made(7, 0, (NOTCH, HOLE))
        lines = {"through": lambda s: 0 * s, "below": lambda s: -2.4 * np.sin(np.pi * s / 8), "above": lambda s: 2.4 * np.sin(np.pi * s / 8)}

        def wobbled(way: str, end: float = 12) -> np.ndarray:
            a, b = made.random.normal(0, 0.03, 2)
            return path(lambda s: lines[way](s) + a * s / 4 + b * np.sin(s), end)

        for i in range(24):
            if i < 18:  # a crack into the hole, and what goes on behind it as a line of its own
                front, rear = path(lambda s: 0 * s, 6.75), wobbled("through")[21:]
                arm = Arm(np.vstack([front, rear]), np.zeros(len(front) + len(rear)), holes=frozenset([1]))
                made.samples.samples.append(replace(made.sample(i, front, 2), arms=[[arm], []]))
            else:
                made.samples.samples.append(made.sample(i, wobbled("below"), 2))
        counts = {"through hole-0": 18, "past hole-0 at smaller z": 6}
        for experiment, way, n in ((Experiment("a", [wobbled("below")]), "past hole-0 at smaller z", 6),
                                   (Experiment("b", [wobbled("through")]), "through hole-0", 18),
                                   (Experiment("c", [wobbled("through", 6.75), wobbled("through")[21:]]), "through hole-0", 18),
                                   (Experiment("d", [wobbled("above")]), "past hole-0 at larger z", 0)):
            one = made.one(experiment)
            self.assertEqual((one["way"]["name"], one["way"]["n_samples"]), (way, n), experiment.name)
            self.assertEqual({each["name"]: each["n_samples"] for each in one["way"]["ways"] if each["n_samples"]}, counts)
            if n:
                self.assertEqual((one["by"]["path"]["n_samples"], len(one["path"]["samples"])), (n, n))
                self.assertGreater(one["path"]["place"][-1][0], 11 * MM, "also behind the hole")
                self.assertLess(one["path"]["farthest"]["distance"], 0.3 * MM)
            else:
                self.assertEqual((one["p_value"], one["by"]["path"]["n_samples"]), (1 / 25, 24))
                self.assertIn("outside the samples", match_text.path_text(one))
                self.assertGreater(one["path"]["farthest"]["distance"], 1.5 * MM)
        # A picture that ends before the hole, or at it, does not know what comes.
        for end, name in ((6, "to (11.7 mm, 8.98 mm)"), (6.9, "into hole-0")):
            one = made.one(Experiment("e", [wobbled("through", end)]))
            self.assertEqual((one["way"]["name"][:4], one["way"]["n_samples"]), (name[:4], 18))
        self.assertEqual(made.one(Experiment("f", [wobbled("through", 6)], arrested=True))["way"]["n_samples"], 0)
        text = str(matching.match_with([Experiment("g", [wobbled("below")]), Experiment("h", [wobbled("through")]),
                                        Experiment("i", [wobbled("through")])], made.samples))
        self.assertIn("Left out by path: g, it took another way (past hole-0 at smaller z).", text)

    def test_groups_with_nothing_between(self):
        made = Made(8, 20)
        for sample in made.samples.samples[::2]:
            sample.arms[0][0] = Arm(sample.arms[0][0].points + MM * np.array([0, 0]) + np.outer(np.linspace(0, 1, 33), (0, 12 * MM)), np.zeros(33))
        made.samples.paths.clear()
        one = made.one(Experiment("up", [made.crack() + np.outer(np.linspace(0, 1, 33), (0, 12 * MM))]))
        self.assertEqual(sorted(way["n_samples"] for way in one["way"]["ways"]), [10, 10])
        between = made.one(Experiment("between", [made.crack() + np.outer(np.linspace(0, 1, 33), (0, 2 * MM))]))
        self.assertEqual((between["way"]["n_samples"], between["p_value"]), (0, 1 / 21))

    def test_what_is_no_distance(self):
        made = Made(9, 25)
        reverse = Experiment("reversed", [made.crack()[::-1]])
        one = made.one(reverse)
        self.assertIn("digitized from its end", one["note"])
        self.assertGreater(one["by"]["path"]["p_value"], 0.05)
        across = made.one(Experiment("across", [MM * np.array([[8, 5], [8.2, 14.0]])]))
        self.assertIn("check origin, angle and mirror", across["note"])
        for by in across["by"].values():
            self.assertEqual((by["mean_distance"], by["nearest"]), (None, []))
        forgotten = made.one(Experiment("forgotten", [made.crack() - (0, 8 * MM)]))
        self.assertRegex(forgotten["note"], r"moved by \(.* mm, (7|8)(\.\d+)? mm\).* is origin right\?")
        far = made.one(Experiment("far", peak_load=0.101))
        self.assertIn("a thousand times smaller than the samples'", far["note"])
        self.assertEqual(made.one(Experiment("near", peak_load=101.0))["note"], "")

    def test_leaves_out_and_names_what_has_no_value(self):
        made = Made(10, 25)
        made.samples.samples[3].onset_load = NAN
        made.samples.samples[4].arms = [[]]
        made.samples.document.update(failed=[31], undecided=[32, 33])
        experiment = made.experiment("one")
        found = made.match(experiment)
        one = found["experiments"][0]
        self.assertEqual(one["by"]["onset_load"]["left_out"], [3])
        self.assertEqual((one["by"]["path"]["n_samples"], one["by"]["jointly"]["n_samples"]), (24, 23))
        self.assertIn({"name": "no crack from there", "n_samples": 1}, one["way"]["ways"])
        text = match_text.text(found)
        self.assertIn("1 failed (31), 2 undecided (32, 33)", text)
        self.assertIn("Left out by onset load, which they lack: 1 sample (3).", text)

    def test_warns_of_samples_that_are_not_what_it_needs(self):
        made = Made(11, 12)
        made.samples.document.update(base="shared", replicates=3)
        arm = made.samples.samples[2].arms[0][0]
        made.samples.samples[2].arms[0][0] = replace(arm, is_turned=True)
        warnings = made.match(made.experiment("one"))["warnings"]
        for warning, part in zip(warnings, ("not valid", "not exact", "19 are needed", "in 1 of the samples another crack leads"), strict=True):
            self.assertIn(part, warning)
        by = made.match(*(Experiment(str(i), peak_load=90.0 + i) for i in range(4)))["set"]["by"]["peak_load"]
        self.assertEqual(by["advice"], "No conclusion: the samples share their base.")

    def test_a_set_tells_scatter_and_shift(self):
        made = Made(17, 40)

        def by_path(*of: float) -> dict[str, Any]:
            return made.match(*(replace(made.experiment(str(i), *of), onset_load=None, peak_load=None) for i in range(8)))["set"]["by"]["path"]

        alike = by_path()
        self.assertGreater(alike["p_value"], 0.05)
        self.assertIn("no evidence", alike["advice"])
        self.assertIn("may be chance", alike["advice"])
        scattered = by_path(3)
        self.assertLess(scattered["p_value"], 0.05)
        self.assertIn("more disturbance or a varying material", scattered["advice"])
        self.assertAlmostEqual(scattered["scatter_ratio"]["value"], 3, delta=1.2)
        # An interval without 1 is not called chance; the farthest experiment is named.
        unconfirmed = match_text.advice({**scattered, "p_value": 0.16})
        self.assertNotIn("chance", unconfirmed.split(". ")[0])
        self.assertIn(f"look at {scattered['farthest']}", unconfirmed)
        few = match_text.advice({**alike, "n_experiments": 3, "power": {"twice_the_scatter": 0.39}})
        self.assertIn("3 experiments cannot tell", few)
        shifted = by_path(1, -0.6)
        self.assertLess(shifted["p_value"], 0.05)
        self.assertEqual(shifted["shift_axis"], "z")
        self.assertAlmostEqual(shifted["shift"]["value"], -0.6 * MM, delta=0.2 * MM)
        self.assertIn("no disturbance will cure that", shifted["advice"])

    def test_a_set_names_who_is_left_out(self):
        made = Made(13, 25, (NOTCH, start("notch-1", (12, 15), (0, 15), is_straight=True)))
        turned = made.experiment("turned")
        turned.lines = [MM * np.array([16, 24.0]) - turned.lines[0]]
        given = [made.experiment("a"), made.experiment("b"), turned, Experiment("load", peak_load=100.0)]
        self.assertEqual([crack_start_of(one, made.samples.starts) for one in given[:3]], [0, 0, 1])
        found = made.match(*given)
        self.assertEqual([(one["name"], one["by"]) for one in found["set"]["left_out"]], [("turned", "path"), ("load", "path"), ("load", "onset_load")])
        self.assertIn("Left out by path: turned, its crack has another start.", match_text.text(found))
        # A half-turn of body and loads brings it beside the others.
        made.samples.symmetries = [Symmetry((1, 0), -np.eye(2), MM * np.array([16, 24.0]))]
        self.assertEqual(observe(given, made.samples)[0].experiments, [0, 1, 2])

    def test_what_did_not_break(self):
        made = Made(14, 40)
        for sample in made.samples.samples:
            if sample.peak_load > 101:
                sample.is_unbroken, sample.peak_load = True, 101.0
        one = made.one(Experiment("run-out", peak_load=101.0, run_out=True))
        by = one["by"]["peak_load"]
        self.assertEqual((by["limit"], by["n_samples"]), (101, 40))
        n_above = sum(sample.is_unbroken for sample in made.samples.samples)
        self.assertGreater(by["p_value"], 0.3, f"{n_above} samples bore it, too")
        self.assertEqual(made.one(Experiment("stronger", peak_load=300.0))["by"]["peak_load"]["p_value"], by["p_value"], "all that is known")
        broken = made.one(Experiment("weak", peak_load=60.0))["by"]["peak_load"]
        self.assertEqual((broken["p_value"], broken["offset"]), (1 / 41, None))
        found = made.match(*(Experiment(str(i), peak_load=min(load, 101.0), run_out=load > 101)
                             for i, load in enumerate(made.random.normal(100, 4, 12))))["set"]["by"]["peak_load"]
        self.assertEqual((found["limit"], found["shift"]["value"]), (101, None))
        self.assertEqual(found["weibull"]["samples"]["n_run_out"], n_above)
        self.assertIn("count up to 101 N", match_text.text(made.match(Experiment("a", peak_load=90.0))))

    def test_p_values_of_whole_matches(self):
        p = [Made(100 + trial, 19).one(Made(900 + trial, 0).experiment("one"))["p_value"] for trial in range(40)]
        self.assertLess(np.mean(np.array(p) <= 0.05), 0.05 + 3 * np.sqrt(0.05 * 0.95 / 40))
        self.assertGreater(np.mean(p), 0.4)

    def test_held_out_samples(self):
        made = Made(15, 20)
        experiments, others = matching.hold_out(made.samples, 5)
        self.assertEqual({one.number for one in made.samples.samples} - {one.number for one in others.samples},
                         {int(one.name.split()[1]) for one in experiments})
        ended = made.sample(99, made.crack()[:10])
        self.assertTrue(matching.as_experiment(ended, made.samples).arrested)
        crossed = made.sample(99, np.vstack([made.crack(), MM * np.array([[15.9, 9.5]])]))
        self.assertFalse(matching.as_experiment(crossed, made.samples).arrested, "at the end of the body")
        other = np.array(list(matching.p_values_of(Made(16, 12).samples, made.samples).values()))
        self.assertGreater(other.mean(), 0.25)
        shifted = Made(16, 12)
        for sample in shifted.samples.samples:
            sample.arms[0][0] = Arm(sample.arms[0][0].points + (0, 2 * MM), sample.arms[0][0].time)
        self.assertLess(np.mean(list(matching.p_values_of(shifted.samples, made.samples).values())), other.mean() / 2)


class Observations(unittest.TestCase):
    def test_tips_arrive_when_the_path_passes_them(self):
        arm = Arm(np.array([[0, 0], [1, 0], [2, 0.0]]), np.array([0, 1, 3.0]))
        self.assertAlmostEqual(arrival_at(arm, np.array([1.5, 0.3])), 2)
        self.assertEqual(arrival_at(arm, np.array([0, 1.0])), 0)
        self.assertEqual(arrival_at(arm, np.array([2.5, 0])), 3, "within a slab and a half")
        self.assertTrue(np.isnan(arrival_at(arm, np.array([4, 0.0]))), "ended before")
        slow = replace(arm, time=np.array([-6.4, -6.4, 3]))
        self.assertEqual([arrival_at(slow, np.array([y, 0])) for y in (0.5, 1.5)], [0, 1.5])

    def test_places_outside_the_body_are_refused(self):
        made = Made(10, 1)
        good, bad = made.experiment("good"), made.experiment("off by a thousand")
        check_places(Path("x.toml"), [good], made.samples)
        bad.lines = [1000 * bad.lines[0]]
        with self.assertRaisesRegex(ExperimentsError, "off by a thousand.*set origin, angle and mirror"):
            check_places(Path("x.toml"), [good, bad], made.samples)

    def test_cracks_from_holes_begin_at_their_walls(self):
        """At a wall far from the hole's middle, which the middle of the body is nearer to."""
        starts = [start("hole-0", walls=wall((10, 30), (30, 66), (26, 70)), is_hole=True),
                  start("free surface", walls=wall((0, 0), (40, 0), (40, 80), (0, 80)), is_free_surface=True)]
        for points, of in (([(10, 29.5), (14, 20), (15, 4)], 0), ([(10, 29.5), (14, 20), (15, 0)], 0), ([(15, 0), (14, 20), (10, 29.5)], 0),
                           ([(39, 10), (30, 10), (20, 9)], 1)):
            self.assertEqual(crack_start_of(Experiment("a", [MM * np.array(points, float)]), starts), of, points)
        self.assertTrue(starts[0].holds(MM * np.array([[20, 50.0]]))[0])
        self.assertFalse(starts[0].holds(MM * np.array([[12, 60.0]]))[0])


class Weibull(unittest.TestCase):
    def test_run_outs_and_threshold(self):
        """Intervals cover, with a third of run-outs, and a threshold is found where there is one."""
        random, covered = np.random.default_rng(1), np.zeros(2)
        for _ in range(25):
            values = 100 * random.weibull(8, 30)
            limit = np.sort(values)[20]
            found = weibull.document(np.minimum(values, limit), values < limit)
            self.assertEqual((found["n_broken"], found["n_run_out"]), (20, 10))
            covered += [found[name]["lower"] <= true <= found[name]["upper"] for name, true in (("modulus", 8), ("scale", 100))]
        self.assertTrue((covered / 25 > 0.75).all(), covered)
        values = 50 + 20 * random.weibull(1.5, 60)
        more = weibull.document(values, np.ones(60, bool))["with_threshold"]
        self.assertLess(more["p_value"], 0.01)
        self.assertTrue(more["threshold"]["lower"] < 50 < more["threshold"]["upper"])
        # Few broke, so that the scale may be far above all that was applied.
        few = np.r_[0.52, 0.56, 0.6, 0.63, 0.65, np.full(195, 0.66)]
        found = weibull.modulus_and_scale(few, np.arange(200) < 5)
        modulus = np.geomspace(0.5, 50, 800)[:, None]

        def most(scale: float) -> float:
            return (5 * np.log(modulus / scale) + (modulus - 1) * np.log(few[:5] / scale).sum() - ((few / scale)**modulus).sum(axis=1, keepdims=True)).max()
        for end in ("lower", "upper"):
            self.assertAlmostEqual(most(found["scale"][end]), most(found["scale"]["value"]) - stats.chi2.ppf(0.95, 1) / 2, places=3)
        for few in (values[:4], np.full(9, 3.0), -values):
            self.assertIsNone(weibull.document(few, np.ones(len(few), bool)))

    def test_likelihood_is_that_of_scipy(self):
        values = 100 * np.random.default_rng(2).weibull(6, 25)
        broken = values < np.sort(values)[18]
        found = weibull.document(np.minimum(values, np.sort(values)[18]), broken)

        def likelihood(m: float, scale: float) -> float:
            of = stats.weibull_min(m, scale=scale)
            return of.logpdf(values[broken]).sum() + (~broken).sum() * of.logsf(np.sort(values)[18])

        best = likelihood(found["modulus"]["value"], found["scale"]["value"])
        for m, scale in ((1.01, 1), (0.99, 1), (1, 1.01), (1, 0.99)):
            self.assertGreater(best, likelihood(m * found["modulus"]["value"], scale * found["scale"]["value"]))


class ExperimentsFile(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def read(self, text: str, **files: str | bytes) -> list[Experiment]:
        for name, content in files.items():
            file = self.folder / name.replace("__", ".")
            file.write_bytes(content if isinstance(content, bytes) else content.encode())
        (self.folder / "e.toml").write_text(text)
        return read_experiments(self.folder / "e.toml")

    def errors(self, text: str, **files: str | bytes) -> list[str]:
        with self.assertRaises(ExperimentsError) as raised:
            self.read(text, **files)
        return [message.replace(f"{self.folder}/", "") for message in raised.exception.messages]

    PNG = picture(640, 300)

    def test_has_all_that_was_observed(self):
        first, second = self.read("""
[[experiment]]
name = "first"
path = "path.csv"
path_error = "0.1 mm"
arrested = true
origin = ["10 mm", "20 mm"]
angle = "90 degree"
mirror = "y"
onset_load = "0.2 kN"
load_error = "3 N"
tips = "tips.csv"
time_error = "1 us"
curve = "curve.csv"
[[experiment.tip]]
time = "30 us"
at = ["4 mm", "2 mm"]
[[experiment.picture]]
file = "frame.png"
time = "30 us"
scale = "0.05 mm"
origin = [12, 34.5]
[[experiment.picture]]
file = "frame.jpg"
time = "40 us"
scale = "50 um"
origin = [0, 0]
field = "light"
reversed = true
[[experiment]]
name = "second"
peak_load = "7 N"
run_out = true
""", path__csv="# a comment\ny_mm,z_mm\n1,2\n2,2\n# another\n4,2\n\n3,3\r\n5,6\n", tips__csv="time_us;y_cm;z_cm\n10;0.1;0.2\n20;0.2;0.2\n",
            curve__csv="displacement_um\tload_kN\n0\t0\n5\t0.3\n6\t0.1\n", frame__png=self.PNG,
            frame__jpg=picture(513, 256, "JPEG"))
        # (1, 2), reversed in y: (-1, 2); turned by 90 degrees: (-2, -1).
        np.testing.assert_allclose(first.lines[0][0], (8e-3, 19e-3))
        np.testing.assert_allclose(first.lines[1][1], (4e-3, 15e-3))
        self.assertEqual([len(line) for line in first.lines], [3, 2])
        self.assertAlmostEqual(first.path_error_length, 1.5e-3, msg="the mean distance of its points")
        self.assertTrue(first.arrested)
        self.assertEqual((first.onset_load, first.peak_load, first.load_error), (200, 300, 3))
        np.testing.assert_allclose(sorted(first.tip_times), (10e-6, 20e-6, 30e-6))
        np.testing.assert_allclose(first.tip_places[0], (8e-3, 16e-3))
        one, other = first.pictures
        self.assertEqual((one.width, one.height, one.light_field, one.reversed), (640, 300, False, False))
        np.testing.assert_allclose((one.corner, one.right, one.down), ((8.275e-3, 20.6e-3), (0, -0.05e-3), (0.05e-3, 0)), atol=1e-15)
        self.assertEqual((other.width, other.height, other.light_field, other.reversed), (513, 256, True, True))
        self.assertEqual((second.peak_load, second.run_out), (7, True))

    def test_initial_slopes(self):
        # 0.5 um/N of specimen and machine, 0.1 of the machine; a soft start and a bend near the peak do not count.
        text = '[[experiment]]\nname = "a"\ncurve = "c.csv"\nmachine_compliance = "0.1 um/N"\n'
        loads = np.array([0, 5, 10, 20, 30, 50, 80, 100, 40])
        rows = "".join(f"{0.5 * load + 3 + extra},{load}\n" for load, extra in zip(loads, (-2, -1, 0, 0, 0, 0, 4, 9, 30)))
        one, = self.read(text, c__csv="displacement_um,load_N\n" + rows)
        self.assertAlmostEqual(one.stiffness * 0.4e-6, 1, places=9)
        self.assertLess(one.stiffness_error, 1e-6 * one.stiffness)
        self.assertIsNone(self.read(text.replace("machine", "#machine"))[0].stiffness)
        for wrong, part in ((text.replace("0.1", "0.6"), "is stiffer than the machine"), (text.replace("curve", "#curve") + "peak_load = '3 N'\n", "is for curve")):
            self.assertIn(part, self.errors(wrong)[0])
        self.assertIn("fewer than three points", self.errors(text, c__csv="displacement_um,load_N\n0,0\n5,10\n")[0])

    def test_paths_in_pixels(self):
        one, = self.read('[[experiment]]\nname = "a"\npath = "p.csv"\nscale = "0.1 mm"\npixel_origin = [10, 50]\norigin = ["0 mm", "5 mm"]\n',
                         p__csv="y_px,z_px\n10,50\n30,40\n")
        np.testing.assert_allclose(one.lines[0], ((0, 5e-3), (2e-3, 6e-3)))
        self.assertIn("of pixels (px) give scale, too", self.errors('[[experiment]]\nname = "a"\npath = "p.csv"\n')[0])

    def test_loads_alone_are_experiments(self):
        rows = self.read('loads = "a.csv"\nload_error = "1 N"\n[[experiment]]\nname = "alumina"\nloads = "b.csv"\nload_per_strength = "0.5 mm^2"\n',
                         a__csv="peak_load_N,run_out\n120,no\n130.5,yes\n", b__csv=f"name,strength_MPa\nA\x1b[31m,300\n{'B' * 5000},310\n")
        self.assertEqual([one.name for one in rows], ["row 1", "row 2", "alumina A?[31m", f"alumina {'B' * 60}..."])
        self.assertEqual([one.run_out for one in rows], [False, True, False, False])
        np.testing.assert_allclose([one.peak_load for one in rows], (120, 130.5, 150, 155))
        arms, = self.read('[[experiment]]\nname = "a"\npath = "p.csv"\n', p__csv="arm,y_m,z_m\nmain,1,1\nupper,1,2\nmain,2,1\nupper,2,3\nmain,3,1\n")
        np.testing.assert_array_equal(arms.lines[0], ((1, 1), (2, 1), (3, 1)))

    def test_all_errors_are_reported_at_once(self):
        found = self.errors('[[experiment]]\nname = "a"\npath = "path.csv"\ntips = "tips.csv"\nonset_load = "3 mm"\ntypo = 3\n[[experiment]]\nname = "b"\n',
                            path__csv="y_mm,z_kg\n1,2\n", tips__csv="time_us,y_mm,z_mm\n1,2\nx,2,3\n")
        for message, whole in zip(found, (
                'e.toml:3: experiment[0].path: path.csv: the heading "z_kg" does not end in a unit of a length; write such as "z_mm"',
                "e.toml:4: experiment[0].tips: tips.csv: line 2: has 2 values under 3 headings",
                'e.toml:5: experiment[0].onset_load: "3 mm" does not have the dimension of a force; give a force such as "134 N"',
                "e.toml:6: experiment[0].typo: unknown key; did you mean tip?",
                "e.toml:7: experiment[1]: nothing was observed in this experiment; give path, "), strict=True):
            self.assertTrue(message.startswith(whole), message)

    def test_errors_of_csv_files(self):
        text = '[[experiment]]\nname = "a"\npath = "path.csv"\n'
        for csv, end in (("", "is empty"), ("y_mm,z_mm\n1,2\n1;3,4\n", 'line 3: "1;3" is not a number; write such as 12.5'),
                         ("y_mm,z_mm\n1,2\n1,nan\n", 'line 3: "nan" is not a number; write such as 12.5'),
                         ("y_mm\n1\n2\n", "has no column z; give a header such as y_mm,z_mm"),
                         ("y,z_mm\n1,2\n2,3\n", 'the heading "y" does not end in a unit of a length; write such as "y_mm"'),
                         ("y_mm,z_mm\n1,2\n", "has 1 row; give at least 2"),
                         ("y_mm,z_mm,y_mm\n1,2,3\n2,3,4\n", 'line 1: two columns are called "y_mm"; leave one of them out'),
                         (b"\xff\xfey\0_\0m\0m\0,\0z\0_\0m\0m\0\n\0", "line 1: not text in UTF-8, but perhaps in UTF-16; save the file as CSV in UTF-8"),
                         ("y_mm,z_mm\n1,2\n\x1b[2J,4\n", 'line 3: "?[2J" is not a number; write such as 12.5'),
                         ("y_mm,z_mm\n1,2\n2,3\n\n5,6\n", "arm 2 has a single point; give at least two of each")):
            found, = self.errors(text, path__csv=csv)
            self.assertTrue(found.endswith(end), found)
        self.assertTrue(self.errors(text.replace("path.csv", "none.csv"))[0].endswith("there is no such file"))
        self.assertTrue(self.errors(text.replace("path.csv", "."))[0].endswith("is a folder"))

    def test_errors_of_pictures(self):
        text = '[[experiment]]\nname = "a"\n[[experiment.picture]]\nfile = "a.png"\ntime = "0 s"\nscale = "1 mm"\norigin = [0, 0]\n'
        for content in (b"GIF89a", b"", self.PNG[:20], self.PNG[:16] + b"\0\0\0\0" + self.PNG[20:], b"\xff\xd8\xff\xd9", b"\xff\xd8zz"):
            self.assertIn("experiment[0].picture[0].file: a.png: cannot be read as PNG or JPEG", self.errors(text, a__png=content)[0])
        for found, part in zip(self.errors('[[experiment]]\nname = "a"\n[[experiment.picture]]\nfield = "grey"\n'),
                               ("file: the key is missing", "time: the key is missing", "scale: the key is missing", "origin: the key is missing",
                                '"grey" is not known; give "light" or "dark"'), strict=True):
            self.assertIn(part, found)

    def test_other_errors(self):
        a = '[[experiment]]\nname = "a"\n'
        for text, *parts in (("# nothing\n", "there is no experiment"), ('[[experiment]]\npeak_load = "3 N"\n', "experiment[0].name: the key is missing"),
                             ('[experiment]\npeak_load = "3 N"\n', "write [[experiment]], in double brackets"), ("[[experiment]\n", "e.toml:1: syntax error"),
                             (a + "peak_load = 3 N\n", "e.toml:3: syntax error"), (2 * (a + 'peak_load = "3 N"\n'), 'two experiments are named "a"'),
                             (a + 'peak_load = "3 N"\npath_error = "1 mm"\ntime_error = "1 s"\n', "path_error: is for path", "time_error: is for tip or tips"),
                             (a + '[[experiment.tip]]\ntime = "1 us"\n', "experiment[0].tip[0].at: the key is missing; give two lengths"),
                             (a + 'peak_load = "3 N"\narrested = 1\n', "give true or false", "arrested: is for path"),
                             (a + 'onset_load = "-3 N"\n', "is out of range; give a force from 0 to 1e+12 N"), (a + "peak_load = 3\n", "is a plain number without a unit"),
                             (a + '[[experiment.tip]]\ntime = "-1 us"\nat = ["1 mm", "2 mm"]\n', "tip[0].time: "),
                             ('load_error = "3 N"\n' + a + 'peak_load = "3 N"\n', "load_error: is for loads"), (a + "run_out = true\nonset_load = \"3 N\"\n", "is for peak_load")):
            found = self.errors(text)
            for message, part in zip(found, parts, strict=True):
                self.assertIn(part, message)
        for csv, part in (("load_N\n3\n", "give a header such as peak_load_N"), ("strength_MPa\n3\n", "give load_per_strength too"),
                          ("strength_MPa,peak_load_N\n3,3\n", "leave one of them out"), ("peak_load_N\n", "has no rows"),
                          ("peak_load_N\n3\n-3\n", "line 3: negative load"), ("peak_load_N,run_out\n3,maybe\n", 'line 2: run_out is neither "yes" nor "no"')):
            self.assertIn(part, self.errors('loads = "l.csv"\n', l__csv=csv)[0])
        for name, csv, part in (("tips", "time_us,y_mm,z_mm\n-1,2,3\n", "line 2: the time is below 0"), ("curve", "displacement_mm,load_N\n0,-1\n1,-3\n", "negative loads only")):
            self.assertIn(part, self.errors(a + f'{name} = "x.csv"\n', x__csv=csv)[0])
        with self.assertRaisesRegex(ExperimentsError, "there is no such file"):
            read_experiments(self.folder / "none.toml")

    def test_the_page_names_every_key(self):
        page = (ROOT / "jobs/experiments.md").read_text()
        for keys in TABLES.values():
            for key in keys:
                self.assertIn(f"`{key.name}`", page)


if __name__ == "__main__":
    unittest.main()
