# SPDX-License-Identifier: GPL-3.0-or-later
"""A bar that is held at one end and pulled at the other by a load that grows from rest: d'Alembert's solution."""
from __future__ import annotations

import math

import numpy as np

BAR_SPEED = math.sqrt(3.3e9 / 1180)  # of waves along the plate, in jobs/paper/clock-from-zero.toml's material [m/s]


def section_load(rate: float, time: np.ndarray, place: float, length: float) -> np.ndarray:
    """Load that the section at `place` from the held end carries [N]; NaN where the time is.

    Every wave comes from the pulled end, goes back from the held one with its sign, and from the pulled one against it.

    @param rate of the load at the pulled end [N/s]
    @param time since it began to grow [s]
    """
    time = np.asarray(time, float)
    load = np.zeros_like(time)
    n_returns = math.ceil(max(0.0, float(np.nanmax(time, initial=0.0))) * BAR_SPEED / (2 * length)) + 1
    for n in range(n_returns):
        for way in (length - place, length + place):
            load += (-1) ** n * rate * np.maximum(0.0, time - (2 * n * length + way) / BAR_SPEED)
    return np.where(np.isfinite(time), load, np.nan)
