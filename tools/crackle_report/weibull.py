# SPDX-License-Identifier: GPL-3.0-or-later
"""Weibull's distribution of two parameters, F(x) = 1 - exp(-(x / scale)^modulus), by maximum likelihood.

The estimate of the modulus over the modulus has a distribution that depends on the number of values only, and so have the
quantiles (Thoman, Bain, Antle, Technometrics 11 (1969) 445; ASTM C1239 tabulates them). It is found by simulation here, which
is the same in each call, and gives the factor that takes the bias away, and intervals.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

FEWEST = 3  # values
N_STEPS = 40  # of Newton's method


@dataclass(frozen=True)
class Weibull:
    modulus: float  # without bias
    lower: float  # ends of its interval
    upper: float
    scale: float
    probability: np.ndarray  # at which the quantiles are given
    quantile: np.ndarray  # of the distribution with the most likely parameters
    quantile_lower: np.ndarray
    quantile_upper: np.ndarray


def fit(values: np.ndarray, probability: np.ndarray, confidence: float = 0.95) -> Weibull | None:
    """Fits independent values; None for fewer than FEWEST, or where they are not positive, or all equal."""
    if values.size < FEWEST or not (values > 0).all() or np.ptp(values) == 0:
        return None
    location, width = (float(found[0]) for found in _most_likely(np.log(values)[None]))
    n_trials = int(np.clip(4_000_000 / values.size, 500, 10_000))
    trials = np.log(np.random.default_rng(1969).exponential(size=(n_trials, values.size)))
    locations, widths = _most_likely(trials)
    tail = (0.5 - confidence / 2, 0.5 + confidence / 2)
    standard = np.log(-np.log1p(-probability))
    pivots = np.quantile((standard[:, None] - locations) / widths, tail, axis=1)
    lower, upper = np.exp(location + width * pivots)
    # A modulus is one over the width of the distribution of logarithms.
    return Weibull(float(1 / width / np.mean(1 / widths)), *(float(end / width) for end in np.quantile(widths, tail)),
                   float(np.exp(location)), probability, np.exp(location + width * standard), lower, upper)


def _most_likely(logarithms: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Location and width of the distribution of logarithms in each row: ln(scale) and 1 / modulus."""
    top = logarithms.max(axis=1)
    below = logarithms - top[:, None]
    mean = below.mean(axis=1)
    modulus = 1.2 / below.std(axis=1)
    for _ in range(N_STEPS):
        weight = np.exp(modulus[:, None] * below)
        weight /= weight.sum(axis=1, keepdims=True)
        first, second = (np.sum(weight * below ** k, axis=1) for k in (1, 2))
        step = (first - mean - 1 / modulus) / (second - first ** 2 + 1 / modulus ** 2)
        modulus = np.maximum(modulus - step, modulus / 3)
        if (np.abs(step) < 1e-12 * modulus).all():
            break
    return top + np.log(np.mean(np.exp(modulus[:, None] * below), axis=1)) / modulus, 1 / modulus
