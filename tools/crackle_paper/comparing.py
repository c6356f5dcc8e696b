# SPDX-License-Identifier: GPL-3.0-or-later
"""What two settings, or the two notches, have in common: paths seen from their own notch, and tests."""
from __future__ import annotations

import math

import numpy as np

from crackle_report.confidence import student_quantile

from .rows import Rows

LENGTH = 0.140  # of the plate [m]
# Shares of the ligament as in the program's patterns (crack_path.h).
DEVELOPED = 0.4
THROUGH = 0.6  # that a main crack crosses


def leading_notch(rows: Rows) -> np.ndarray:
    """The notch whose crack arrived at more sections; -1 where both arrived at as many."""
    arrived = np.isfinite(rows.z).sum(axis=2)
    return np.where(arrived[:, 0] == arrived[:, 1], -1, np.argmax(arrived, axis=1))


def in_base_frame(rows: Rows, notch: np.ndarray) -> np.ndarray:
    """Of each sample the notch that this one would be if its mesh were turned back; -1 stays."""
    return np.where((notch >= 0) & (rows.values["turned"] == 1), 1 - notch, notch)


def reach(rows: Rows, early: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Share of the ligament that the farther crack of each sample has crossed, and that of the other one."""
    both = np.stack([rows.values[f"{'early_' if early else ''}reach_{notch}"] for notch in range(2)])
    return both.max(axis=0), both.min(axis=0)


def groups(rows: Rows, limit: float, early: bool = False) -> tuple[int, int, int]:
    """How many samples have one crack, two cracks, and neither, by reach alone.

    Two: both have crossed the limit. One: one of them has, and THROUGH at least.
    """
    first, second = reach(rows, early)
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


def distance_between_bodies(rows: Rows) -> float:
    """Median distance of the leading paths of two different samples [m]."""
    paths = leading_path(rows)
    first, second = np.triu_indices(len(paths), 1)
    return float(np.nanmedian(path_distance(paths[first], paths[second]))) if len(paths) > 1 else math.nan


def difference(one: np.ndarray, other: np.ndarray, paired: bool) -> tuple[float, float]:
    """Mean of the other less that of the one, and half width of its 95 % interval (Student's, Welch's if unpaired)."""
    if paired:
        both = (other - one)[np.isfinite(other - one)]
        n = len(both)
        return (float(both.mean()), student_quantile(0.95, n - 1) * both.std(ddof=1) / math.sqrt(n)) if n > 1 else (math.nan,) * 2
    parts = [values[np.isfinite(values)] for values in (one, other)]
    if min(map(len, parts)) < 2:
        return math.nan, math.nan
    variances = [values.var(ddof=1) / len(values) for values in parts]
    total = sum(variances)
    freedom = total ** 2 / sum(v ** 2 / (len(values) - 1) for v, values in zip(variances, parts)) if total > 0 else 1
    return float(parts[1].mean() - parts[0].mean()), student_quantile(0.95, max(1, int(freedom))) * math.sqrt(total)


def same_share_test(hits: list[int], totals: list[int], rounds: int = 10_000) -> float:
    """p of one share in all groups, by Pearson's chi-square and dealing out the hits anew; at least 1/(rounds + 1)."""
    n = np.asarray(totals)
    group = np.repeat(np.arange(len(n)), n)
    hit = np.concatenate([np.arange(total) < k for k, total in zip(hits, totals)]).astype(float)
    expected = hit.mean() * n

    def deviation() -> float:
        return float((((np.bincount(group, hit, len(n)) - expected) ** 2) / n).sum())

    generator = np.random.Generator(np.random.Philox(2012))
    found = deviation()
    extreme = 0
    for _ in range(rounds):
        generator.shuffle(hit)
        extreme += deviation() >= found * (1 - 1e-12)
    return (extreme + 1) / (rounds + 1)


def fisher_test(hits: int, n: int, other_hits: int, other_n: int) -> float:
    """Two-sided p of equal shares (Fisher's exact test)."""
    def weight(k: int) -> int:
        return math.comb(n, k) * math.comb(other_n, hits + other_hits - k)

    total = hits + other_hits
    possible = range(max(0, total - other_n), min(n, total) + 1)
    return sum(weight(k) for k in possible if weight(k) <= weight(hits)) / sum(weight(k) for k in possible)


def binomial_test(hits: int, n: int) -> float:
    """Two-sided p of a fair coin."""
    if n == 0:
        return math.nan
    tail = sum(math.comb(n, k) for k in range(min(hits, n - hits) + 1)) / 2 ** n
    return min(1.0, 2 * tail)
