# SPDX-License-Identifier: GPL-3.0-or-later
"""The value at which a share that falls or rises with it is one that was seen elsewhere."""
from __future__ import annotations

import math
from typing import Sequence

import numpy as np
from crackle.inference import Interval
from scipy import optimize, special, stats

from shares import CONFIDENCE

BEYOND = math.log(10)  # of the values, how far the ends of the interval are looked for


def threshold(values: Sequence[float], counts: Sequence[int], numbers: Sequence[int], seen: tuple[int, int]) -> tuple[float, Interval]:
    """Estimate, and interval by the ratio of likelihoods, of the value at which the share of `seen`, a count and its number, is found.

    @param values: at which `counts` of `numbers` samples were found; their share is a logistic function of the value's logarithm
    @param seen: some of its number, not all
    @return ends of the interval that lie a factor of ten beyond all values are 0 and infinite
    """
    places = np.log(values)
    middle = places.mean()
    found, n = np.append(counts, seen[0]).astype(float), np.append(numbers, seen[1]).astype(float)

    def loss(parameters: np.ndarray, distances: np.ndarray) -> tuple[float, np.ndarray]:
        """Minus the likelihood's logarithm, and its gradient; `distances` from the middle, of the values and, or not, of what was seen."""
        logit, one = parameters[0] + parameters[1] * distances, len(distances)
        value = -found[:one] @ special.log_expit(logit) - (n - found)[:one] @ special.log_expit(-logit)
        change = n[:one] * special.expit(logit) - found[:one]
        return float(value), np.array([change.sum(), change @ distances])

    def best(*place: float) -> optimize.OptimizeResult:
        return optimize.minimize(loss, start, args=(np.append(places, place) - middle,), method="BFGS", jac=True)

    start = np.zeros(2)
    start = best().x
    estimate = float(middle + (special.logit(seen[0] / seen[1]) - start[0]) / start[1])
    limit = best(estimate).fun + stats.chi2.ppf(CONFIDENCE, 1) / 2

    def end(far: float, none: float) -> float:
        if best(far).fun < limit:
            return none
        return math.exp(optimize.brentq(lambda place: best(place).fun - limit, *sorted((estimate, far)), xtol=1e-5))

    low, high = min(places.min(), estimate) - BEYOND, max(places.max(), estimate) + BEYOND
    return math.exp(estimate), Interval(end(low, 0.0), end(high, math.inf))
