# SPDX-License-Identifier: GPL-3.0-or-later
"""The fragments of all samples: how many of which mass, and how their number grew."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter
from crackle.units import Unit

from .. import style
from ..drawing import draw_grid
from ..fields import FragmentHistory
from ..options import Options
from ..results import Ensemble
from .picture import Picture, Section

COLOUR = style.NOTCH_COLOURS[0]
MASSES = (Unit("mg", 1e-6), Unit("g", 1e-3), Unit("kg", 1.0))


def section(ensemble: Ensemble, _: Options) -> Optional[Section]:
    """None where no sample has more than two fragments."""
    found = ensemble.fragments
    if found is None or found["statistics"]["n_fragmented"] == 0:
        return None
    counted = found["statistics"]["number"]
    half_width = f" ± {counted['half_width']:.2g}" if counted["half_width"] is not None else ""
    histories = [history for history in (ensemble.files.fragment_history(i) for i in ensemble.shown)
                 if history is not None and history.time.size > 1]
    return Section(
        "Fragments",
        "Fragments are pieces of the body of two nodes or more; single nodes are dust. Left: the mean number of fragments of at least a mass, "
        f"with the {100 * ensemble.confidence:g} % interval of the mean, and the numbers of each sample, thin. Right: their number over time.",
        f"{counted['mean']:.3g}{half_width} fragments, mean of {found['statistics']['n_of']} samples.",
        [Picture("fragments", "Number of fragments over their mass, and over time", _draw(ensemble, found, histories))])


def _draw(ensemble: Ensemble, found: dict[str, Any], histories: list[FragmentHistory]) -> Figure:
    figure = Figure(figsize=(style.PAGE_WIDTH, 3.5), layout="constrained")
    of_mass, over_time = figure.subplots(1, 2)
    _distribution(of_mass, found)
    for history in histories:
        over_time.step(ensemble.times.of(history.time), history.number, where="post", color=COLOUR,
                       linewidth=1.2 if len(histories) == 1 else 0.7, alpha=1 if len(histories) == 1 else 0.6)
    over_time.set_xlabel(ensemble.times.label("time since onset"))
    over_time.set_ylabel("fragments")
    over_time.set_ylim(bottom=0)
    over_time.set_xlim(left=0)
    draw_grid(over_time)
    return figure


def _distribution(axes: Axes, found: dict[str, Any]) -> None:
    statistics = found["statistics"]
    body = statistics["body_mass"]["mean"]
    unit = next((unit for unit in MASSES if body < 1e3 * unit.size), MASSES[-1])
    mass = unit.of(np.array(found["shares"]) * body)
    mean, half = (np.array([one[name] for one in statistics["heavier"]], float) for name in ("mean", "half_width"))
    samples = [np.array(row, float) for row in found["heavier"] if row]
    for row in samples if len(samples) > 1 else ():
        axes.plot(mass, np.where(row > 0, row, np.nan), color=style.MUTED, linewidth=0.5, alpha=0.6)
    least = 0.5 * mean[mean > 0].min()
    axes.plot(mass, np.where(mean > 0, mean, np.nan), color=COLOUR, linewidth=1.5)
    if np.isfinite(half).any():
        axes.fill_between(mass, np.maximum(mean - half, least), np.maximum(mean + half, least), color=COLOUR, alpha=0.2, linewidth=0)
    # From the mass of the smallest fragments on.
    first = max(int(np.flatnonzero(mean == mean.max()).max()) - 1, 0)
    axes.set(xscale="log", yscale="log", xlim=(mass[first], 1.2 * mass[-1]), ylim=(least, 2 * max(row.max() for row in samples)))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.set_xlabel(unit.label("mass"))
    axes.set_ylabel("fragments of at least this mass")
    axes.grid(color=style.BODY, linewidth=0.6)
    axes.set_axisbelow(True)
