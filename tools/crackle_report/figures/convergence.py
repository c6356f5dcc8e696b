# SPDX-License-Identifier: GPL-3.0-or-later
"""The mean crack position over the number of samples."""
from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from .. import style
from ..confidence import running_half_width
from ..results import Ensemble
from .picture import Picture, Section


def section(ensemble: Ensemble) -> Section:
    result = Section(
        "Convergence of the mean crack position",
        "Running mean over the samples in order of their number, with its "
        f"{100 * ensemble.confidence:g} % confidence band; one row for each notch, one column for each "
        "section. All panels span the same length. " + _verdict(ensemble))
    if ensemble.n_notches and ensemble.sections.size and len(ensemble.samples):
        result.pictures.append(Picture(
            "convergence", "Running mean of the crack position with its confidence band", _draw(ensemble)))
    return result


def _verdict(ensemble: Ensemble) -> str:
    half_width = ensemble.statistics.z_half_width
    if not np.isfinite(half_width).any():
        return "No section has been reached by two samples yet."
    notch, position = np.unravel_index(np.nanargmax(half_width), half_width.shape)
    return (f"The widest interval is now ±{half_width[notch, position] / style.MILLIMETRE:.2g} mm, of notch "
            f"{notch} at y = {ensemble.sections[position] / style.MILLIMETRE:g} mm, where "
            f"{ensemble.statistics.reached[notch, position]} samples arrived.")


def _draw(ensemble: Ensemble) -> Figure:
    n_rows, n_columns = ensemble.n_notches, ensemble.sections.size
    n_samples = len(ensemble.samples)
    number = np.arange(1, n_samples + 1)
    mean = ensemble.statistics.running_mean / style.MILLIMETRE
    band = np.stack([running_half_width(column, ensemble.confidence) for column in
                     ensemble.samples.z.reshape(n_samples, -1).T], axis=1).reshape(mean.shape)
    band /= style.MILLIMETRE
    span = _span(mean, band, ensemble.statistics.z_std / style.MILLIMETRE)

    figure = Figure(figsize=(style.PAGE_WIDTH, 0.5 + 1.75 * n_rows), layout="constrained")
    grid = figure.subplots(n_rows, n_columns, squeeze=False, sharex=True)
    for notch in range(n_rows):
        for column in range(n_columns):
            axes = grid[notch, column]
            colour = style.notch_colour(notch)
            line, half = mean[:, notch, column], band[:, notch, column]
            axes.plot(number, line, color=colour, linewidth=1.2, marker="." if n_samples < 30 else None)
            axes.fill_between(number, line - half, line + half, where=np.isfinite(half), color=colour,
                              alpha=0.25, linewidth=0)
            axes.set_title(f"notch {notch}, y = {ensemble.sections[column] / style.MILLIMETRE:g} mm",
                           fontsize=7)
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
                axes.text(0.5, 0.5, "not reached", transform=axes.transAxes, ha="center", color=style.MUTED)
            if column == 0:
                axes.set_ylabel("mean z [mm]")
            if notch == n_rows - 1:
                axes.set_xlabel("samples")
    return figure


def _span(mean: np.ndarray, band: np.ndarray, std: np.ndarray) -> float:
    """A common length of all vertical axes [mm]: holds every band but that of the first few samples."""
    n_samples = len(mean)
    last = np.array([column[np.isfinite(column)][-1] if np.isfinite(column).any() else np.nan
                     for column in mean.reshape(n_samples, -1).T]).reshape(mean.shape[1:])
    reach = np.abs(mean - last) + np.where(np.isfinite(band), band, 0.0)
    late = reach[min(n_samples // 2, max(5, n_samples // 10)):]
    # With two or three values Student's band is many times the spread of the values themselves.
    lengths = [factor * float(np.nanmax(values)) for factor, values in ((2.2, late), (6.0, std))
               if np.isfinite(values).any()]
    return max(min(lengths, default=0.0), 0.1)
