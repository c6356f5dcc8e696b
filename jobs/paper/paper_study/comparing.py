# SPDX-License-Identifier: GPL-3.0-or-later
"""What two settings, or the two notches, have in common: paths seen from their own notch, and tests."""
from __future__ import annotations

import math
from typing import Callable, Sequence

import numpy as np
from scipy import stats

from crackle_runs import mean_interval

from .rows import Rows

LENGTH = 0.140  # of the plate [m]
# Shares of the ligament as in the program's patterns (crack_path.h).
DEVELOPED = 0.4
THROUGH = 0.6  # that a main crack crosses
ROUNDS = 10_000  # of tests by drawing


def leading_notch(rows: Rows) -> np.ndarray:
    """The notch whose crack arrived at more sections; where both arrived at as many, the one that came farther, then the one
    that started first. -1 where none of this differs.
    """
    lead = np.full(len(rows), -1)
    earlier = -np.nan_to_num(of_both(rows, "start"), nan=np.inf)
    for first, second in (earlier, of_both(rows, "reach"), np.isfinite(rows.z).sum(axis=2).T):
        lead = np.where(first > second, 0, np.where(second > first, 1, lead))
    return lead


def of_both(rows: Rows, name: str) -> np.ndarray:
    """The values `name` of the two notches, 2 x samples."""
    return np.stack([rows.values[f"{name}_{notch}"] for notch in range(2)])


def in_base_frame(rows: Rows, notch: np.ndarray) -> np.ndarray:
    """Of each sample the notch that this one would be if its mesh were turned back; -1 stays."""
    return np.where((notch >= 0) & (rows.values["turned"] == 1), 1 - notch, notch)


def reach(rows: Rows) -> tuple[np.ndarray, np.ndarray]:
    """Share of the ligament that the farther crack of each sample has crossed at the end, and that of the other one."""
    both = of_both(rows, "reach")
    return both.max(axis=0), both.min(axis=0)


def of_notch(rows: Rows, name: str, notch: np.ndarray) -> np.ndarray:
    """Of each sample the value `name` of one of its notches; NaN for the notch -1."""
    first, second = of_both(rows, name)
    return np.where(notch < 0, np.nan, np.where(notch == 1, second, first))


def groups(rows: Rows, limit: float) -> tuple[int, int, int]:
    """How many samples have one crack, two cracks, and neither, by how far their cracks have come.

    Two: both have crossed the limit. One: one of them has, and THROUGH at least.
    """
    first, second = reach(rows)
    two = int((second >= limit).sum())
    one = int(((second < limit) & (first >= THROUGH)).sum())
    return one, two, len(rows) - one - two


def leading_path(rows: Rows) -> np.ndarray:
    """samples x sections [m]: the leading crack's z, as if its notch were the first one.

    The plate is turned by 180 degrees where the second notch leads; the sections lie symmetrically.
    """
    turned = LENGTH - rows.z[:, 1, ::-1]
    return np.where((leading_notch(rows) == 1)[:, None], turned, rows.z[:, 0])


