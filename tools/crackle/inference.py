# SPDX-License-Identifier: GPL-3.0-or-later
"""Intervals and tests of two lists of values, which may come in groups: the meshes of one draw of the random inputs.

Values of a group are alike; groups are independent.
"""
from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Callable, NamedTuple, Sequence

import numpy as np
from scipy import stats

SIGNIFICANT = 0.05  # p-values up to this count as significant
N_RANDOM, MOST_EXACT = 9999, 20_000  # labellings: so many random ones if there are more than so many
ROUNDING = 1e-9  # statistics that differ by less, relatively, are equal
CHUNK = 2000  # labellings at a time


class Difference(NamedTuple):
    value: float = np.nan
    lower: float = np.nan  # NaN if there are too few values, or equal ones only
    upper: float = np.nan
    has_no_width: bool = False  # the values are equal, so that they give no interval


class Interval(NamedTuple):
    lower: float = np.nan
    upper: float = np.nan


@dataclass
class TwoSamples:
    """Two lists of values, or of paths (a row for each); of pairs, value i of one belongs to value i of the other, and the groups are
    those of the first."""

    first: np.ndarray
    second: np.ndarray
    are_paired: bool = False
    first_group: np.ndarray = field(default=None)  # type: ignore[assignment]
    second_group: np.ndarray = field(default=None)  # type: ignore[assignment]
    _values: dict = field(default_factory=dict, repr=False)  # of statistics under all labellings, by units

    def __post_init__(self) -> None:
        self.first, self.second = np.asarray(self.first, float), np.asarray(self.second, float)
        if self.first_group is None:
            self.first_group = np.arange(len(self.first))
        if self.second_group is None:
            self.second_group = np.arange(len(self.second))

    @property
    def differences(self) -> np.ndarray:
        return self.second - self.first

    @property
    def is_empty(self) -> bool:
        return not len(self.first) or not len(self.second)


# Values in groups


