# SPDX-License-Identifier: GPL-3.0-or-later
"""What two settings, or the two notches, have in common: paths seen from their own notch, and tests."""
from __future__ import annotations

import math

import numpy as np

from crackle_report.confidence import running_mean

from .rows import Rows

LENGTH = 0.140  # of the plate [m]


def leading_notch(rows: Rows) -> np.ndarray:
    """The notch whose crack arrived at more sections; -1 where both arrived at as many."""
    arrived = np.isfinite(rows.z).sum(axis=2)
    return np.where(arrived[:, 0] == arrived[:, 1], -1, np.argmax(arrived, axis=1))


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


def settled(paths: np.ndarray, tolerance: float) -> int:
    """From how many samples on the mean path stays within the tolerance [m] of the mean of all, at every section.

    @param paths samples x sections [m]; NaN where a path did not arrive
    """
    running = np.stack([running_mean(column) for column in paths.T], axis=1)
    far = ~(np.abs(running - running[-1]) <= tolerance).all(axis=1)
    return int(np.flatnonzero(far)[-1]) + 2 if far.any() else 1


def distance_between_bodies(rows: Rows) -> float:
    """Median distance of the leading paths of two different samples [m]."""
    paths = leading_path(rows)
    first, second = np.triu_indices(len(paths), 1)
    return float(np.nanmedian(path_distance(paths[first], paths[second]))) if len(paths) > 1 else math.nan


def permutation_test(one: np.ndarray, other: np.ndarray, rounds: int = 10_000) -> float:
    """Two-sided p of equal means, by shuffling."""
    one, other = one[np.isfinite(one)], other[np.isfinite(other)]
    if min(len(one), len(other)) < 2:
        return math.nan
    generator = np.random.Generator(np.random.Philox(2012))
    pool = np.concatenate([one, other])
    found = abs(one.mean() - other.mean())
    extreme = 0
    for _ in range(rounds):
        generator.shuffle(pool)
        extreme += abs(pool[:len(one)].mean() - pool[len(one):].mean()) >= found * (1 - 1e-12)
    return (extreme + 1) / (rounds + 1)


def same_share_test(hits: list[int], totals: list[int], rounds: int = 10_000) -> float:
    """p of one share in all groups, by Pearson's chi-square and dealing out the hits anew."""
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
