#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Comparison of ensembles: intervals and p-values by hand, against published examples, and their promises."""
from __future__ import annotations

import sys
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools")]

from crackle import inference  # noqa: E402
from crackle.comparison import Rows, _Comparison  # noqa: E402
from crackle.inference import (Censored, Design, TwoSamples, Units, difference_of_censored_medians, difference_of_means, difference_of_medians, difference_of_shares,  # noqa: E402
                               energy_distance, gehan_scores, joint_test, permutation_probability)

NONE = np.nan


def pairs(first: list, second: list, groups: list | None = None) -> TwoSamples:
    group = None if groups is None else np.array(groups)
    return TwoSamples(np.array(first), np.array(second), True, group, group)


def two(first: list, second: list, *groups: list) -> TwoSamples:
    return TwoSamples(np.array(first, float), np.array(second, float), False, *map(np.array, groups))


def least(samples: TwoSamples) -> float:
    return Units(samples).design.least


def ones(n_ones: int, n: int) -> list:
    return [1.0] * n_ones + [0.0] * (n - n_ones)


def holds(found: inference.Difference, truth: float) -> bool:
    return found.lower <= truth <= found.upper


class ByHand(unittest.TestCase):
    def test_permutations_of_a_few_values(self):
        # Among the 20 ways to choose three of six values, these two have the largest difference.
        self.assertEqual(permutation_probability(two([1, 2, 3], [4, 5, 6])), 0.1)
        self.assertEqual(permutation_probability(two([4, 5, 6], [1, 2, 3])), 0.1, "two-sided")
        # For pairs with differences of one sign, 2 of 2^5 have the largest mean.
        self.assertEqual(permutation_probability(pairs([1, 2, 3, 4, 5], [2, 4, 6, 5, 8])), 2 / 32)
        self.assertEqual(permutation_probability(two([1, 1], [1, 1])), 1)
        self.assertEqual(permutation_probability(two([], [1])), 1)
        # One of 126 ways: as Fisher's exact test of 4 of 4 against 0 of 5.
        self.assertEqual(permutation_probability(two(ones(4, 4), ones(0, 5))), 1 / 126)

    def test_means(self):
        # By scipy.stats.t with Welch's degrees of freedom.
        welch = difference_of_means(two([1, 3, 2.5, 7.1], [4, 8, 3.3]), 0.95)
        np.testing.assert_allclose(welch[:3], [1.7, -3.5012378177939056, 6.901237817793907], atol=1e-9)
        # For pairs with differences 1, 2 and 6: Student's t of 2 degrees of freedom.
        paired = difference_of_means(pairs([0, 0, 0], [1, 2, 6]), 0.95)
        np.testing.assert_allclose([paired.value, (paired.upper - paired.lower) / 2], [3, 4.302652729749464 * np.sqrt(7 / 3)], atol=1e-10)
        self.assertTrue(np.isnan(difference_of_means(two([1], [2, 3]), 0.95).lower), "one value has no scatter")

    def test_shares_as_in_newcombes_tables(self):
        # Stat. Med. 17 (1998) 873, table II, method 10: 56/70 - 48/80 is 0.2 (0.0524 to 0.3339); 10/10 - 0/20 from 0.6791 to 1.
        np.testing.assert_allclose(difference_of_shares(two(ones(48, 80), ones(56, 70)), 0.95)[:3], [0.2, 0.0524, 0.3339], atol=5e-5)
        np.testing.assert_allclose(difference_of_shares(two(ones(0, 20), ones(10, 10)), 0.95)[1:3], [0.6791, 1], atol=5e-5)
        # For pairs, ibid. 2635: 1 - 1 in all of them has both ends at the ends of Wilson's intervals.
        paired = difference_of_shares(pairs(ones(0, 10), ones(10, 10)), 0.95)
        self.assertEqual((paired.value, paired.upper), (1, 1))
        self.assertLess(paired.lower, 0.7)

    def test_medians_have_exact_intervals_or_none(self):
        # From the least to the largest of 6 differences: 1 - 2 / 2^6 = 96.9 %.
        self.assertEqual(difference_of_medians(pairs([0] * 6, [6, 5, 9, 1, 2, 3]), 0.95)[:3], (4, 1, 9))
        self.assertTrue(np.isnan(difference_of_medians(pairs([0] * 5, [1, 2, 3, 4, 5]), 0.95).lower))
        self.assertTrue(np.isnan(difference_of_medians(two(range(5), range(1, 8)), 0.95).lower))

    def test_equal_values_have_no_interval_and_ties_one(self):
        shifted = pairs([1, 2, 4, 5, 6, 7], [2, 3, 5, 6, 7, 8])
        for found in (difference_of_means(shifted, 0.95), difference_of_medians(shifted, 0.95)):
            self.assertEqual((found.value, found.has_no_width), (1, True))
            self.assertTrue(np.isnan([found.lower, found.upper]).all())
        # The means of all draws and the middle order statistics are equal, the values are not.
        draws, zero, ties = np.repeat(np.arange(6), 2).tolist(), [0.0] * 12, [1, *[2] * 10, 3]
        for found in (difference_of_means(pairs(zero, [1, 3] * 6, draws), 0.95), difference_of_medians(pairs(zero, ties), 0.95), difference_of_medians(two(zero, ties), 0.95)):
            self.assertEqual(found[1:], (2, 2, False))
        self.assertTrue(difference_of_medians(two(zero, [2.0] * 12), 0.95).has_no_width)

    def test_values_of_which_some_are_bounds(self):
        # Kaplan and Meier with bounds at 2 and 5: 4/5 after 1, then 3 at risk: 2/3 and 1/3 of that; the median is 4.
        values = Censored(np.array([1.0, 2, 3, 4, 5]), np.array([False, True, False, False, True]), np.arange(5))
        self.assertEqual(values.median(), (4.0, False))
        self.assertEqual(Censored(np.array([1.0, 2, 3]), np.array([False, True, True]), np.arange(3)).median(), (2.0, True))
        # 1 lies below all of 2, > 3, 4 and > 2; > 3 lies above 1 and 2 for sure; 4 above 1 and 2, and > 3 and > 2 may be above or not.
        first, second = gehan_scores(Censored(np.array([1.0, 3]), np.array([False, True]), np.arange(2)),
                                     Censored(np.array([2.0, 4, 2]), np.array([False, False, True]), np.arange(3)))
        np.testing.assert_array_equal(first, [-4, 2])
        np.testing.assert_array_equal(second, [-2, 2, 2])
        strengths = 400 + 40 * np.cos(5.0 * np.arange(40))
        broken, loaded = (Censored(np.minimum(strengths, most), strengths >= most, np.arange(40)) for most in (900, 410))
        same = difference_of_censored_medians(broken, loaded, 0.95)
        self.assertAlmostEqual(same.value, 0)
        self.assertTrue(holds(same, 0))
        weaker = difference_of_censored_medians(loaded, Censored(0.93 * strengths, np.zeros(40, bool), np.arange(40)), 0.95)
        self.assertAlmostEqual(weaker.value, -0.07 * loaded.median()[0], delta=1)
        self.assertGreater(permutation_probability(TwoSamples(*gehan_scores(broken, loaded))), 0.3)

    def test_bounds_mean_nothing_where_no_broken_sample_has_the_result(self):
        """The onset after a start from rest."""
        def rows(n_unbroken: int, onset: float | None = None, held: int = 0) -> Rows:
            n = 12
            samples = {"status": [1] * n, "outcome": [0] * n_unbroken + [2] * (n - n_unbroken), "held": [0] * (n - held) + [1] * held,
                       "peak_load": [500.0 + k for k in range(n)], "onset_force": [None] * n_unbroken + [onset] * (n - n_unbroken), "leading_notch": [-1] * n}
            infos = [{"name": name, "label": name, "about": "body", "reduction": "quantiles", "of_unbroken": "bound", "tells_the_end": True}
                     for name in ("onset_force", "peak_load")]
            return Rows("made up", {"sampling": {"replicates": 1, "body_settings": [], "note": "", "base": "own"}, "results": infos, "samples": samples,
                                    "n_samples": n, "n_done": n, "statistics": {"reference_notch": []},
                                    "crack_path": {"section_name": [], "section_coordinate": [], "leader": []}})

        def compared(*each: Rows) -> dict:
            return {one.info["name"]: one.bounds for one in _Comparison(*each, 0.95).results}
        self.assertEqual(compared(rows(5), rows(5)), {"peak_load": (5, 5)})
        self.assertEqual(compared(rows(5), rows(12)), {"peak_load": (5, 12)})
        self.assertEqual(compared(rows(5, 490.0), rows(4, 480.0, held=2)), {"onset_force": (5, 6), "peak_load": (5, 6)})
        self.assertEqual(compared(rows(12), rows(12)), {"onset_force": (12, 12), "peak_load": (12, 12)})

    def test_energy_distance(self):
        # 2 * 3 - 1 / 2 - 1 / 2 with paths at distances 1 within the groups and 3 between them.
        value, p = energy_distance(two([[0], [1]], [[3], [4]]))
        self.assertEqual((value, p), (2 * 3 - 0.5 - 0.5, 2 / 6))
        self.assertAlmostEqual(energy_distance(two([[0, 1], [2, 5]], [[0, 1], [2, 5]]))[0], 0)
        # The section that one path does not reach is excluded from all its pairs.
        self.assertEqual(energy_distance(two([[0, NONE], [1, NONE]], [[3, 7], [4, 8]]))[0], 5)
        self.assertTrue(np.isnan(energy_distance(two([[0]], [[3], [4]]))[0]))
        # Differences 1 and 2: |D + D'| is 2, 3, 3 and 4, |D - D'| 0, 1, 1 and 0. Of four sign combinations two are as far apart.
        value, p = energy_distance(pairs([[0], [50]], [[1], [52]]))
        self.assertEqual((value, p), (2 * (12 - 2) / 4, 0.5))

    def test_the_least_possible_probability(self):
        self.assertEqual(least(two([1, 2, 3], [1, 2, 3])), 0.1)
        self.assertEqual(least(two([1, 2], [1, 2, 3])), 0.1)
        self.assertEqual(least(pairs([1, 2, 3, 4], [1, 2, 3, 4])), 0.125)
        self.assertEqual(Design(50, 50, False).least, 1e-4)
        self.assertEqual(least(pairs([1, 2, 3, 4], [1, 2, 3, 4], [0, 0, 1, 1])), 0.5, "two draws")


