# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of experiments against samples by the distances between them. If both are of one distribution they are exchangeable, and
p-values are valid for any number of samples: at most alpha in a share alpha of cases.

Tables have a row for each experiment or sample; NaN: a crack did not get there.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional, Sequence

import numpy as np
from scipy import stats

from .inference import MOST_EXACT, N_RANDOM, ROUNDING, Difference, TwoSamples, difference_of_means

LEVEL = 0.05
N_TRIALS, N_OF_TRIAL = 200, 199  # pseudo-experiments, and permutations for each; LEVEL is a multiple of 1 / (N_OF_TRIAL + 1)
MOST_COLUMNS, MOST_EXPERIMENTS = 10, 500  # in pseudo-experiments
COUNTING_SHARE = 0.9  # columns count that at least this share of the samples reaches


def random_stream(*key: int) -> np.random.Generator:
    """The same numbers for the same key."""
    return np.random.Generator(np.random.Philox(np.random.SeedSequence(key)))


def least_p_value(n_samples: int) -> float:
    return 1 / (n_samples + 1)


def samples_needed(level: float = LEVEL) -> int:
    """For a p-value of `level`: 19 for 0.05."""
    return math.ceil(1 / level - ROUNDING) - 1


# Distances.

def largest_difference(table: np.ndarray) -> float:
    """Of two values in the same column; 1 if there is none. What lacks a value is as far as that from what has one."""
    reached = ~np.isnan(table)
    with np.errstate(invalid="ignore"):
        spans = np.where(reached, table, -np.inf).max(axis=0) - np.where(reached, table, np.inf).min(axis=0)
    return float(spans.max(initial=0.0)) or 1.0


def distances(one: np.ndarray, other: np.ndarray, missing: float) -> np.ndarray:
    """Root mean square differences over the columns of each row of one table from each of another."""
    total = np.zeros((len(one), len(other)))
    for a, b in zip(one.T, other.T):
        difference = a[:, None] - b
        lack = np.isnan(a)[:, None], np.isnan(b)
        total += np.where(lack[0] & lack[1], 0.0, np.where(lack[0] | lack[1], missing, difference)) ** 2
    return np.sqrt(total / one.shape[1])


def distances_of(table: np.ndarray) -> np.ndarray:
    return distances(table, table, largest_difference(table))


def joint_distances(each: Sequence[np.ndarray]) -> np.ndarray:
    """Several distances of the same rows as one: the root mean square of each over its own root mean square over all pairs."""
    n = len(each[0])
    return np.sqrt(sum(d ** 2 * (n * (n - 1) / total if (total := (d ** 2).sum()) else 0) for d in each) / len(each))


# One experiment.

@dataclass
class RankTest:
    """Of row 0 among all rows, by its mean distance to the others and by that to its k-th nearest.

    The smaller of the two p-values is itself ranked among those of all rows, so that `p` needs no correction and is as small as
    1 / n where both see it. It is at most twice the smaller one.
    """
    p: float
    p_mean: float
    p_near: float
    k: int
    mean: np.ndarray  # of each row
    near: np.ndarray


def rank_test(found: np.ndarray) -> RankTest:
    n = len(found)
    mean = found.sum(axis=1) / (n - 1)
    k = min(n - 1, max(1, round(math.sqrt(n - 1))))
    near = np.sort(found, axis=1)[:, k]  # after the row itself
    p_mean, p_near = (_shares_as_large(values) for values in (mean, near))
    return RankTest(_shares_as_large(-np.minimum(p_mean, p_near))[0], p_mean[0], p_near[0], k, mean, near)


def _shares_as_large(values: np.ndarray) -> np.ndarray:
    """Of each value the share of all that are at least as large."""
    ordered = np.sort(values)
    return (len(values) - np.searchsorted(ordered, values - ROUNDING * np.abs(values))) / len(values)


# Several.

