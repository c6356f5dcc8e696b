# SPDX-License-Identifier: GPL-3.0-or-later
"""Shares of samples with their intervals, as the pages of jobs/paper print and draw them."""
from __future__ import annotations

from crackle.inference import wilson

CONFIDENCE = 0.95


def share_in_percent(count: int, n: int) -> tuple[float, float, float]:
    """The share that `count` of `n` samples are, and its interval by Wilson [%]."""
    interval = wilson(count / n, n, CONFIDENCE)
    return 100 * count / n, 100 * interval.lower, 100 * interval.upper


def share_text(count: int, n: int, decimals: int = 0) -> str:
    share, low, high = share_in_percent(count, n)
    return f"{share:.{decimals}f} % ({low:.{decimals}f} to {high:.{decimals}f})"
