# SPDX-License-Identifier: GPL-3.0-or-later
"""How often the patterns occur, and at which load the cracks run."""
from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from crackle.units import NEWTON, fitting

from .. import style
from ..options import Options
from ..results import Ensemble
from .picture import Picture, Section


def section(ensemble: Ensemble, _: Options) -> Section:
    onset = "The onset is the load at the start of the last dynamic phase; a tick for each sample."
    if not ensemble.n_notches:
        figure = Figure(figsize=(style.PAGE_WIDTH * 0.5, 2.9), layout="constrained")
        _onset(figure.subplots(), ensemble)
        return Section("Onset", onset, pictures=[Picture("shares", "Histogram of the onset force", figure)] if ensemble.done.size else [])
    result = Section(
        "Patterns and onset",
        "Shares of the samples done, with Wilson's "
        f"{100 * ensemble.confidence:g} % intervals. {_meaning(ensemble)} {onset}")
    if ensemble.done.size:
        figure = Figure(figsize=(style.PAGE_WIDTH, 2.9), layout="constrained")
        left, right = figure.subplots(1, 2)
        _patterns(left, ensemble)
        _onset(right, ensemble)
        result.pictures.append(Picture("shares", "Shares of the patterns and histogram of the onset force", figure))
    return result


def _meaning(ensemble: Ensemble) -> str:
    """Of the patterns, for this body."""
    if ensemble.n_notches == 1:
        return "One crack: the notch's crack crosses most of its ligament."
    if (ensemble.plate.notch_axis == 0).any():
        return "One crack: a crack from one place crosses most of the body, and no other does. Two cracks: two do."
    return ("One crack: one notch's crack crosses most of its ligament, the other's does not. Two cracks: both do, and the "
            "one path overlaps with the other turned by 180 degrees.")


def _patterns(axes: Axes, ensemble: Ensemble) -> None:
    done = ensemble.done
    names = [*style.PATTERN_NAMES[1:], style.PATTERN_NAMES[0], "with branching"]
    colours = [*(style.PATTERN_COLOURS[p] for p in (1, 2, 3, 0)), style.MUTED]
    shares = [*(ensemble.statistics.pattern(p) for p in (1, 2, 3, 0)), ensemble.samples.result("bifurcations_projected").any]
    for row, (found, colour) in enumerate(zip(shares, colours)):
        share, low, high = (100 * value for value in (found.share, found.lower, found.upper))
        count = round(found.share * done.size)
        axes.barh(row, share, height=0.62, color=colour)
        axes.errorbar(share, row, xerr=[[max(share - low, 0)], [max(high - share, 0)]], color="black",
                      linewidth=0.9, capsize=3)
        axes.text(high + 1.5, row, f"{count} of {done.size}", va="center", fontsize=7)
    axes.set_yticks(range(len(names)), names)
    axes.axhline(3.5, color=style.MUTED, linewidth=0.5)  # below it what any pattern can have
    axes.invert_yaxis()
    axes.set_xlim(0, 118)
    axes.set_xticks(range(0, 101, 20))
    axes.set_xlabel("share of the samples [%]")
    axes.tick_params(axis="y", length=0)


def _onset(axes: Axes, ensemble: Ensemble) -> None:
    name, force = ensemble.breaking_load()
    pattern = ensemble.samples.pattern[ensemble.done][np.isfinite(force)]
    if not ensemble.n_notches:
        pattern = np.full_like(pattern, 3)  # all alike
    force = force[np.isfinite(force)]
    forces = fitting(force, NEWTON)
    force = forces.of(force)
    axes.set_xlabel(forces.label(name))
    axes.set_ylabel("samples")
    axes.yaxis.set_major_locator(MaxNLocator(5, integer=True))
    if force.size == 0:
        axes.text(0.5, 0.5, "no sample broke", transform=axes.transAxes, ha="center", color=style.MUTED)
        return
    least, most = float(force.min()), float(force.max())
    # At round numbers; about the square root of the number of values, at least five bins.
    edges = MaxNLocator(max(5, int(np.sqrt(force.size))), steps=[1, 2, 2.5, 5, 10]).tick_values(least, most if most > least else least + 1)
    kinds = [p for p in (1, 2, 3, 0) if (pattern == p).any()]
    axes.hist([force[pattern == p] for p in kinds], edges, stacked=True, edgecolor="white", linewidth=0.5,
              color=[style.PATTERN_COLOURS[p] for p in kinds], label=[style.PATTERN_NAMES[p] if ensemble.n_notches else "samples" for p in kinds])
    axes.plot(force, np.full(force.size, -0.025), "|", color="black", markersize=4, markeredgewidth=0.5,
              transform=axes.get_xaxis_transform(), clip_on=False, zorder=5)
    axes.axvline(float(np.median(force)), color="black", linewidth=0.9, linestyle="--",
                 label=f"median {np.median(force):.1f} {forces.name}")
    axes.tick_params(axis="x", pad=6)
    axes.legend(loc="lower right", ncol=len(kinds) + 1, bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