@dataclass
class GroupTest:
    """p-values by permutation of what is an experiment and what a sample.

    `energy`: the energy distance (Székely and Rizzo 2004), which sees any difference of distributions; `p_depth`: by the rank sum of
    the experiments by mean distance to all others, a depth (Liu and Singh 1993), which sees what lies farther out than the samples.
    """
    energy: float
    p_energy: float
    p_depth: float
    n_permutations: int
    are_all: bool

    @property
    def p(self) -> float:
        """Both tests as one (Bonferroni)."""
        return min(1.0, 2 * min(self.p_energy, self.p_depth))


def _depth_ranks(found: np.ndarray) -> np.ndarray:
    total = found.sum(axis=1)
    scale = total.max(initial=0.0) or 1.0
    return stats.rankdata(np.round(total / scale, 12))


def _energies(rows: np.ndarray, found: np.ndarray) -> np.ndarray:
    """Of groups of rows (groups x members) against the others."""
    m, total = rows.shape[-1], len(found)
    n = total - m
    of_group = found.sum(axis=1)[rows].sum(axis=-1)
    if m * m <= 4 * total:
        within = found[rows[..., None], rows[..., None, :]].sum(axis=(-2, -1))
    else:
        members = np.zeros((len(rows), total))
        np.put_along_axis(members, rows, 1.0, axis=-1)
        within = ((members @ found) * members).sum(axis=1)
    between = of_group - within
    return 2 * between / (m * n) - within / m ** 2 - (found.sum() - 2 * between - within) / n ** 2


def group_test(found: np.ndarray, n_experiments: int) -> GroupTest:
    """@param found: distances with the experiments first"""
    n, ranks, own = len(found), _depth_ranks(found), np.arange(n_experiments)
    are_all = math.comb(n, n_experiments) <= MOST_EXACT
    energy, rank_sum = float(_energies(own[None], found)[0]), float(ranks[own].sum())

    def as_large(one: np.ndarray, _other: np.ndarray, axis: int = -1) -> np.ndarray:
        """1 where the energy is as large as the experiments', and 2 more where the rank sum is."""
        rows = np.atleast_2d(one).astype(int)
        code = ((_energies(rows, found) >= energy - ROUNDING * abs(energy))
                + 2 * (ranks[rows].sum(axis=-1) >= rank_sum * (1 - ROUNDING)))
        return code.reshape(one.shape[:-1])

    tried = stats.permutation_test((own, np.arange(n_experiments, n)), as_large, permutation_type="independent", vectorized=True, axis=-1,
                                   n_resamples=np.inf if are_all else N_RANDOM, batch=2_000, random_state=random_stream(1))
    code = tried.null_distribution.astype(int)
    n_tried = len(code) + (not are_all)  # with the experiments themselves
    shares = [((code & bit > 0).sum() + (not are_all)) / n_tried for bit in (1, 2)]
    return GroupTest(energy, float(shares[0]), float(shares[1]), n_tried, are_all)


@dataclass
class Power:
    """How many of N_TRIALS pseudo-experiments group_test finds at LEVEL."""
    of_shift: int  # by one standard deviation, along the whole path
    of_scatter: int  # twice that of the samples
    n_trials: int = N_TRIALS


def mean_variance(table: np.ndarray) -> float:
    """Averaged over the columns that two rows reach or more."""
    columns = table[:, (~np.isnan(table)).sum(axis=0) >= 2]
    return float(np.nanvar(columns, axis=0, ddof=1).mean()) if columns.size else math.nan