class Together(unittest.TestCase):
    def test_a_single_unit_has_the_variance_of_the_others(self):
        # Only these units have a value. Other labels that leave a single one of them on a side do not count as larger differences: {0} and 1 to 6 are
        # 3.5 / sqrt(3.5 + 3.5 / 6) apart, {0, 1, 2} and 3 to 6 more.
        some = two([0, 1, 2], [3, 4, 5, 6], [0, 1, 2], [0, 1, 2, 3])
        self.assertAlmostEqual(joint_test([some, two([1] * 6, [1] * 6)]).adjusted[0], 60 / 924)

    def test_the_observed_labels_do_not_decide_which_looks_count(self):
        # Ten units, of which other labels put up to five on the first side.
        uneven = two([9], range(9), [0], range(9))
        self.assertGreater(least(uneven), 0.05)
        self.assertEqual(joint_test([uneven, two([1] * 9, [1] * 9)]).n_looks, 1)

    def test_a_shift_of_eight_pairs_is_significant_beside_many_looks(self):
        # As the first, but for a linear function: counted once. The others do not differ. One has too few values.
        i = np.arange(8.0)
        shifted = pairs(i, i + 20 + np.sin(i))
        scaled = pairs(3 * shifted.first, 3 * shifted.second)
        others = [pairs(0 * i, np.cos(1 + 2.3 * i * (k + 1))) for k in range(12)]
        looks = [shifted, scaled, *others, pairs([1, 2, 3], [4, 7, 9])]
        found = joint_test(looks)
        self.assertEqual((found.adjusted[0], found.adjusted[1], found.least), (2 / 256,) * 3)
        self.assertEqual((found.same_as[1], found.same_as[2], found.n_looks, found.n_too_small), (0, -1, 13, 1))
        self.assertTrue(np.isnan(found.adjusted[-1]))
        for p, look in zip(found.adjusted[2:14], others):
            self.assertGreaterEqual(p, permutation_probability(look))


