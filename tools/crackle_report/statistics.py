# SPDX-License-Identifier: GPL-3.0-or-later
"""The ensemble's statistics from its samples, for an ensemble that is not finished.

The same definitions as /statistics of ensemble.h5: Student's interval for means, Wilson's for shares.
"""
from __future__ import annotations

import math
from statistics import NormalDist

import numpy as np

from .confidence import running_mean, student_quantile
from .results import DONE, Samples, Statistics

N_PATTERNS = 4


def look_schedule(samples: int, min_samples: int) -> list[int]:
    """Numbers of samples at which an ensemble with [ensemble.stop] may stop, and all of them."""
    looks = []
    while min_samples < samples:
        looks.append(min_samples)
        min_samples += (min_samples + 1) // 2
    return [*looks, samples]


def position_confidence(confidence: float, n_looks: int) -> float:
    """Confidence of the interval at one of several looks, so that all hold together."""
    return 1 - (1 - confidence) / n_looks


def path_statistics(z: np.ndarray, confidence: float, n_looks: int = 1) -> dict[str, np.ndarray]:
    """Statistics of positions (samples x rows x sections), NaN where none counts, by the names of the datasets."""
    shape = z.shape[1:]
    reached = np.isfinite(z).sum(axis=0)
    mean, std, half_width = (np.full(shape, np.nan) for _ in range(3))
    for index in np.ndindex(*shape):
        values = z[(slice(None), *index)]
        values = values[np.isfinite(values)]
        if values.size > 0:
            mean[index] = values.mean()
        if values.size > 1:
            std[index] = values.std(ddof=1)
            half_width[index] = student_quantile(position_confidence(confidence, n_looks), values.size - 1) * std[index] / math.sqrt(values.size)
    running = np.stack([running_mean(column) for column in z.reshape(len(z), -1).T], axis=1) \
        if z.size else np.empty(z.shape)
    return {"z_mean": mean, "z_std": std, "z_half_width": half_width, "reached": reached,
            "running_mean": running.reshape(z.shape)}


def make_statistics(samples: Samples, confidence: float, n_looks: int = 1) -> Statistics:
    """Over all samples done; their cracks by notch, leading and following ones together."""
    done = samples.status == DONE
    z = np.where(done[:, None, None], samples.position, np.nan)
    n_done = int(done.sum())
    count = np.bincount(samples.pattern[done], minlength=N_PATTERNS)[:N_PATTERNS]
    share = count / n_done if n_done else np.full(N_PATTERNS, np.nan)
    return Statistics(**path_statistics(z, confidence, n_looks), pattern_share=share,
                      pattern_half_width=np.array([wilson_half_width(s, n_done, confidence) for s in share]))


def wilson_interval(count: int, n: int, confidence: float) -> tuple[float, float]:
    """Wilson's confidence interval of a share seen count times in n > 0 trials."""
    q = NormalDist().inv_cdf((1 + confidence) / 2)
    centre = (count + q * q / 2) / (n + q * q)
    half_width = wilson_half_width(count / n, n, confidence)
    return max(0.0, centre - half_width), min(1.0, centre + half_width)


def wilson_half_width(share: float, n: int, confidence: float) -> float:
    """Half width of Wilson's confidence interval of a share out of n."""
    if n == 0:
        return math.nan
    q = NormalDist().inv_cdf((1 + confidence) / 2)
    return q / (1 + q * q / n) * math.sqrt(share * (1 - share) / n + q * q / (4 * n * n))
