# SPDX-License-Identifier: GPL-3.0-or-later
"""Which part of a load-displacement curve tells what a test shows: what has broken moves on without end."""
from __future__ import annotations

from typing import Iterable

import numpy as np

PEAK = 0.999  # the load is at its peak when it first comes so near to its largest value
BEYOND = 0.15  # of the displacements until then, shown after them


def while_held(load: np.ndarray, phase: np.ndarray) -> slice:
    """The moments up to the peak of the load and to the last equilibrium.

    @param phase of each moment the number of its dynamic phase, 0 in quasi-static loading
    """
    peak = int(np.argmax(load >= PEAK * np.nanmax(load)))
    return slice(max([peak, *np.flatnonzero(phase == 0)[-1:]]) + 1)


def load_limits(curves: Iterable[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Of axes that show what samples held: the displacement's and the load's.

    @param curves displacement, load and phase of each sample
    """
    held = [(x[part], load[part]) for x, load, phase in curves for part in [while_held(load, phase)]]
    ends = np.array([(0.0, 0.0, 0.0), *((x.min(), x.max(), load.max()) for x, load in held)])
    left, right, top = ends[:, 0].min(), *ends[:, 1:].max(axis=0)
    beyond = BEYOND * (right - left)
    return (float(left - beyond * (left < 0)), float(right + beyond) or 1.0), (0.0, float(1.08 * top) or 1.0)
