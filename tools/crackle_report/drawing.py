# SPDX-License-Identifier: GPL-3.0-or-later
"""What several pictures draw: the plate, and a window on its cracked part."""
from __future__ import annotations

from typing import Iterable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from matplotlib.ticker import MaxNLocator

from . import style
from .plate import Plate

MARGIN = 3.0  # round notches and cracks [mm]


def window(plate: Plate, z_values: Iterable[np.ndarray]) -> tuple[float, float]:
    """The range of z that shows all notches and all given z [m], in mm."""
    ends = [z for notch in range(len(plate.notches)) for z in plate.slot_range(notch)]
    for values in z_values:
        values = values[np.isfinite(values)]
        if values.size:
            ends += [float(values.min()), float(values.max())]
    if not ends:
        ends = [0.0, plate.size[2]]
    low, high = min(ends) / style.MILLIMETRE - MARGIN, max(ends) / style.MILLIMETRE + MARGIN
    return max(low, -1.0), min(high, plate.size[2] / style.MILLIMETRE + 1.0)


def draw_plate(axes: Axes, plate: Plate, z_range: tuple[float, float], faint: bool = False) -> None:
    """The body with its slots, at true proportions; axes in mm."""
    width = plate.size[1] / style.MILLIMETRE
    axes.add_patch(Polygon(plate.outline() / style.MILLIMETRE, closed=True, zorder=0,
                           facecolor="none" if faint else style.BODY,
                           edgecolor=style.MUTED if faint else style.OUTLINE,
                           linewidth=0.6, linestyle="--" if faint else "-"))
    axes.set_xlim(-0.04 * width, 1.04 * width)
    axes.set_ylim(*z_range)
    axes.set_aspect("equal")
    axes.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
    axes.spines[["left", "bottom"]].set_visible(False)
    axes.tick_params(length=2, pad=1.5)
