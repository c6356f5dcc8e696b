# SPDX-License-Identifier: GPL-3.0-or-later
"""Measured loads and those of samples: empirical distributions, and Weibull's."""
from __future__ import annotations

from typing import Any, Iterator

import numpy as np
from crackle import weibull
from crackle.inference import Censored
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
        groups = [("samples", SAMPLES, _observed(found["samples"]["loads"], "is_unbroken", name)),
                  ("experiments", EXPERIMENTS, _observed([one["observed"] for one in found["experiments"]], "run_out", name))]
        if all((~values.is_bound).any() for *_, values in groups):
            what = name.replace("_", " ")
            yield Picture(f"experiments-{what.replace(' ', '-')}", f"Distributions of the {what} in experiments and samples",
                          _figure(what, groups))


def _observed(rows: list[dict[str, Any]], did_not_break: str, name: str) -> Censored:
    """A load in ascending order; what did not break bore its peak load."""
    found = [(one["peak_load" if is_bound else name], is_bound) for one in rows for is_bound in [bool(one.get(did_not_break))]]
    value, is_bound = np.array(sorted(one for one in found if one[0] is not None), float).reshape(-1, 2).T
    return Censored(value, is_bound == 1, np.arange(value.size))


def _figure(what: str, groups: list[tuple[str, str, Censored]]) -> Figure:
    figure = Figure(figsize=(style.PAGE_WIDTH, 3.5), layout="constrained")
    empirical, straight = figure.subplots(1, 2)
    unit = fitting(np.concatenate([values.value for *_, values in groups]), NEWTON, least=10)
    groups = [(title, colour, Censored(unit.of(values.value), values.is_bound, values.group)) for title, colour, values in groups]
    for title, colour, values in groups:
        n = values.value.size
        more = f", {values.is_bound.sum()} bore more" if values.is_bound.any() else ""
        _empirical(empirical, values, f"{n} {title if n > 1 else title[:-1]}{more}", colour)
        _weibull(straight, values, title, colour)
    for axes in (empirical, straight):
        axes.set_xlabel(unit.label(what))
    empirical.set_ylabel("share that bears no more")
    empirical.set_ylim(0, 1.02)
    draw_grid(empirical)
    empirical.legend(loc="lower right")
    straight.set_xscale("log")
    together = np.concatenate([values.value[values.value > 0] for *_, values in groups])
    if together.size and np.ptp(together) > 0:
        low, high = together.min(), together.max()
        straight.set_xlim(low * (low / high) ** 0.3, high * (high / low) ** 0.2)
    if np.divide(*straight.get_xlim()[::-1]) < 5:
        straight.xaxis.set_major_locator(MaxNLocator(6))
    straight.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    straight.minorticks_off()
    straight.set_yticks(_height(TICKS), [f"{100 * tick:.0f}" for tick in TICKS])
    straight.set_ylim(*_height(np.array([min(0.05, *(0.3 / values.value.size for *_, values in groups)), 0.995])))
    straight.set_ylabel("broken [%], Weibull's scale")
    straight.grid(color=style.BODY, linewidth=0.6)
    straight.set_axisbelow(True)
    straight.legend(loc="upper left", title=f"Weibull's modulus of the {what}")
    return figure


def _height(probability: np.ndarray) -> np.ndarray:
    """On the axis that makes Weibull's distribution a straight line over the logarithm."""
    return np.log(-np.log1p(-probability))


def _empirical(axes: Axes, values: Censored, label: str, colour: str) -> None:
    """By Kaplan and Meier, with the band of Dvoretzky, Kiefer, Wolfowitz and Massart up to the least bound."""
    known = values.value[~values.is_bound]
    step, ends = np.r_[0, values.shares_below[1]], np.r_[known[0], known]
    axes.step(np.r_[ends, values.value.max()], np.r_[step, step[-1]], where="post", color=colour, linewidth=1.3, label=label)
    n = values.value.size
    if n < 2:
        return
    half = np.sqrt(np.log(2 / (1 - CONFIDENCE)) / (2 * n))
    sure = ends <= values.value[values.is_bound].min(initial=np.inf)
    low, high = np.clip([step[sure] - half, step[sure] + half], 0, 1)
    axes.fill_between(ends[sure], low, high, step="post", color=colour, alpha=0.15, linewidth=0)


def _weibull(axes: Axes, values: Censored, title: str, colour: str) -> None:
    """Values in the middle of their steps, at (i - 1/2) / n without bounds and, where there are enough, the fit: with the band of its
    quantiles if there are no bounds."""
    known = values.value[~values.is_bound]
    if values.value.size == 1:
        axes.axvline(known[0], color=colour, linewidth=1.3, label=title[:-1])
        return
    middle = np.mean(values.shares_below, axis=0)
    axes.plot(known[known > 0], _height(middle[known > 0]), "o", color=colour, markersize=3)
    height = np.linspace(*_height(ENDS), 80)
    if values.is_bound.any():
        found = weibull.modulus_and_scale(values.value, ~values.is_bound, CONFIDENCE)
        if found is None:
            return
        modulus = found["modulus"]
        quantile = found["scale"]["value"] * np.exp(height / modulus["value"])
    else:
        exact = weibull.fit(values.value, 1 - np.exp(-np.exp(height)), CONFIDENCE)
        if exact is None:
            return
        modulus, quantile = {"value": exact.modulus, "lower": exact.lower, "upper": exact.upper}, exact.quantile
        axes.fill_betweenx(height, exact.quantile_lower, exact.quantile_upper, color=colour, alpha=0.15, linewidth=0)
    axes.plot(quantile, height, color=colour, linewidth=1.2,
              label=f"{title}: {modulus['value']:.3g} ({modulus['lower']:.3g} to {modulus['upper']:.3g})")
