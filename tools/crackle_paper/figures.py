# SPDX-License-Identifier: GPL-3.0-or-later
"""The studies' pictures."""
from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from crackle_report import style
from crackle_report.statistics import wilson_interval

from .comparing import leading_path, reach
from .fringes import FringeSeries
from .rows import Rows
from .studies import TARGET_LOAD
from .tables import counts, median_curve


def onset_against_depth(all_rows: list[Rows]) -> Figure:
    """Every sample's onset over the notches' depth, for each distance; with the medians' curve where it fits."""
    by_distance: dict[str, list[Rows]] = {}
    for rows in all_rows:
        by_distance.setdefault(rows.label.split(", ")[1], []).append(rows)
    figure = Figure(figsize=(style.PAGE_WIDTH, 3.6), layout="constrained")
    axes = figure.subplots()
    for number, (distance, group) in enumerate(by_distance.items()):
        colour = style.notch_colour(number)
        for rows in group:
            depth = float(rows.label.split(" ")[0])
            axes.plot(np.full(len(rows), depth + 0.03 * (number - 2)), rows.values["onset_force"], ".", color=colour,
                      markersize=4, alpha=0.6, label=f"distance {distance}" if rows is group[0] else None)
        if len(group) > 3:
            depths = [float(rows.label.split(" ")[0]) for rows in group]
            curve, depth = median_curve(group)
            x = np.linspace(min(depths), max(depths), 100)
            axes.plot(x, np.polyval(curve, x), color=colour, linewidth=1)
            axes.plot([depth], [TARGET_LOAD], "o", color=colour, markersize=6, fillstyle="none",
                      label=f"{TARGET_LOAD:.1f} N at {depth:.2f} mm")
    axes.axhline(TARGET_LOAD, color=style.MUTED, linewidth=0.8, linestyle="--")
    axes.set_xlabel("depth of both notches [mm]")
    axes.set_ylabel("load at onset [N]")
    axes.legend()
    return figure


def shares_and_paths(all_rows: list[Rows], early: bool) -> Figure:
    """Shares as in tables.shares, with Wilson's intervals, and the leading cracks' paths, setting by setting."""
    figure = Figure(figsize=(style.PAGE_WIDTH, 4.6), layout="constrained")
    grid = figure.add_gridspec(2, len(all_rows), height_ratios=[1, 1.3])
    axes = figure.add_subplot(grid[0, :])
    width = 0.25
    for number, rows in enumerate(all_rows):
        for bar, (pattern, count) in enumerate(zip((1, 2, 3), counts(rows, early))):
            low, high = wilson_interval(count, len(rows), 0.95)
            share = count / len(rows)
            axes.bar(number + (bar - 1) * width, 100 * share, width * 0.9, color=style.PATTERN_COLOURS[pattern],
                     label=style.pattern_name(pattern) if number == 0 else None)
            axes.errorbar(number + (bar - 1) * width, 100 * share, color="black", linewidth=0.9, capsize=2,
                          yerr=[[max(0, 100 * (share - low))], [max(0, 100 * (high - share))]])
    axes.set_xticks(range(len(all_rows)), [f"{rows.label} ({len(rows)})" for rows in all_rows])
    axes.set_ylabel("share of the samples [%]")
    axes.set_ylim(0, 105)
    axes.legend()
    first = None
    for number, rows in enumerate(all_rows):
        axes = figure.add_subplot(grid[1, number], sharey=first, sharex=first)
        first = first or axes
        axes.plot([7, 9, 12.25, 15.5, 17.5], 1e3 * leading_path(rows).T, color=style.notch_colour(0), linewidth=0.5,
                  alpha=0.5)
        axes.set_xlabel("y from the leading notch's side [mm]")
        if number == 0:
            axes.set_ylabel("z of the leading crack [mm]")
    return figure


def second_crack(rows: Rows) -> Figure:
    """How far the second crack of each sample runs, by the pattern that the sample counts as."""
    figure = Figure(figsize=(style.PAGE_WIDTH / 2, 2.6), layout="constrained")
    axes = figure.subplots()
    edges = np.arange(0, 1.0001, 0.04)
    second = reach(rows)[1]
    kinds = [pattern for pattern in range(4) if rows.share(pattern)]
    axes.hist([second[rows.values["pattern"] == pattern] for pattern in kinds], edges, stacked=True,
              color=[style.PATTERN_COLOURS[pattern] for pattern in kinds], label=[style.pattern_name(p) for p in kinds])
    axes.set_xlabel("share of its ligament that the second crack crosses")
    axes.set_ylabel("samples")
    axes.legend()
    return figure


def fringes(series: list[FringeSeries]) -> Figure:
    """Roughness of each sample's fringe order, and its likeness to the others' mean, over time."""
    figure = Figure(figsize=(style.PAGE_WIDTH, 2.8), layout="constrained")
    for axes, name, label in zip(figure.subplots(1, 2), ("roughness", "likeness"),
                                 ("roughness of the fringe order away from cracks", "correlation with the others' mean")):
        curves = np.array([getattr(one, name) for one in series])
        time = 1e6 * series[0].time
        axes.plot(time, curves.T, color=style.notch_colour(0), linewidth=0.5, alpha=0.35)
        axes.plot(time, np.median(curves, axis=0), color="black", linewidth=1.5, label=f"median of {len(series)} samples")
        axes.set_xlabel("time since onset [µs]")
        axes.set_ylabel(label)
        axes.set_ylim(bottom=min(0, curves.min()))
        axes.legend()
    return figure