def _sums(values: np.ndarray, group: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of each group: number, sum, and the group itself, in ascending order."""
    units, of_value = np.unique(group, return_inverse=True)
    return np.bincount(of_value).astype(float), np.bincount(of_value, values, minlength=units.size), units


def _mean(values: np.ndarray, group: np.ndarray) -> tuple[float, float, float]:
    """Mean, squared standard error by the residuals' sums in groups (Cochran 1977, Sampling Techniques, section 9A) and its degrees of
    freedom."""
    if not len(values):
        return np.nan, np.nan, np.nan
    mean = float(np.mean(values))
    n, total, units = _sums(values - mean, group)
    if units.size < 2:
        return mean, np.nan, 0.0
    return mean, float(np.sum(total**2)) * units.size / (units.size - 1) / len(values)**2, units.size - 1.0


def _independent(values: np.ndarray, group: np.ndarray) -> float:
    """Number of independent values that know a share as well as these: Kish's design effect, from a one-way analysis of variance."""
    n, total, units = _sums(values, group)
    if units.size == len(values):
        return float(len(values))
    alike = 1.0
    if units.size >= 2:
        within = (np.sum(values**2) - np.sum(total**2 / n)) / (len(values) - units.size)
        between = np.sum(n * (total / n - np.mean(values))**2) / (units.size - 1)
        between = max(0.0, (between - within) / ((len(values) - np.sum(n**2) / len(values)) / (units.size - 1)))
        alike = between / (within + between) if within + between > 0 else 1.0
    return max(1.0, len(values) / (1 + (len(values) / units.size - 1) * alike))


def wilson(share: float, n: float, confidence: float) -> Interval:
    z = stats.norm.ppf((1 + confidence) / 2)
    scale = 1 + z * z / n
    centre, reach = (share + z * z / (2 * n)) / scale, z * math.sqrt(share * (1 - share) / n + z * z / (4 * n * n)) / scale
    return Interval(0.0 if share == 0 else max(0.0, centre - reach), 1.0 if share == 1 else min(1.0, centre + reach))


def share_interval(values: np.ndarray, group: np.ndarray, confidence: float) -> Interval:
    """Wilson's, of values that are 0 or 1, for as many independent ones."""
    return wilson(float(np.mean(values)), int(_independent(values, group)), confidence)


def median_interval(values: np.ndarray, group: np.ndarray, confidence: float) -> Interval:
    """Between order statistics, exact by the binomial distribution (Conover 1999, Practical Nonparametric Statistics, section 3.2); for groups
    Woodruff's (1952, J. Am. Stat. Assoc. 47, 635). NaN for fewer groups than can have one: 6 at 95 %."""
    n, n_groups = len(values), np.unique(group).size
    if n_groups < math.ceil(1 - math.log2(1 - confidence)):
        return Interval()
    order = np.sort(values)
    if n_groups == n:
        rank = int(np.sum(2 * stats.binom.cdf(np.arange(n // 2), n, 0.5) <= 1 - confidence))
    else:
        below = np.where(values < np.median(values), 1.0, np.where(values == np.median(values), 0.5, 0.0))
        t = stats.t.ppf((1 + confidence) / 2, n_groups - 1)
        rank = int(max(1.0, math.floor(n * (0.5 - t * math.sqrt(_mean(below, group)[1])))))
    return Interval(order[rank - 1], order[n - rank])


# Differences, second minus first


def difference_of_means(samples: TwoSamples, confidence: float) -> Difference:
    """With Welch's interval or, of pairs, Student's of the differences."""
    if samples.are_paired:
        mean, square, degrees = _mean(samples.differences, samples.first_group)
    else:
        (a, a_square, a_degrees), (b, b_square, b_degrees) = (_mean(samples.first, samples.first_group), _mean(samples.second, samples.second_group))
        mean, square, degrees = b - a, a_square + b_square, a_degrees + b_degrees
        if square > 0:
            degrees = square**2 / (a_square**2 / a_degrees + b_square**2 / b_degrees)
    if np.isnan(square):
        return Difference(mean)
    reach = stats.t.ppf((1 + confidence) / 2, degrees) * math.sqrt(square)
    return _unless_equal(samples, Difference(mean, mean - reach, mean + reach))


def difference_of_medians(samples: TwoSamples, confidence: float) -> Difference:
    """Or, of pairs, the median of the differences; combined by Zou and Donner (2008, Stat. Med. 27, 1693) for two lists."""
    if samples.are_paired:
        found = median_interval(samples.differences, samples.first_group, confidence)
        return _unless_equal(samples, Difference(_median(samples.differences), *found))
    parts = [(_median(v), median_interval(v, g, confidence)) for v, g in ((samples.first, samples.first_group), (samples.second, samples.second_group))]
    return _unless_equal(samples, _combined(*parts[0], *parts[1]))


def difference_of_shares(samples: TwoSamples, confidence: float) -> Difference:
    """Of values that are 0 or 1: Newcombe's intervals from Wilson's (1998, Stat. Med. 17, 873 and, of pairs, 2635, method 10)."""
    if samples.is_empty:
        return Difference()
    correlation = 0.0
    if samples.are_paired:
        one, other = samples.first == 1, samples.second == 1
        both, only_first, only_second, none = (float(np.sum(k)) for k in (one & other, one & ~other, ~one & other, ~one & ~other))
        margins = (both + only_first) * (only_second + none) * (both + only_second) * (only_first + none)
        excess = both * none - only_first * only_second
        if excess > 0:  # Newcombe's continuity correction
            excess = max(0.0, excess - len(one) / 2)
        correlation = excess / math.sqrt(margins) if margins > 0 else 0.0
    return _combined(float(np.mean(samples.first)), share_interval(samples.first, samples.first_group, confidence),
                     float(np.mean(samples.second)), share_interval(samples.second, samples.second_group, confidence), correlation)


def _median(values: np.ndarray) -> float:
    return float(np.median(values)) if len(values) else np.nan


def _combined(first: float, of_first: Interval, second: float, of_second: Interval, correlation: float = 0.0) -> Difference:
    def reach(of_one: float, of_other: float) -> float:
        if math.isinf(of_one) or math.isinf(of_other):
            return math.inf
        return math.sqrt(max(0.0, of_one**2 - 2 * correlation * of_one * of_other + of_other**2))
    value = second - first
    if math.isnan(of_first.lower) or math.isnan(of_second.lower):
        return Difference(value)
    return Difference(value, value - reach(second - of_second.lower, of_first.upper - first), value + reach(of_second.upper - second, first - of_first.lower))


def _unless_equal(samples: TwoSamples, found: Difference) -> Difference:
    lists = (samples.differences,) if samples.are_paired else (samples.first, samples.second)
    if np.isnan(found.lower) or any(np.ptp(values) > 0 for values in lists):
        return found
    return Difference(found.value, has_no_width=True)


# Values of which some are lower bounds


@dataclass
class Censored:
    """Values, those with `is_bound` known to lie above it."""

    value: np.ndarray
    is_bound: np.ndarray
    group: np.ndarray

    @property
    def is_mixed(self) -> bool:
        """A value is greater than a bound, so that the order is not known."""
        return bool(np.max(self.value[~self.is_bound], initial=-np.inf) > np.min(self.value[self.is_bound], initial=np.inf))

    @cached_property
    def steps(self) -> list[tuple[float, int, int]]:
        """Of Kaplan and Meier's estimate: value, number, number at risk."""
        return [(value, int(np.sum(self.value[~self.is_bound] == value)), int(np.sum(self.value >= value))) for value in np.unique(self.value[~self.is_bound])]

    @property
    def shares_below(self) -> np.ndarray:
        """By Kaplan and Meier, for each known value in ascending order: the share below it, and that with its own; equal values have steps of their own."""
        left, order = 1.0, np.lexsort((self.is_bound, self.value))  # what bore a load lies above those that broke at it
        found = []
        for k, is_bound in enumerate(self.is_bound[order]):
            before = left
            if not is_bound:
                left *= 1 - 1 / (len(order) - k)
                found.append((1 - before, 1 - left))
        return np.array(found).reshape(-1, 2).T

    def median(self) -> tuple[float, bool]:
        """And whether it is a bound."""
        plain = _median(self.value)
        if not self.is_bound.any():
            return plain, False
        if not self.is_mixed:
            return plain, math.ceil((len(self.value) - 1) / 2) >= np.sum(~self.is_bound)
        left = 1.0
        for value, n, at_risk in self.steps:
            left *= 1 - n / at_risk
            if left <= 0.5 + 1e-12:
                return value, False
        return plain, True

    def median_interval(self, confidence: float) -> Interval:
        """Infinite where an end is not known."""
        ends = median_interval(self.value, self.group, confidence)
        if not self.is_bound.any() or np.isnan(ends.lower):
            return ends
        if not self.is_mixed:
            least = np.min(self.value[self.is_bound])
            return Interval(ends.lower, np.inf if ends.upper >= least else ends.upper)
        found = [np.nan, np.inf]
        is_open = [True, True]
        for k, (value, _, _) in enumerate(self.steps):
            for end, left in enumerate(self._survival(k + 1, confidence)):
                if is_open[end] and left <= 0.5:
                    found[end], is_open[end] = value, False
        return Interval(found[0] if not is_open[0] else ends.lower, found[1])

    def _survival(self, n_steps: int, confidence: float) -> Interval:
        """Of the share above the first steps: Wilson's for the effective number by Greenwood's variance, of groups by residuals."""
        steps = self.steps[:n_steps]
        share = float(np.prod([1 - n / at_risk for _, n, at_risk in steps]))
        n_effective = max(1.0, float(len(self.value)))
        if 0 < share < 1:
            if np.unique(self.group).size == len(self.group):
                variance = sum(n / (at_risk * (at_risk - n)) for _, n, at_risk in steps)
            else:
                parts = sum(np.where(self.value >= value, ((~self.is_bound & (self.value == value)) - n / at_risk) / (at_risk - n), 0.0)
                            for value, n, at_risk in steps)
                _, total, units = _sums(parts, self.group)
                variance = float(np.sum(total**2)) * units.size / (units.size - 1)
            n_effective = (1 - share) / share / variance
        found = wilson(share, n_effective, confidence)
        return found


def difference_of_censored_medians(first: Censored, second: Censored, confidence: float) -> Difference:
    """NaN if a median is a bound; ends are infinite where those of a median are not known."""
    (one, one_is_bound), (other, other_is_bound) = first.median(), second.median()
    if one_is_bound or other_is_bound:
        return Difference()
    return _combined(one, first.median_interval(confidence), other, second.median_interval(confidence))


def gehan_scores(first: Censored, second: Censored) -> tuple[np.ndarray, np.ndarray]:
    """Of each value: how many of all it lies above, less how many lie above it, as far as that is known."""
    known = np.sort(np.concatenate([one.value[~one.is_bound] for one in (first, second)]))
    bounds = np.sort(np.concatenate([one.value[one.is_bound] for one in (first, second)]))

    def scores(values: Censored) -> np.ndarray:
        up_to, below = (np.searchsorted(known, values.value, side) for side in ("right", "left"))
        above = known.size - up_to + bounds.size - np.searchsorted(bounds, values.value, "left")
        return np.where(values.is_bound, up_to, below - above).astype(float)
    return scores(first), scores(second)


# Tests by permutation of the labels "first" and "second"


class Design(NamedTuple):
    """Units that are exchangeable: values, or whole groups. Of pairs, unit i has both labels, and label 1 swaps them."""

    n_first: int
    n_second: int
    are_paired: bool

    @property
    def n_labellings(self) -> float:
        return math.ldexp(1, min(self.n_first, 1000)) if self.are_paired else float(math.comb(self.n_first + self.n_second, self.n_second))

    @property
    def least(self) -> float:
        """The smallest p-value that a two-sided test can have: a mirror image has the same statistic."""
        if self.n_labellings > MOST_EXACT:
            return 1 / (N_RANDOM + 1)
        return min(1.0, (2 if self.are_paired or self.n_first == self.n_second else 1) / self.n_labellings)


@lru_cache(maxsize=8)
def labels_of(design: Design) -> tuple[np.ndarray, bool]:
    """Labellings x units of 0 and 1, the observed one first, and whether they are all."""
    n = design.n_first if design.are_paired else design.n_first + design.n_second
    observed = np.zeros(n, np.uint8)
    if not design.are_paired:
        observed[design.n_first:] = 1
    if design.n_labellings <= MOST_EXACT:
        if design.are_paired:
            return (np.arange(2**n)[:, None] >> np.arange(n) & 1).astype(np.uint8), True
        labels = np.ones((int(design.n_labellings), n), np.uint8)
        for row, first in enumerate(itertools.combinations(range(n), design.n_first)):
            labels[row, list(first)] = 0
        return labels, True
    random = np.random.Generator(np.random.Philox(key=0))
    drawn = (random.integers(0, 2, (N_RANDOM, n), np.uint8) if design.are_paired
             else random.permuted(np.tile(observed, (N_RANDOM, 1)), axis=1))
    return np.vstack([observed, drawn]), False


class Units:
    """Numbers of the units of a test: the groups of the values, those of the second list after the first's."""

    def __init__(self, *tests: TwoSamples) -> None:
        self.are_paired = any(one.are_paired for one in tests)
        self.first = np.unique(np.concatenate([one.first_group for one in tests])) if tests else np.array([])
        self.second = np.unique(np.concatenate([one.second_group for one in tests])) if tests and not self.are_paired else np.array([])

    @property
    def design(self) -> Design:
        return Design(self.first.size, self.second.size, self.are_paired)

    def of(self, samples: TwoSamples) -> np.ndarray:
        """Of the values of both lists, or of the pairs."""
        first = np.searchsorted(self.first, samples.first_group)
        return first if self.are_paired else np.concatenate([first, self.first.size + np.searchsorted(self.second, samples.second_group)])


Statistic = Callable[[np.ndarray], np.ndarray]  # of labellings x units


def mean_statistic(samples: TwoSamples, units: Units) -> Statistic:
    """The studentized difference of the means: Welch's or, of pairs, Student's of the differences."""
    values = samples.differences if samples.are_paired else np.concatenate([samples.first, samples.second])
    centred = values if samples.are_paired else values - np.mean(values)
    n, total, unit = _sums(centred, units.of(samples))
    scale = float(np.sum(total**2))

    def of_pairs(labels: np.ndarray) -> np.ndarray:
        sums = np.where(labels[:, unit], -total, total)
        mean = sums.sum(axis=1) / n.sum()
        square = np.sum((sums - n * mean[:, None])**2, axis=1)
        return _studentized(mean, square * unit.size / (max(1, unit.size - 1) * n.sum()**2) if unit.size > 1 else 0 * mean, scale / n.sum()**2)

    moments = np.stack([np.ones(unit.size), n, total, total**2, n * total, n**2], axis=1)

    def of_lists(labels: np.ndarray) -> np.ndarray:
        second = labels[:, unit] @ moments
        sides = []
        with np.errstate(divide="ignore", invalid="ignore"):
            for count, size, sums, squares, products, sizes in (moments.sum(axis=0)[:, None] - second.T, second.T):
                mean = np.where(size > 0, sums / size, 0)
                square = squares - 2 * mean * products + mean**2 * sizes
                square = np.where(square < 1e-12 * scale, 0, square)
                sides.append((count, size, mean, np.where(count > 1, square * count / ((count - 1) * size**2), 0)))
        (n_a, size_a, mean_a, own_a), (n_b, size_b, mean_b, own_b) = sides
        # A single unit has no variance; that of the other list's units is used instead.
        error = np.where(n_a == 1, n_b * own_b, own_a) + np.where(n_b == 1, n_a * own_a, own_b)
        return np.where((size_a == 0) | (size_b == 0), 0.0, _studentized(mean_b - mean_a, error, scale / n.sum()**2))
    return of_pairs if samples.are_paired else of_lists


def _studentized(difference: np.ndarray, square: np.ndarray, scale: float) -> np.ndarray:
    """0 or infinity without scatter; what is left by rounding counts as none."""
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.abs(difference) / np.sqrt(np.where(square < 1e-13 * scale, 0, square))
    return np.where(difference**2 <= 1e-24 * scale, 0.0, found)


def energy_statistic(paths: TwoSamples, units: Units) -> Statistic | None:
    """The energy distance of two groups of paths (Székely and Rizzo 2004), 2 E|X - Y| - E|X - X'| - E|Y - Y'|: the distance of two paths is
    the root mean square over the sections that both reach. Of pairs, between the differences and their mirror images. None where no
    two paths have a section in common."""
    unit = units.of(paths)
    rows = paths.differences if paths.are_paired else np.concatenate([paths.first, paths.second])
    apart = _distances(rows, -1)
    if paths.are_paired:
        terms = _distances(rows, 1) - apart
    else:
        terms = apart
        np.fill_diagonal(terms, np.nan)
    is_known = ~np.isnan(terms)
    if not is_known.any():
        return None
    terms, known = np.nan_to_num(terms), is_known.astype(float)

    def of_pairs(labels: np.ndarray) -> np.ndarray:
        sign = 1.0 - 2.0 * labels[:, unit]
        return 2 * np.sum((sign @ terms) * sign, axis=1) / known.sum()

    def parts(second: np.ndarray, table: np.ndarray) -> tuple[np.ndarray, ...]:
        """Sums within the first group, between the groups, within the second."""
        within, rows = np.sum((second @ table) * second, axis=1), second @ table.sum(axis=1)
        return table.sum() - 2 * rows + within, rows - within, within

    def of_groups(labels: np.ndarray) -> np.ndarray:
        second = labels[:, unit].astype(float)
        n_second = second.sum(axis=1)
        n_first = unit.size - n_second
        counts = (n_first * (n_first - 1), n_first * n_second, n_second * (n_second - 1)) if known.sum() == unit.size * (unit.size - 1) else parts(second, known)
        with np.errstate(divide="ignore", invalid="ignore"):
            within_first, between, within_second = (s / c for s, c in zip(parts(second, terms), counts))
            # Over all pairs including each path with itself, estimated from those there are.
            found = 2 * between - (1 - 1 / n_first) * within_first - (1 - 1 / n_second) * within_second
        return np.where(np.all([count > 0.5 for count in counts], axis=0), found, 0.0)
    return of_pairs if paths.are_paired else of_groups


def _distances(rows: np.ndarray, sign: int) -> np.ndarray:
    square = (rows[:, None, :] + sign * rows[None, :, :])**2
    n = np.sum(~np.isnan(square), axis=2)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(n > 0, np.sqrt(np.nansum(square, axis=2) / n), np.nan)


def _of_all(samples: TwoSamples, units: Units, statistic: Statistic) -> np.ndarray:
    labels, _ = labels_of(units.design)
    key = (units.design, units.of(samples).tobytes())
    if key not in samples._values:
        samples._values[key] = np.concatenate([statistic(labels[k:k + CHUNK]) for k in range(0, len(labels), CHUNK)])
    return samples._values[key]


def _observed(design: Design) -> np.ndarray:
    labels, are_all = labels_of(design)
    if not are_all:
        return labels[:1]
    return np.array([[0] * design.n_first + ([] if design.are_paired else [1] * design.n_second)], np.uint8)


def _threshold(observed: float) -> float:
    """Statistics that differ by rounding only are equal."""
    return observed if math.isinf(observed) else observed - ROUNDING * abs(observed)


def permutation_probability(samples: TwoSamples) -> float:
    """Two-sided p of the difference of the means under random assignment of the labels; 1 if there is nothing to compare."""
    if samples.is_empty:
        return 1.0
    units = Units(samples)
    return _share_as_large(samples, units, mean_statistic(samples, units))


def _share_as_large(samples: TwoSamples, units: Units, statistic: Statistic) -> float:
    least = _threshold(float(statistic(_observed(units.design))[0]))
    return float(np.mean(_of_all(samples, units, statistic) >= least))


def energy_distance(paths: TwoSamples) -> tuple[float, float]:
    """And its p-value."""
    units = Units(paths)
    statistic = energy_statistic(paths, units) if min(len(paths.first), len(paths.second)) > 1 else None
    if statistic is None:
        return np.nan, 1.0
    return float(statistic(_observed(units.design))[0]), _share_as_large(paths, units, statistic)


@dataclass
class JointTest:
    """Several tests of the same samples."""

    adjusted: list[float]  # p of the looks, then of the paths; NaN if not counted
    same_as: list[int]  # the earlier look with the same values up to a linear function, with which it is counted as one; or -1
    n_looks: int = 0  # counted
    n_too_small: int = 0  # not counted, as they have too few values for any p of 0.05
    least: float = np.nan  # smallest p-value that any of them could have


def joint_test(looks: Sequence[TwoSamples], paths: Sequence[TwoSamples] = ()) -> JointTest:
    """p-values adjusted for all by Westfall and Young's step-down max-T (1993, Resampling-Based Multiple Testing, algorithm 2.8): the labels of all
    change together, so that dependent ones count less often. Any below 0.05 is by chance in 5 % of such tests at most."""
    units = Units(*looks, *paths)
    n = len(looks) + len(paths)
    found = JointTest([np.nan] * n, [-1] * n)
    counted: list[tuple[int, TwoSamples, Statistic, bool]] = []

    def can_be_significant(samples: TwoSamples) -> bool:
        design = Units(samples).design
        found.least = float(np.nanmin([found.least, design.least]))
        # Looks too small for any labels are left out (Tarone 1990, Biometrics 46, 515); the observed labels must not decide it.
        all_units = design.n_first + design.n_second
        can = (design if design.are_paired else Design(all_units // 2, all_units - all_units // 2, False)).least <= SIGNIFICANT
        found.n_too_small += not can
        return can

    for i, look in enumerate(looks):
        if look.is_empty or not _varies(look):
            continue
        found.same_as[i] = next((k for k in range(i) if found.same_as[k] < 0 and _are_same(looks[k], look)), -1)
        if found.same_as[i] < 0 and can_be_significant(look):
            counted.append((i, look, mean_statistic(look, units), False))
    for i, one in enumerate(paths, len(looks)):
        if min(len(one.first), len(one.second)) < 2:
            continue
        statistic = energy_statistic(one, units)
        if statistic is not None and can_be_significant(one):
            counted.append((i, one, statistic, True))
    found.n_looks = len(counted)
    for (i, *_), p in zip(counted, _step_down(units, counted)):
        found.adjusted[i] = p
    for i, other in enumerate(found.same_as):
        if other >= 0:
            found.adjusted[i] = found.adjusted[other]
    return found


def _step_down(units: Units, looks: list[tuple[int, TwoSamples, Statistic, bool]]) -> list[float]:
    if not looks:
        return []
    are_all = labels_of(units.design)[1]
    observed, values = [], []
    for _, samples, statistic, is_distance in looks:
        own, all_values = (np.maximum(0.0, each) for each in (statistic(_observed(units.design)), _of_all(samples, units, statistic)))
        if is_distance:  # a squared one: its root relative to the mean square is like a studentized difference
            mean = np.mean(all_values if are_all else all_values[1:])
            own, all_values = (np.sqrt(each / mean) if mean > 0 else 0 * each for each in (own, all_values))
        observed.append(float(own[0]))
        values.append(all_values)
    order = np.argsort(-np.array(observed), kind="stable")
    # Over this look and those with a smaller observed statistic.
    largest = np.maximum.accumulate(np.array(values)[order[::-1]], axis=0)[::-1]
    p = [float(np.mean(row >= _threshold(observed[k]))) for row, k in zip(largest, order)]
    adjusted = np.empty(len(looks))
    adjusted[order] = np.maximum.accumulate(p)
    return adjusted.tolist()


def _are_same(one: TwoSamples, other: TwoSamples) -> bool:
    """Every labelling gives both the same statistic: one is a linear function of the other or, of pairs, a multiple."""
    if any(len(a) != len(b) or np.any(a != b) for a, b in ((one.first_group, other.first_group), (one.second_group, other.second_group))):
        return False
    x, y = (np.append(each.differences, 0) if each.are_paired else np.concatenate([each.first, each.second]) for each in (one, other))
    far = int(np.argmax(np.abs(x - x[-1])))
    if x[far] == x[-1]:
        return False
    slope = (y[far] - y[-1]) / (x[far] - x[-1])
    return slope != 0 and bool(np.all(np.abs(y - y[-1] - slope * (x - x[-1])) <= ROUNDING * abs(y[far] - y[-1])))


def _varies(samples: TwoSamples) -> bool:
    if samples.are_paired:
        return bool(np.any(samples.first != samples.second))
    return bool(np.ptp(np.concatenate([samples.first, samples.second])) > 0)