def power(samples: np.ndarray, n_experiments: int) -> Optional[Power]:
    """Of as many experiments beside as many samples. Both are drawn from the samples with replacement, smoothed by noise of the samples'
    own covariance so that hardly two are the same. None with fewer than four samples, without scatter, or with MOST_EXPERIMENTS."""
    samples = samples[:, ~np.isnan(samples).all(axis=0)]  # without stations in holes
    samples = samples[:, ::max(1, samples.shape[1] // MOST_COLUMNS)]
    n, deviation = len(samples), math.sqrt(mean_variance(samples))
    if n < 4 or not deviation > 0 or n_experiments >= MOST_EXPERIMENTS:
        return None
    random, mean = random_stream(2), np.nanmean(samples, axis=0)
    centred = np.nan_to_num(samples - mean)
    width = n ** (-1 / (4 + min(samples.shape[1], box_degrees(samples))))
    total = n + n_experiments
    rows = np.array([np.arange(n_experiments), *(random.choice(total, n_experiments, replace=False) for _ in range(N_OF_TRIAL))])
    missing, found, counts = largest_difference(samples), np.zeros((total, total)), [0, 0]
    for _ in range(N_TRIALS):
        noise = random.standard_normal((total, n)) @ centred / math.sqrt(n - 1)
        drawn = mean + (samples[random.integers(n, size=total)] - mean + width * noise) / math.sqrt(1 + width ** 2)
        own, others = drawn[:n_experiments], drawn[n_experiments:]
        found[n_experiments:, n_experiments:] = distances(others, others, missing)
        for which, changed in enumerate((own + deviation, 2 * own - mean)):
            found[:n_experiments] = distances(changed, np.vstack([changed, others]), missing)
            found[n_experiments:, :n_experiments] = found[:n_experiments, n_experiments:].T
            for statistic in (_energies(rows, found), _depth_ranks(found)[rows].sum(axis=1)):
                if (statistic >= statistic[0] - ROUNDING * abs(statistic[0])).sum() <= LEVEL / 2 * (N_OF_TRIAL + 1):
                    counts[which] += 1
                    break
    return Power(*counts)


@dataclass
class Scatter:
    """How experiments differ from samples: by a shift, and in scatter.

    `shift`: mean over the columns of the experiments' mean less the samples', with Welch's interval. `ratio`: standard deviation of
    the experiments, without the error of reading them, over that of the samples, sqrt((V_e - error^2) / V_s) for variances averaged
    over the columns, with the interval of F with (m - 1) v and (n - 1) v degrees of freedom, v = tr^2 S / tr S^2 (Box 1954).
    """
    n_experiments: int = 0
    n_samples: int = 0  # with a value in all columns that count
    n_columns: int = 0
    degrees: float = math.nan
    shift: Difference = Difference()
    ratio: Difference = Difference()


def box_degrees(table: np.ndarray) -> float:
    table = table[:, ~np.isnan(table).all(axis=0)]
    centred = np.nan_to_num(table - np.nanmean(table, axis=0))
    product = centred @ centred.T
    square = (product ** 2).sum()
    return float(np.trace(product) ** 2 / square) if square > 0 else 1.0


def scatter(experiments: np.ndarray, samples: np.ndarray, error: float, confidence: float = 1 - LEVEL) -> Scatter:
    """Columns that an experiment, or more than a tenth of the samples, does not reach do not count.

    @param samples: without errors of reading; @param error: standard deviation of that of the experiments
    """
    columns = ~np.isnan(experiments).any(axis=0) & ((~np.isnan(samples)).mean(axis=0) >= COUNTING_SHARE)
    experiments, samples = experiments[:, columns], samples[:, columns]
    samples = samples[~np.isnan(samples).any(axis=1)]
    found = Scatter(len(experiments), len(samples), int(columns.sum()))
    if not columns.any() or min(len(experiments), len(samples)) < 2:
        return found
    found.shift = difference_of_means(TwoSamples(samples.mean(axis=1), experiments.mean(axis=1)), confidence)
    of_samples, variance = mean_variance(samples), mean_variance(experiments)
    if not min(of_samples, variance) > 0:
        return found
    found.degrees = box_degrees(samples)
    f = stats.f((len(experiments) - 1) * found.degrees, (len(samples) - 1) * found.degrees)
    factors = (1.0, *(1 / f.ppf((1 + sign * confidence) / 2) for sign in (1, -1)))
    found.ratio = Difference(*(math.sqrt(max(0.0, factor * variance - error ** 2) / of_samples) for factor in factors))
    return found