def path_distance(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Root mean square over the sections that both paths arrive at, for each pair of paths [m]."""
    square = (one - other) ** 2
    both = np.isfinite(square)
    n = both.sum(axis=-1)
    return np.sqrt(np.where(both, square, 0).sum(axis=-1) / np.where(n > 0, n, np.nan))


def needed(half_width: np.ndarray, tolerance: float) -> int | None:
    """From how many samples on every half width stays within the tolerance; None: it does not with all of them.

    @param half_width samples x values, as running_half_width gives each column
    """
    wide = ~(half_width <= tolerance).all(axis=1)
    last = int(np.flatnonzero(wide)[-1]) + 2 if wide.any() else 1
    return last if last <= len(half_width) else None


def distances(paths: np.ndarray, others: np.ndarray | None = None) -> np.ndarray:
    """Distances of all pairs of different paths [m], or of all paths to all others."""
    if others is not None:
        return path_distance(paths[:, None], others[None]).ravel()
    first, second = np.triu_indices(len(paths), 1)
    return path_distance(paths[first], paths[second])


def running_half_width(values: np.ndarray) -> np.ndarray:
    """The half width of mean_interval over values[:i + 1], for every i."""
    return np.array([mean_interval(values[:i + 1])[1] for i in range(len(values))])


def share_interval(hits: int, n: int) -> tuple[float, float]:
    """Wilson's 95 % interval of a share."""
    interval = stats.binomtest(int(hits), int(n)).proportion_ci(0.95, "wilson")
    return interval.low, interval.high


def difference(one: np.ndarray, other: np.ndarray, paired: bool) -> tuple[float, float]:
    """Mean of the other less that of the one, and half width of its 95 % interval (Student's, Welch's if unpaired)."""
    if paired:
        return mean_interval(other - one)
    parts = [values[np.isfinite(values)] for values in (one, other)]
    if min(map(len, parts)) < 2:
        return math.nan, math.nan
    variances = [values.var(ddof=1) / len(values) for values in parts]
    total = sum(variances)
    freedom = total ** 2 / sum(v ** 2 / (len(values) - 1) for v, values in zip(variances, parts)) if total > 0 else 1
    return float(parts[1].mean() - parts[0].mean()), stats.t.ppf(0.975, max(1, int(freedom))) * math.sqrt(total)


def share_difference(one: np.ndarray, other: np.ndarray) -> tuple[float, float, float]:
    """Share of the other less that of the one in pairs of yes and no, and its 95 % interval: Newcombe 1998, Stat. Med. 17, 2635,
    method 10, as `crackle compare` has it.
    """
    n = len(one)
    if n == 0:
        return math.nan, math.nan, math.nan
    counts = [(int((one & other).sum()), int((one & ~other).sum())), (int((~one & other).sum()), int((~one & ~other).sum()))]
    (both, only_one), (only_other, neither) = counts
    margins = (both + only_one) * (only_other + neither) * (both + only_other) * (only_one + neither)
    excess = both * neither - only_one * only_other
    correlation = (max(0.0, excess - n / 2) if excess > 0 else excess) / math.sqrt(margins) if margins else 0.0
    (low_one, high_one), (low_other, high_other) = (share_interval(int(values.sum()), n) for values in (one, other))

    def reach_of(a: float, b: float) -> float:
        return math.sqrt(max(0.0, a * a - 2 * correlation * a * b + b * b))

    first, second = one.mean(), other.mean()
    value = float(second - first)
    return value, value - reach_of(second - low_other, high_one - first), value + reach_of(high_other - second, first - low_one)


def same_path_test(differences: np.ndarray) -> float:
    """p of a mean difference of 0 at all sections of paired paths, by the greatest |t| and turning signs at random.

    @param differences pairs x sections; pairs that lack a section are left out
    """
    found = differences[np.isfinite(differences).all(axis=1)]
    if len(found) < 2 or not found.any():
        return 1.0

    def greatest(signed: np.ndarray) -> float:
        mean, deviation = signed.mean(axis=0), signed.std(axis=0, ddof=1)
        return float(np.max(np.abs(mean) / np.maximum(deviation, 1e-15)))

    generator = np.random.Generator(np.random.Philox(2012))
    return _p_by_drawing(greatest(found), lambda: greatest(found * generator.choice([-1.0, 1.0], (len(found), 1))))


def same_share_test(hits: Sequence[int], totals: Sequence[int]) -> float:
    """p of one share in all groups, by Pearson's chi-square and dealing out the hits anew; at least 1 / (ROUNDS + 1). Empty groups
    say nothing.
    """
    hits, totals = ([k for k, total in zip(some, totals) if total > 0] for some in (hits, totals))
    if len(totals) < 2:
        return 1.0
    n = np.asarray(totals)
    group = np.repeat(np.arange(len(n)), n)
    hit = np.concatenate([np.arange(total) < k for k, total in zip(hits, totals)]).astype(float)
    expected = hit.mean() * n

    def deviation() -> float:
        return float((((np.bincount(group, hit, len(n)) - expected) ** 2) / n).sum())

    generator = np.random.Generator(np.random.Philox(2012))

    def drawn() -> float:
        generator.shuffle(hit)
        return deviation()

    return _p_by_drawing(deviation(), drawn)


def _p_by_drawing(found: float, draw: Callable[[], float]) -> float:
    """p of what was found, by how often a draw is as great, up to rounding."""
    extreme = sum(draw() >= found * (1 - 1e-12) for _ in range(ROUNDS))
    return (extreme + 1) / (ROUNDS + 1)


def binomial_test(hits: int, n: int) -> float:
    """Two-sided p of a fair coin."""
    return stats.binomtest(hits, n).pvalue if n > 0 else 1.0


def scatter_of_means(values: list[np.ndarray]) -> tuple[float, float]:
    """Standard deviation of the groups' true means, and its 95 % upper limit: that of their means less what the groups' own
    scatter makes of it. NaN with fewer than two groups of two values.
    """
    groups_of = [present for one in values if len(present := one[np.isfinite(one)]) > 1]
    if len(groups_of) < 2:
        return math.nan, math.nan
    variance = np.array([one.mean() for one in groups_of]).var(ddof=1)
    chance = np.mean([one.var(ddof=1) / len(one) for one in groups_of])
    freedom = len(groups_of) - 1
    largest = variance * freedom / stats.chi2.ppf(0.05, freedom)
    return math.sqrt(max(0.0, variance - chance)), math.sqrt(max(0.0, largest - chance))
