# SPDX-License-Identifier: GPL-3.0-or-later
"""How often the patterns occur, and which load the samples held."""
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

ABOUT = {"onset_force": "The onset is the load at the start of the last dynamic phase.",
         "first_break_load": "The samples start from rest; the load is that at their first break.",
         "peak_load": "The peak load is the largest that a sample held: cracks had run and stopped before the last dynamic phase, so that its "
                      "onset says little."}
OUTLIER = 3.0  # times the interquartile range beyond the quartiles


def section(ensemble: Ensemble, _: Options) -> Section:
    load = ensemble.load.label
    text = f"{ABOUT[ensemble.headline]} There is a tick for each sample.{_unbroken(ensemble)}"
    title = load[0].upper() + load[1:]
    if not ensemble.n_notches:
        figure = Figure(figsize=(style.PAGE_WIDTH * 0.5, 2.9), layout="constrained")
        _loads(figure.subplots(), ensemble)
        return Section(title, text, pictures=[Picture("shares", f"Histogram of the {load}", figure)] if ensemble.done.size else [])
    result = Section(
        f"Patterns and {load}",
        "Shares of the samples done, with Wilson's "
        f"{100 * ensemble.confidence:g} % intervals. {_meaning(ensemble)} {text}")
    if ensemble.done.size:
        figure = Figure(figsize=(style.PAGE_WIDTH, 2.9), layout="constrained")
        left, right = figure.subplots(1, 2)
        _patterns(left, ensemble)
        _loads(right, ensemble)
        result.pictures.append(Picture("shares", f"Shares of the patterns and histogram of the {load}", figure))
    return result


def _unbroken(ensemble: Ensemble) -> str:
    n = ensemble.load.n_bounds
    return f" {n} of {ensemble.done.size} samples bore all that was applied and have none." if n else ""


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


def _bins(values: np.ndarray) -> np.ndarray:
    """Edges at round numbers; about the square root of the number of values, at least five. Values far from the middle half have no
    bin, so that they do not stretch the others'."""
    quarters = np.quantile(values, (0.25, 0.75))
    reach = np.array([-OUTLIER, OUTLIER]) * np.ptp(quarters)
    least, most = np.clip((values.min(), values.max()), *(quarters + reach))
    return MaxNLocator(max(5, int(np.sqrt(values.size))), steps=[1, 2, 2.5, 5, 10]).tick_values(least, most if most > least else least + 1)


def _loads(axes: Axes, ensemble: Ensemble) -> None:
    name, force = ensemble.load.label, ensemble.loads[ensemble.done]
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
    edges = _bins(force)
    outside = force[(force < edges[0]) | (force > edges[-1])]
    if outside.size:
        values = f"{outside[0]:.3g}" if outside.size == 1 else f"{outside.min():.3g} to {outside.max():.3g}"
        axes.annotate(f"not shown: {outside.size} of {force.size}, {values} {forces.name}", (0.01, 0.99), xycoords="axes fraction", va="top",
                      fontsize=7)
    kinds = [p for p in (1, 2, 3, 0) if (pattern == p).any()]
    axes.hist([force[pattern == p] for p in kinds], edges, stacked=True, edgecolor="white", linewidth=0.5,
              color=[style.PATTERN_COLOURS[p] for p in kinds], label=[style.PATTERN_NAMES[p] if ensemble.n_notches else "samples" for p in kinds])
    axes.set_xlim(edges[0], edges[-1])
    shown = force[(force >= edges[0]) & (force <= edges[-1])]
    axes.plot(shown, np.full(shown.size, -0.025), "|", color="black", markersize=4, markeredgewidth=0.5,
              transform=axes.get_xaxis_transform(), clip_on=False, zorder=5)
    median = forces.of(ensemble.load.quantiles[2]) if ensemble.load.quantiles else np.nan
    if np.isfinite(median):  # of all samples, unbroken ones included
        axes.axvline(median, color="black", linewidth=0.9, linestyle="--", label=f"median {median:.1f} {forces.name}")
    axes.tick_params(axis="x", pad=6)
    axes.legend(loc="lower right", ncol=len(kinds) + 1, bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
