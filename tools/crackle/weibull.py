# SPDX-License-Identifier: GPL-3.0-or-later
"""Weibull's distribution, F(x) = 1 - exp(-((x - threshold) / scale)^modulus), by maximum likelihood, with run-outs.

Where all broke, the estimate of the modulus over the modulus has a distribution that depends on the number of values only, and so
have the quantiles (Thoman, Bain, Antle, Technometrics 11 (1969) 445; ASTM C1239 tabulates them). It is found by simulation here,
which is the same in each call, and gives the factor that takes the bias away, and intervals. With run-outs the intervals are those
of the likelihood ratio. That of a threshold is no chi-square in few values, so that it is simulated, too.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Callable, NamedTuple, Optional

import numpy as np
from scipy import optimize, stats

FEWEST = 3  # values
FEWEST_BROKEN, FEWEST_WITH_THRESHOLD = 5, 10  # for a document
N_STEPS = 40  # of Newton's method
MOST_REACH = 100  # of a scale's interval, as a logarithm
N_SIMULATED, N_THRESHOLDS = 199, 40


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
    location, width, _ = (float(found[0]) for found in _most_likely(np.log(values)[None]))
    n_trials = int(np.clip(4_000_000 / values.size, 500, 10_000))
    trials = np.log(np.random.default_rng(1969).exponential(size=(n_trials, values.size)))
    locations, widths, _ = _most_likely(trials)
    tail = (0.5 - confidence / 2, 0.5 + confidence / 2)
    standard = np.log(-np.log1p(-probability))
    pivots = np.quantile((standard[:, None] - locations) / widths, tail, axis=1)
    lower, upper = np.exp(location + width * pivots)
    # A modulus is one over the width of the distribution of logarithms.
    return Weibull(float(1 / width / np.mean(1 / widths)), *(float(end / width) for end in np.quantile(widths, tail)),
                   float(np.exp(location)), probability, np.exp(location + width * standard), lower, upper)


class _Likely(NamedTuple):
    """Of each row of logarithms of values the most likely distribution of these."""

    location: np.ndarray  # ln(scale)
    width: np.ndarray  # 1 / modulus
    likelihood: np.ndarray  # its logarithm, of the values


def _most_likely(logarithms: np.ndarray, broken: Optional[np.ndarray] = None, least: float = 0.0) -> _Likely:
    """@param broken likewise, else all; @param least modulus"""
    broken = np.ones(logarithms.shape) if broken is None else np.broadcast_to(broken, logarithms.shape)
    top, n = logarithms.max(axis=1), np.maximum(1, broken.sum(axis=1))
    below = logarithms - top[:, None]
    mean = np.sum(broken * below, axis=1) / n
    modulus = 1.2 / below.std(axis=1)
    for _ in range(N_STEPS):
        weight = np.exp(modulus[:, None] * below)
        weight /= weight.sum(axis=1, keepdims=True)
        first, second = (np.sum(weight * below ** k, axis=1) for k in (1, 2))
        step = (first - mean - 1 / modulus) / (second - first ** 2 + 1 / modulus ** 2)
        modulus = np.maximum(modulus - step, modulus / 3)
        if (np.abs(step) < 1e-12 * modulus).all():
            break
    modulus = np.maximum(modulus, least)
    location = top + np.log(np.sum(np.exp(modulus[:, None] * below), axis=1) / n) / modulus
    return _Likely(location, 1 / modulus, n * (np.log(modulus) - modulus * location - 1) + (modulus - 1) * np.sum(broken * logarithms, axis=1))


def _ends(of: Callable[[float], float], best: float, low: float, high: float, fall: float) -> tuple[float, float]:
    """Where the log-likelihood falls by so much on both sides of its maximum; `low` and `high` where not."""
    limit = of(best) - fall

    def end(at: float) -> float:
        return optimize.brentq(lambda x: of(x) - limit, min(at, best), max(at, best)) if of(at) < limit else at

    return end(low), end(high)


def document(values: np.ndarray, broken: np.ndarray, confidence: float = 0.95) -> Optional[dict[str, Any]]:
    """Modulus and scale as of modulus_and_scale, and the fit with a threshold; None where too few broke."""
    found = modulus_and_scale(values, broken, confidence)
    if found is None:
        return None
    likely = _most_likely(np.log(values)[None], broken)
    return {**found, "with_threshold": _with_threshold(values, broken, likely, confidence) if broken.sum() >= FEWEST_WITH_THRESHOLD else None}


def modulus_and_scale(values: np.ndarray, broken: np.ndarray, confidence: float = 0.95) -> Optional[dict[str, Any]]:
    """With intervals; None where too few broke.

    @param broken: whether each value is that of a break, not one that was borne
    """
    if broken.sum() < FEWEST_BROKEN or not (values > 0).all() or np.ptp(values[broken]) == 0:
        return None
    if broken.all():
        exact = fit(values, np.array([1 - math.exp(-1)]), confidence)  # at the scale
        modulus, scale = [exact.modulus, exact.lower, exact.upper], [exact.scale, exact.quantile_lower[0], exact.quantile_upper[0]]
    else:
        likely = _most_likely(np.log(values)[None], broken)
        modulus, scale = _intervals_of_ratio(values, broken, 1 / likely.width[0], math.exp(likely.location[0]), stats.chi2.ppf(confidence, 1) / 2)
    return {"n_broken": int(broken.sum()), "n_run_out": int((~broken).sum()), "modulus": dict(zip(("value", "lower", "upper"), modulus)),
            "scale": dict(zip(("value", "lower", "upper"), scale))}


def _intervals_of_ratio(values: np.ndarray, broken: np.ndarray, modulus: float, scale: float, fall: float) -> tuple[list[float], list[float]]:
    """Of modulus and scale, each at the most likely value of the other."""
    top = values.max()

    def likelihood(modulus: float, scale: float) -> float:
        x = values / scale
        return float(broken.sum() * math.log(modulus / scale) + (modulus - 1) * np.log(x[broken]).sum() - (x ** modulus).sum())

    def of_modulus(one: float) -> float:
        return likelihood(one, top * float(np.sum((values / top) ** one) / broken.sum()) ** (1 / one))

    def of_scale(one: float) -> float:
        return -optimize.minimize_scalar(lambda x: -likelihood(math.exp(x), one), bounds=(math.log(modulus / 30), math.log(modulus * 10)),
                                         method="bounded", options={"xatol": 1e-9}).fun

    reach = float(top / values[broken].min()) ** 2
    low, high = (_far_enough(of_scale, scale, end, fall) for end in (1 / reach, reach))
    return [modulus, *_ends(of_modulus, modulus, modulus / 50, modulus * 50, fall)], [scale, *_ends(of_scale, scale, low, high, fall)]


def _far_enough(of: Callable[[float], float], best: float, factor: float, fall: float) -> float:
    """A multiple of the best value at which the log-likelihood has fallen by so much: by a factor whose logarithm is doubled until it has."""
    while of(best * factor) > of(best) - fall and abs(math.log(factor)) < MOST_REACH:
        factor *= factor
    return best * factor


def _gains(values: np.ndarray, broken: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of each row of values thresholds from 0 to below the least, and what the log-likelihood gains by each; moduli of at least 1, for below that it has
    no maximum."""
    thresholds = values.min(axis=1, keepdims=True) * (1 - np.geomspace(1, 1e-4, N_THRESHOLDS))
    likely = _most_likely(np.log(values[:, None] - thresholds[:, :, None]).reshape(-1, values.shape[1]), np.repeat(broken, N_THRESHOLDS, axis=0), 1.0)
    return thresholds, likely.likelihood.reshape(thresholds.shape) - _most_likely(np.log(values), broken).likelihood[:, None]


