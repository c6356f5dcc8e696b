# SPDX-License-Identifier: GPL-3.0-or-later
"""The random inputs given experiments: posterior against prior, by `crackle calibrate`."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np
from matplotlib.figure import Figure

from .. import style
from ..drawing import show_units
from .picture import Picture

PRIOR, POSTERIOR = style.MUTED, style.NOTCH_COLOURS[0]
N_BINS = 24


def pictures(found: Optional[dict[str, Any]], drawn: list[dict[str, Any]]) -> list[Picture]:
    """Nothing without a calibration. @param drawn: Ensemble.inputs"""
    return [Picture("posterior", "Posterior and prior of each random input", _figure(found, drawn))] if found else []


def _figure(found: dict[str, Any], drawn: list[dict[str, Any]]) -> Figure:
    inputs, draws = found["inputs"], np.array(found["draws"]["values"], float)
    weight = np.array(found["draws"]["weights"], float)
    n_columns = min(4, len(inputs))
    n_rows = -(-len(inputs) // n_columns)
    figure = Figure(figsize=(style.PAGE_WIDTH * max(2, n_columns) / 4, 2.2 * n_rows + 0.3), layout="constrained")
    panels = figure.subplots(n_rows, n_columns, squeeze=False).ravel()
    from_prior = {one["key"]: np.array(one["values"], float) for one in drawn}
    for axes, one, values in zip(panels, inputs, draws.T):
        if one["key"] in from_prior:
            axes.hist(from_prior[one["key"]], N_BINS // 2, density=True, color=PRIOR, histtype="step", linewidth=0.8)
        axes.hist(values, N_BINS, weights=weight, density=True, color=POSTERIOR, alpha=0.35)
        top = axes.get_ylim()[1]
        for place, (name, colour) in enumerate((("prior", PRIOR), ("posterior", POSTERIOR))):
            height = -top * (0.08 + 0.1 * place)
            axes.plot([one[name]["lower"], one[name]["upper"]], [height, height], color=colour, linewidth=2.5, label=name)
            axes.plot(one[name]["mean"], height, "o", color=colour, markersize=4)
        axes.set_ylim(-0.3 * top, None)
        axes.set_yticks([])
        axes.spines["left"].set_visible(False)
        show_units(axes.xaxis, one["unit"])
        axes.set_xlabel(one["key"])
    for axes in panels[len(inputs):]:
        axes.remove()
    panels[0].legend(loc="upper left", fontsize=6.5)
    return figure
