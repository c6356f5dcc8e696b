# SPDX-License-Identifier: GPL-3.0-or-later
"""Weibull's distribution, F(x) = 1 - exp(-((x - threshold) / scale)^modulus), by maximum likelihood, with run-outs.

Where all broke, the estimate of the modulus over the modulus has a distribution that depends on the number of values only, and so
have the quantiles (Thoman, Bain, Antle, Technometrics 11 (1969) 445; ASTM C1239 tabulates them). It is found by simulation here,
which is the same in each call, and gives the factor that takes the bias away, and intervals. With run-outs the intervals are those
of the likelihood ratio.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Callable, Optional

import numpy as np
from scipy import optimize, stats

FEWEST = 3  # values
FEWEST_BROKEN = 5  # for a document
N_STEPS = 40  # of Newton's method


@dataclass(frozen=True)
class Weibull:
    modulus: float  # without bias where all broke
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


def _profile(values: np.ndarray, broken: np.ndarray, threshold: float = 0.0) -> Callable[[float], tuple[float, float]]:
    """Of a modulus the largest log-likelihood, over the scale, and that scale."""
    above = values - threshold
    top, n = above.max(), broken.sum()
    logarithm = np.log(above / top)

    def of(modulus: float) -> tuple[float, float]:
        mean = np.exp(modulus * logarithm).sum() / n  # (scale / top)^modulus
        return float(n * (math.log(modulus) - math.log(mean) - math.log(top) - 1) + (modulus - 1) * logarithm[broken].sum()), top * mean ** (1 / modulus)

    return of


def _best(of: Callable[[float], tuple[float, float]]) -> float:
    """The most likely modulus."""
    return math.exp(optimize.minimize_scalar(lambda x: -of(math.exp(x))[0], bounds=(math.log(0.05), math.log(500)), method="bounded",
                                             options={"xatol": 1e-10}).x)


def _ends(of: Callable[[float], float], best: float, low: float, high: float, confidence: float) -> tuple[float, float]:
    """Where the log-likelihood falls by half the quantile of chi-square on both sides of its maximum; `low` and `high` where not."""
    limit = of(best) - stats.chi2.ppf(confidence, 1) / 2

    def end(at: float) -> float:
        return optimize.brentq(lambda x: of(x) - limit, min(at, best), max(at, best)) if of(at) < limit else at

    return end(low), end(high)


def document(values: np.ndarray, broken: np.ndarray, confidence: float = 0.95) -> Optional[dict[str, Any]]:
    """Modulus and scale with intervals, and the fit with a threshold; None where too few broke.

    @param broken: whether each value is that of a break, not one that was borne
    """
    if broken.sum() < FEWEST_BROKEN or not (values > 0).all() or np.ptp(values[broken]) == 0:
        return None
    of = _profile(values, broken)
    modulus = _best(of)
    likelihood, scale = of(modulus)
    ends = _ends(lambda one: of(one)[0], modulus, modulus / 50, modulus * 50, confidence)
    top, n = values.max(), broken.sum()

    def of_scale(one: float) -> float:
        """The largest log-likelihood, over the modulus."""
        def negative(x: float) -> float:
            m = math.exp(x)
            return -(n * (math.log(m) - math.log(one)) + (m - 1) * np.log(values[broken] / one).sum() - ((values / one) ** m).sum())
        return -optimize.minimize_scalar(negative, bounds=(math.log(modulus / 30), math.log(modulus * 10)), method="bounded",
                                         options={"xatol": 1e-9}).fun

    scale_ends = _ends(of_scale, scale, scale * (values[broken].min() / top) ** 2, scale * (top / values[broken].min()) ** 2, confidence)
    exact = fit(values, np.array([0.5]), confidence) if broken.all() else None
    found = {"n_broken": int(n), "n_run_out": int((~broken).sum()),
             "modulus": {"value": exact.modulus, "lower": exact.lower, "upper": exact.upper} if exact else
             {"value": modulus, "lower": ends[0], "upper": ends[1]}, "scale": {"value": scale, "lower": scale_ends[0], "upper": scale_ends[1]}}
    return {**found, "with_threshold": _with_threshold(values, broken, likelihood, confidence)}


def _with_threshold(values: np.ndarray, broken: np.ndarray, likelihood: float, confidence: float) -> Optional[dict[str, Any]]:
    """The third parameter, from 0 to below the least value; moduli of at least 1, for below that the likelihood has no maximum. The
    p-value is that of the likelihood ratio, halved as the threshold cannot be negative."""
    def best(threshold: float) -> tuple[float, float]:
        of = _profile(values, broken, threshold)
        modulus = max(1.0, _best(of))
        return of(modulus)[0], modulus

    most = float(values.min()) * (1 - 1e-6)
    grid = np.linspace(0, most, 60)
    start = grid[int(np.argmax([best(one)[0] for one in grid]))]
    threshold = float(optimize.minimize_scalar(lambda one: -best(one)[0], bounds=(max(0, start - grid[1]), min(most, start + grid[1])),
                                               method="bounded").x) if start > 0 else 0.0
    found, modulus = best(threshold)
    if found <= likelihood:
        return None
    lower, upper = _ends(lambda one: best(one)[0], threshold, 0.0, most, confidence)
    return {"threshold": {"value": threshold, "lower": lower, "upper": upper}, "modulus": modulus,
            "scale": _profile(values, broken, threshold)(modulus)[1], "p_value": float(stats.chi2.sf(2 * (found - likelihood), 1) / 2)}