def _with_threshold(values: np.ndarray, broken: np.ndarray, likely: _Likely, confidence: float) -> Optional[dict[str, Any]]:
    """The third parameter; its p-value is the share of samples of the distribution without it whose likelihood gains as much, and the interval has
    their quantile where that is larger than chi-square's."""
    def at(threshold: float) -> _Likely:
        return _most_likely(np.log(values - threshold)[None], broken, 1.0)

    def of(threshold: float) -> float:
        return float(at(threshold).likelihood[0])

    (grid,), (gain,) = _gains(values[None], broken[None])
    best = int(gain.argmax())
    if best == 0 or gain[best] <= 0:
        return None
    threshold = float(optimize.minimize_scalar(lambda one: -of(one), bounds=(grid[best - 1], grid[min(best + 1, N_THRESHOLDS - 1)]), method="bounded").x)
    random = np.random.default_rng(1951)
    drawn = math.exp(likely.location[0]) * random.weibull(1 / likely.width[0], (N_SIMULATED, values.size))
    limit = np.inf if broken.all() else float(np.median(values[~broken]))
    own = of(threshold) - likely.likelihood[0]
    others = np.maximum(0, _gains(np.minimum(drawn, limit), drawn <= limit)[1].max(axis=1))
    fall = max(stats.chi2.ppf(confidence, 1) / 2, float(np.quantile(others, confidence)))
    lower, upper = _ends(of, threshold, 0.0, float(grid[-1]), fall)
    found = at(threshold)
    return {"threshold": {"value": threshold, "lower": lower, "upper": upper}, "modulus": 1 / found.width[0], "scale": math.exp(found.location[0]),
            "p_value": (1 + int(np.sum(others >= own - 1e-9))) / (N_SIMULATED + 1)}
