# SPDX-License-Identifier: GPL-3.0-or-later
"""Measured loads and those of samples: empirical distributions, and Weibull's."""
from __future__ import annotations

from typing import Any, Iterator

import numpy as np
from crackle import weibull
from crackle.units import NEWTON, fitting
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from .. import style
from ..drawing import draw_grid
from .picture import Picture

CONFIDENCE = 0.95
ENDS = np.array([0.002, 0.998])  # of the lines
TICKS = np.array([0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 0.8, 0.95, 0.99])
SAMPLES, EXPERIMENTS = style.NOTCH_COLOURS[:2]


def pictures(found: dict[str, Any]) -> Iterator[Picture]:
    """One for each load that was measured. @param found: the document of `crackle match`"""
    for name in ("onset_load", "peak_load"):
        groups = [("samples", SAMPLES, [one[name] for one in found["samples"]["loads"] if not one.get("is_unbroken")]),
                  ("experiments", EXPERIMENTS, [one["observed"][name] for one in found["experiments"] if not one["observed"].get("run_out")])]
        groups = [(title, colour, np.sort([value for value in values if value is not None])) for title, colour, values in groups]
        if all(values.size for *_, values in groups):
            what = name.replace("_", " ")
            yield Picture(f"experiments-{what.replace(' ', '-')}", f"Distributions of the {what} in experiments and samples",
                          _figure(what, groups))


def _figure(what: str, groups: list[tuple[str, str, np.ndarray]]) -> Figure:
    figure = Figure(figsize=(style.PAGE_WIDTH, 3.5), layout="constrained")
    empirical, straight = figure.subplots(1, 2)
    unit = fitting(np.concatenate([values for *_, values in groups]), NEWTON, least=10)
    for title, colour, values in groups:
        values = unit.of(values)
        _empirical(empirical, values, f"{values.size} {title if values.size > 1 else title[:-1]}", colour)
        _weibull(straight, values, title, colour)
    for axes in (empirical, straight):
        axes.set_xlabel(unit.label(what))
    empirical.set_ylabel("share that bears no more")
    empirical.set_ylim(0, 1.02)
    draw_grid(empirical)
    empirical.legend(loc="lower right")
    straight.set_xscale("log")
    together = unit.of(np.concatenate([values[values > 0] for *_, values in groups]))
    if together.size and np.ptp(together) > 0:
        low, high = together.min(), together.max()
        straight.set_xlim(low * (low / high) ** 0.3, high * (high / low) ** 0.2)
    if np.divide(*straight.get_xlim()[::-1]) < 5:
        straight.xaxis.set_major_locator(MaxNLocator(6))
    straight.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    straight.minorticks_off()
    straight.set_yticks(_height(TICKS), [f"{100 * tick:.0f}" for tick in TICKS])
    straight.set_ylim(*_height(np.array([min(0.05, *(0.3 / values.size for *_, values in groups)), 0.995])))
    straight.set_ylabel("broken [%], Weibull's scale")
    straight.grid(color=style.BODY, linewidth=0.6)
    straight.set_axisbelow(True)
    straight.legend(loc="upper left", title=f"Weibull's modulus of the {what}")
    return figure


def _height(probability: np.ndarray) -> np.ndarray:
    """On the axis that makes Weibull's distribution a straight line over the logarithm."""
    return np.log(-np.log1p(-probability))


def _empirical(axes: Axes, values: np.ndarray, label: str, colour: str) -> None:
    """With the band of Dvoretzky, Kiefer, Wolfowitz and Massart."""
    n = values.size
    step = np.r_[0, np.arange(1, n + 1) / n]
    ends = np.r_[values[0], values]
    axes.step(ends, step, where="post", color=colour, linewidth=1.3, label=label)
    if n < 2:
        return
    half = np.sqrt(np.log(2 / (1 - CONFIDENCE)) / (2 * n))
    axes.fill_between(ends, np.clip(step - half, 0, 1), np.clip(step + half, 0, 1), step="post", color=colour, alpha=0.15, linewidth=0)


def _weibull(axes: Axes, values: np.ndarray, title: str, colour: str) -> None:
    """Values at (i - 1/2) / n and, where there are enough, the fit with the band of its quantiles."""
    if values.size == 1:
        axes.axvline(values[0], color=colour, linewidth=1.3, label=title[:-1])
        return
    positive = values[values > 0]
    axes.plot(positive, _height((np.arange(positive.size) + 0.5) / max(1, positive.size)), "o", color=colour, markersize=3)
    found = weibull.fit(values, 1 - np.exp(-np.exp(np.linspace(*_height(ENDS), 80))), CONFIDENCE)
    if found is None:
        return
    height = _height(found.probability)
    axes.plot(found.quantile, height, color=colour, linewidth=1.2,
              label=f"{title}: {found.modulus:.3g} ({found.lower:.3g} to {found.upper:.3g})")
    axes.fill_betweenx(height, found.quantile_lower, found.quantile_upper, color=colour, alpha=0.15, linewidth=0)
