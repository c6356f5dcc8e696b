# SPDX-License-Identifier: GPL-3.0-or-later
"""Confidence intervals of means, as the program computes them."""
from __future__ import annotations

import math

import numpy as np
from scipy import special


def student_quantile(confidence: float, degrees_of_freedom: int) -> float:
    """The t for which P(|T| < t) = confidence; inf without degrees of freedom."""
    if degrees_of_freedom < 1:
        return math.inf
    return float(special.stdtrit(degrees_of_freedom, (1 + confidence) / 2))


def running_half_width(values: np.ndarray, confidence: float) -> np.ndarray:
    """Half width of the confidence interval of the mean over values[:i + 1], for every i.

    values: length n, NaN entries are left out. NaN where fewer than two values are there.
    """
    half_width = np.full(len(values), np.nan)
    count, mean, squares = 0, 0.0, 0.0
    latest = math.nan
    for i, value in enumerate(values):
        if not math.isnan(value):
            count += 1
            step = value - mean
            mean += step / count
            squares += step * (value - mean)
            if count > 1:
                deviation = math.sqrt(squares / (count - 1))
                latest = student_quantile(confidence, count - 1) * deviation / math.sqrt(count)
        half_width[i] = latest
    return half_width


def mean_of_present(values: np.ndarray) -> np.ndarray:
    """Mean over the first axis without NaN entries; NaN where nothing else is there."""
    present = np.isfinite(values)
    count = present.sum(axis=0)
    return np.divide(np.where(present, values, 0.0).sum(axis=0), count, out=np.full(values.shape[1:], np.nan),
                     where=count > 0)


def running_mean(values: np.ndarray) -> np.ndarray:
    """Mean over values[:i + 1] without its NaN entries, for every i; NaN before the first value."""
    present = ~np.isnan(values)
    count = np.cumsum(present)
    total = np.cumsum(np.where(present, values, 0.0))
    return np.divide(total, count, out=np.full(len(values), np.nan), where=count > 0)
