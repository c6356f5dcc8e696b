# SPDX-License-Identifier: GPL-3.0-or-later
"""The mean crack position over the number of samples."""
from __future__ import annotations

import textwrap

import numpy as np
from crackle.files import DONE
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from .. import style
from ..options import Options
from ..results import Ensemble, along
from .picture import Picture, Section

LEAST_SPAN = 0.004  # of the vertical axes, over the body's width


def section(ensemble: Ensemble, _: Options) -> Section | None:
    if not ensemble.n_notches:
        return None
    together = f" (of all {ensemble.n_looks} looks together at which the ensemble could stop)" if ensemble.n_looks > 1 else ""
    result = Section(
        "Convergence of the mean crack position",
        "Running mean of the leading cracks over the samples in order of their number, with its "
        f"{100 * ensemble.confidence:g} % confidence band{together}; one column for each section. Samples "
        "that another notch leads are turned by the body's symmetry where it has one; otherwise there is one row for "
        f"each leading notch. All panels span the same length.", _verdict(ensemble))
    if ensemble.sections and len(ensemble.samples):
        result.pictures.append(Picture(
            "convergence", "Running mean of the leading crack's position with its confidence band", _draw(ensemble)))
    return result


def _verdict(ensemble: Ensemble) -> str:
    """Were the samples enough? In one sentence."""
    precision, n_done = ensemble.precision, ensemble.done.size
    # Where hardly any leading crack comes, no number of samples is enough, and the mean says little.
    if "half_width" not in precision:
        return "Too few samples have reached any section to tell whether there are enough."
    reason = "as the input asks for" if precision["is_of_the_input"] else "1 % of the width"
    lengths = ensemble.plate.lengths
    half_width, target = precision["half_width"], precision["half_width_wanted"]
    if half_width is None:
        return (f"Were {n_done} samples enough? No: all that have reached {ensemble.sections[precision['section']].name} have one draw of the "
                "random inputs, whose mean has no interval.")
    known = (f"the mean position of the leading crack is known to ±{lengths.of(half_width):.2g} {lengths.name} at its least "
             f"certain section ({_of_class(ensemble, precision['row'])}{ensemble.sections[precision['section']].name}{_of_group(ensemble)})")
    wanted = f"±{lengths.of(target):.2g} {lengths.name} ({reason})"
    if half_width <= target:
        return f"Were {n_done} samples enough? Yes: {known}, and {wanted} was wanted."
    return (f"Were {n_done} samples enough? No: {known}; {wanted} would take about "
            f"{float(f'''{precision['n_samples_needed']:.2g}'''):.0f} samples with the scatter seen so far.")


def _of_class(ensemble: Ensemble, row: int) -> str:
    """Which leaders a row is of, where there are several."""
    leading = ensemble.ranks["leader"].leading_notch
    return f"{ensemble.plate.name_of(leading[row])} leads, " if len(leading) > 1 else ""


def _of_group(ensemble: Ensemble) -> str:
    """Of which group the mean is, where the leading cracks take several paths; smaller groups have no say."""
    if "group" not in ensemble.precision:
        return ""
    group = ensemble.ranks["leader"].groups[ensemble.precision["group"]]
    return f", of the {group.n} of {group.n_of} samples that take one path"


def _draw(ensemble: Ensemble) -> Figure:
    leaders = ensemble.ranks["leader"]
    rows, n_columns = ensemble.rows_shown("leader") or [0], len(ensemble.sections)
    n_samples = len(ensemble.samples)
    done = np.flatnonzero(ensemble.samples.status == DONE)
    last = done[-1] + 1 if done.size else 0
    number = np.arange(1, n_samples + 1)
    lengths = ensemble.plate.lengths
    apart = leaders.is_divided.astype(bool)
    mean, band, deviation = (lengths.of(np.where(apart, np.nan, values)) for values in
                             (leaders.running_mean, leaders.running_half_width, leaders.z_std))
    span = _span(mean, band, deviation, lengths.of(LEAST_SPAN * ensemble.plate.size[1]))

    figure = Figure(figsize=(style.PAGE_WIDTH, 0.75 + 1.75 * len(rows)), layout="constrained")
    grid = figure.subplots(len(rows), n_columns, squeeze=False, sharex=True)
    for place, row in enumerate(rows):
        for column in range(n_columns):
            axes = grid[place, column]
            colour = style.notch_colour(int(leaders.notch[row]))
            line, half = mean[:last, row, column], band[:last, row, column]
            axes.plot(number[:last], line, color=colour, linewidth=1.2, marker="." if n_samples < 30 else None)
            axes.fill_between(number[:last], line - half, line + half, where=np.isfinite(half), color=colour,
                              alpha=0.25, linewidth=0)
            title = _of_class(ensemble, row) + ensemble.sections[column].name
            axes.set_title(textwrap.fill(title, max(24, 108 // n_columns)), fontsize=7)
            axes.set_xlim(1, max(n_samples, 2))
            axes.xaxis.set_major_locator(MaxNLocator(4, integer=True))
            axes.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
            axes.grid(color=style.BODY, linewidth=0.6)
            axes.set_axisbelow(True)
            if np.isfinite(line).any():
                centre = line[np.isfinite(line)][-1]
                axes.set_ylim(centre - span / 2, centre + span / 2)
            else:
                axes.set_yticks([])
                axes.text(0.5, 0.5, "several paths" if apart[row, column] else "not reached", transform=axes.transAxes, ha="center", color=style.MUTED)
            if column == 0:
                axes.set_ylabel(lengths.label(f"mean {along(ensemble.sections)}"))
            if row == rows[-1]:
                axes.set_xlabel("samples")
    figure.legend(handles=[Line2D([], [], color=style.MUTED, linewidth=1.2, label="mean over the first samples"),
                           Patch(color=style.MUTED, alpha=0.25, linewidth=0, label=f"{100 * ensemble.confidence:g} % interval")],
                  loc="upper right", ncols=2, fontsize="small", frameon=False)
    figure.get_layout_engine().set(rect=(0, 0, 1, 1 - 0.25 / figure.get_figheight()))  # below the legend
    return figure


def _span(mean: np.ndarray, band: np.ndarray, std: np.ndarray, least: float) -> float:
    """A common length of all vertical axes, in their unit: holds every band but that of the first few samples."""
    n_samples = len(mean)
    last = np.array([column[np.isfinite(column)][-1] if np.isfinite(column).any() else np.nan
                     for column in mean.reshape(n_samples, -1).T]).reshape(mean.shape[1:])
    reach = np.abs(mean - last) + np.where(np.isfinite(band), band, 0.0)
    late = reach[min(n_samples // 2, max(5, n_samples // 10)):]
    # With two or three values Student's band is many times the spread of the values themselves.
    lengths = [factor * float(np.nanmax(values)) for factor, values in ((2.2, late), (6.0, std))
               if np.isfinite(values).any()]
    return max(min(lengths, default=0.0), least)
