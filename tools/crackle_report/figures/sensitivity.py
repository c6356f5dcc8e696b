# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensitivity to the random inputs and to the mesh: the numbers of `crackle stats`."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np
from crackle.files import DONE
from matplotlib.figure import Figure

from .. import style
from ..drawing import show_units
from ..options import Options
from ..results import Ensemble
from .picture import Picture, Section

N_SCATTERED = 4  # results in scatter plots
ROW_HEIGHT = 0.21  # [inch]
MESH, REST = style.MUTED, style.BODY
BOUNDS = " Triangles: samples that bore all that was applied, so that their load lies higher."


def section(ensemble: Ensemble, _: Options) -> Optional[Section]:
    """Nothing without random inputs, or with too few draws of them."""
    found = ensemble.sensitivities
    if not found or not found["results"]:
        return None
    rows = _rows(found["results"], ensemble)
    result = Section("Sensitivity to the random inputs",
                     f"Shares of each result's variance, from {found['n_draws']} draws and {found['n_samples']} samples: Sobol' indices of first "
                     "order of the random inputs, by a polynomial chaos expansion"
                     + (", and differences between samples with the same draw on different meshes" if found["replicates"] > 1 else "")
                     + ". The rest is due to interactions of the inputs, or not explained. crackle stats prints intervals and rank correlations."
                     + _fewer(rows, found["n_draws"]) + (BOUNDS if any(one["n_bounds"] for one in rows) else "")
                     + (f" T{found['failures'][1:]}." if found["failures"] else ""))
    result.answer = _answer(rows, ensemble)
    result.pictures = [Picture("sensitivities", "Shares of the variance of results that random inputs and the mesh explain", _bars(rows, ensemble)),
                       Picture("random-inputs", "Results over the values of the random inputs", _scatter(rows, ensemble))]
    return result


def _fewer(rows: list[dict[str, Any]], n_draws: int) -> str:
    """Which results not all draws have."""
    fewer = [f"{one['label']} ({one['n_draws']})" for one in rows if one["n_draws"] < n_draws]
    return f" Of fewer draws, as of those that broke: {', '.join(dict.fromkeys(fewer))}." if fewer else ""


def _rows(results: list[dict[str, Any]], ensemble: Ensemble) -> list[dict[str, Any]]:
    """The results that are shown: of two that say the opposite ("one crack", "two cracks") the second; then positions at the middle section."""
    groups = [[one for one in results if one["result"] == result.name] for result in ensemble.samples.results if result.explained]
    shown = [one for group in groups for one in (group[1:] if len(group) == 2 and group[0]["share_of"] else group)]
    middle = len(ensemble.sections) // 2
    return shown + [one for one in results if one.get("section") == middle]


def _label(one: dict[str, Any], ensemble: Ensemble) -> str:
    if "section" in one:
        return f"path of {ensemble.plate.name_of(one['notch'])}, {ensemble.sections[one['section']].name}"
    return f"{one['label']}: {one['share_of']}" if one["share_of"] else one["label"]


def _value(estimate: dict[str, Any]) -> float:
    return 0.0 if estimate["value"] is None else max(0.0, estimate["value"])


def _parts(one: dict[str, Any], keys: list[str]) -> list[tuple[str, float]]:
    """Of the variance: of each input alone, of the mesh."""
    return [(key, _value(effect["first"])) for key, effect in zip(keys, one["inputs"])] + [("the mesh", _value(one["mesh"]))]


def _answer(rows: list[dict[str, Any]], ensemble: Ensemble) -> str:
    keys = [one["key"] for one in ensemble.inputs]
    ruled: dict[str, list[str]] = {}
    for one in rows:
        name, share = max(_parts(one, keys), key=lambda part: part[1])
        if share >= 0.3:
            ruled.setdefault(name, []).append(f"{_label(one, ensemble)} ({100 * share:.0f} %)")
    return " ".join(f"{name[0].upper() + name[1:] if name == 'the mesh' else name} rules {', '.join(results)}." for name, results in ruled.items())


def _bars(rows: list[dict[str, Any]], ensemble: Ensemble) -> Figure:
    keys = [one["key"] for one in ensemble.inputs]
    figure = Figure(figsize=(style.PAGE_WIDTH, len(rows) * ROW_HEIGHT + 1.0))
    axes = figure.add_axes((0.26, 0.55 / figure.get_figheight(), 0.7, 1 - 1.0 / figure.get_figheight()))
    colours = [style.notch_colour(k) for k in range(len(keys))] + [MESH]
    for place, one in enumerate(rows):
        parts = _parts(one, keys)
        # Estimates of parts may add up to more than the whole.
        scale = 100 / max(1.0, sum(share for _, share in parts))
        left = 0.0
        axes.barh(place, 100, color=REST, height=0.72)
        for (_, share), colour in zip(parts, colours):
            axes.barh(place, scale * share, left=left, color=colour, height=0.72)
            left += scale * share
    for name, colour in zip([*keys, "the mesh", "interactions, or not explained"], [*colours, REST]):
        axes.bar(0, 0, color=colour, label=name)
    axes.set_yticks(range(len(rows)), [_label(one, ensemble) for one in rows])
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_xlim(0, 100)
    axes.set_xlabel("share of the variance [%]", labelpad=1)
    axes.tick_params(axis="y", length=0)
    axes.legend(loc="lower left", bbox_to_anchor=(-0.3, 1.0), ncols=3)
    return figure


def _scatter(rows: list[dict[str, Any]], ensemble: Ensemble) -> Figure:
    samples = ensemble.samples
    numbers = [one for one in rows if not one["share_of"] and one["result"] in samples.numbers]
    chosen = sorted(numbers, key=lambda one: -(one["predicted"] or 0))[:N_SCATTERED]
    n_inputs = len(ensemble.inputs)
    figure = Figure(figsize=(style.PAGE_WIDTH, 1.6 * len(chosen) + 0.5), layout="constrained")
    grid = figure.subplots(len(chosen), n_inputs, sharex="col", sharey="row", squeeze=False)
    done = samples.status == DONE
    for row, one in enumerate(chosen):
        result = samples.result(one["result"])
        value, is_open = result.factor * samples.numbers[result.name], done & samples.is_open(result)
        is_known = done & ~is_open
        for column, (given, effect) in enumerate(zip(ensemble.inputs, one["inputs"])):
            axes = grid[row, column]
            drawn = np.array(given["values"][:len(samples)], float)
            colour = style.notch_colour(column)
            axes.plot(drawn[is_known], value[is_known], ".", color=colour, markersize=3)
            if one["n_bounds"]:
                axes.plot(drawn[is_open], result.factor * samples.peak_load[is_open], "^", color=colour, markersize=3, markerfacecolor="none",
                          markeredgewidth=0.5)
            axes.set_title(f"total index {100 * _value(effect['total']):.0f} %, rank correlation {effect['rank_correlation']['value'] or 0:+.2f}",
                           fontsize=6, pad=2)
            show_units(axes.xaxis, given["units"])
            if row == len(chosen) - 1:
                axes.set_xlabel(given["key"])
        grid[row, 0].set_ylabel(f"{result.label} [{result.units}]" if result.units else result.label)
    return figure