class Promises(unittest.TestCase):
    """In fewer and smaller trials than would measure the sizes: what they say must not be far off."""

    def setUp(self):
        self.random = np.random.Generator(np.random.Philox(1))

    def test_intervals_hold_and_p_is_small_as_often_as_they_say(self):
        n, found = 150, np.zeros(6)
        for _ in range(n):
            a, b, c, d = (self.random.standard_normal(k) for k in (7, 7, 8, 8))
            samples, shifted = two(a, 2 * b + 1), pairs(5 * c, 5 * c + d)
            shares = two(self.random.random(20) < 0.3, self.random.random(30) < 0.6)
            found += (holds(difference_of_means(samples, 0.95), 1), holds(difference_of_medians(samples, 0.95), 1), holds(difference_of_means(shifted, 0.95), 0),
                      holds(difference_of_shares(shares, 0.95), 0.3), permutation_probability(two(a, b)) <= 0.05, permutation_probability(shifted) <= 0.05)
        print("of 95 % intervals hold: means {:.0%}, medians {:.0%}, of pairs {:.0%}, shares {:.0%}; p below 0.05 by chance {:.1%}, of pairs {:.1%}".format(*found / n))
        for share in found[[0, 2, 3]] / n:
            self.assertLess(abs(share - 0.95), 0.054)  # three standard errors
        self.assertGreater(found[1] / n, 0.92)
        for share in found[4:] / n:
            self.assertLess(abs(share - 0.05), 0.054)

    def test_none_of_many_dependent_looks_is_significant_by_chance_too_often(self):
        n, any_pairs, any_independent = 100, 0, 0
        for _ in range(n):
            common = self.random.standard_normal((2, 8))
            values = [common + (0.1 if k < 3 else 2) * self.random.standard_normal((2, 8)) for k in range(6)]
            paths = pairs(np.stack([values[0][0], self.random.standard_normal(8)], axis=1), np.stack([values[0][1], self.random.standard_normal(8)], axis=1))
            any_pairs += min(joint_test([pairs(*one) for one in values], [paths]).adjusted) <= 0.05
            any_independent += np.nanmin(joint_test([two(one[0][:5], one[1][:5]) for one in values]).adjusted) <= 0.05
        print(f"any of 7 dependent looks below 0.05 by chance: {any_pairs / n:.0%} of pairs, {any_independent / n:.0%} of independent")
        self.assertLess(max(any_pairs, any_independent) / n, 0.05 + 3 * 0.022)

    def test_replicates_are_taken_by_whole_draws(self):
        # 8 meshes for each of 7 draws, correlated by 0.8 within draws.
        n, groups, found = 60, np.repeat(np.arange(7), 8), np.zeros(5)
        for _ in range(n):
            a, b = (np.sqrt(0.8) * self.random.standard_normal(7)[groups] + np.sqrt(0.2) * self.random.standard_normal(56) for _ in range(2))
            samples = two(a, b, groups, groups)
            shares = two(a > 0, b > 0, groups, groups)
            welch = difference_of_means(two(a, b), 0.95)
            found += (holds(difference_of_means(samples, 0.95), 0), holds(difference_of_medians(samples, 0.95), 0), holds(difference_of_shares(shares, 0.95), 0),
                      permutation_probability(samples) <= 0.05, not holds(welch, 0))
        print("8 replicates: of 95 % intervals hold means {:.0%}, medians {:.0%}, shares {:.0%}; p below 0.05 by chance {:.0%}, by samples {:.0%}".format(*found / n))
        self.assertGreater(found[:3].min() / n, 0.87)
        self.assertLess(found[3] / n, 0.135)
        self.assertGreater(found[4] / n, 0.2)

    def test_energy_distance_sees_what_means_do_not(self):
        same, wider = (sum(energy_distance(two(self.random.standard_normal((12, 3)), deviation * self.random.standard_normal((12, 3))))[1] <= 0.05 for _ in range(15))
                       for deviation in (1, 3))
        print(f"paths told apart: {same} of 15 from one distribution, {wider} of 15 of three times the scatter")
        self.assertLessEqual(same, 4)
        self.assertGreaterEqual(wider, 13)


if __name__ == "__main__":
    unittest.main()
