# SPDX-License-Identifier: GPL-3.0-or-later
"""The studies' pictures."""
from __future__ import annotations

import textwrap

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from crackle_report import style

from .comparing import DEVELOPED, leading_path, mean_interval, reach, share_interval
from .course import FAR
from .fringes import FringeSeries
from .rows import SECTIONS, Rows
from .studies import TARGET_LOAD
from .tables import median_curve


def onset_against_depth(all_rows: list[Rows]) -> Figure:
    """Every sample's onset over the notches' depth, for each distance; with the medians' curve where it fits."""
    by_distance: dict[str, list[Rows]] = {}
    for rows in all_rows:
        by_distance.setdefault(rows.label.split(", ")[1], []).append(rows)
    figure = Figure(figsize=(style.PAGE_WIDTH, 3.6), layout="constrained")
    axes = figure.subplots()
    for number, (distance, group) in enumerate(by_distance.items()):
        colour = colormaps["viridis"](0.92 * number / max(1, len(by_distance) - 1))
        for rows in group:
            depth = float(rows.label.split(" ")[0])
            axes.plot(np.full(len(rows), depth + 0.02 * (number - 2)), rows.values["onset_force"], "osD^vP*"[number % 7], color=colour,
                      markersize=3, markeredgewidth=0, alpha=0.6, label=f"distance {distance}" if rows is group[0] else None)
        if len(group) > 3:
            depths = [float(rows.label.split(" ")[0]) for rows in group]
            curve, depth = median_curve(group)
            x = np.linspace(min(depths), max(depths), 100)
            axes.plot(x, np.polyval(curve, x), color=colour, linewidth=1)
            axes.plot([depth], [TARGET_LOAD], "o", color=colour, markersize=6, fillstyle="none",
                      label=f"{TARGET_LOAD:.1f} N at {depth:.2f} mm")
    axes.axhline(TARGET_LOAD, color=style.MUTED, linewidth=0.8, linestyle="--")
    axes.set_xlabel("depth of both notches [mm]; of each distance moved aside a little")
    axes.set_ylabel("load at onset [N]")
    axes.legend()
    return figure


def forks(all_rows: list[Rows]) -> Figure:
    """Setting by setting, the share of samples with forks in the projection, with its interval, and every crack's speed."""
    figure = Figure(figsize=(style.PAGE_WIDTH, 0.8 + 0.24 * len(all_rows)), layout="constrained")
    shares, speeds = figure.subplots(1, 2, sharey=True)
    for number, rows in enumerate(all_rows):
        forked = rows.forked
        low, high = share_interval(int(forked.sum()), len(rows))
        shares.plot([100 * low, 100 * high], [number, number], color="black", linewidth=0.9,
                    label="95 % interval" if number == 0 else None)
        shares.plot(100 * forked.mean(), number, "o", color=style.notch_colour(0), markersize=4, label="share" if number == 0 else None)
        for chosen, colour, label in ((~forked, style.MUTED, "without forks"), (forked, style.notch_colour(1), "with forks")):
            speeds.plot(rows.values["crack_speed_ratio"][chosen], np.full(int(chosen.sum()), number), ".", color=colour,
                        markersize=4, label=label if number == 0 else None)
    shares.set_yticks(range(len(all_rows)), [f"{rows.label} ({len(rows)})".replace("`", "") for rows in all_rows], fontsize="small")
    shares.invert_yaxis()
    shares.set_xlim(0, 100)
    shares.set_xlabel("samples with forks in the projection [%]")
    shares.set_ylabel("setting (samples)")
    shares.legend(fontsize="small")
    speeds.set_xlabel("largest crack speed / c_R")
    speeds.legend(fontsize="small")
    return figure


def reach_and_paths(settings: list[tuple[str, list[Rows]]], measure: str, title: str) -> Figure:
    """Setting by setting, how far the second crack runs in each sample, with mean and its interval, and the leading paths. Of
    several runs of a setting, each of a base of its own, the interval is that of their means.

    @param measure "reach": at the end; "other_when_far": when the first crack has crossed most of its ligament
    @param title what differs between the settings
    """
    figure = Figure(figsize=(style.PAGE_WIDTH, 4.6), layout="constrained")
    grid = figure.add_gridspec(2, len(settings), height_ratios=[1, 1.3])
    axes = figure.add_subplot(grid[0, :])
    for number, (_, several) in enumerate(settings):
        by_run = [reach(rows)[1] if measure == "reach" else rows.values[measure] for rows in several]
        by_run = [values[np.isfinite(values)] for values in by_run]
        values = np.concatenate(by_run)
        beside = np.linspace(-0.25, 0.25, len(values)) if len(values) > 1 else np.zeros(len(values))
        axes.plot(number + beside, values, ".", color=style.notch_colour(1), markersize=4, alpha=0.5)
        if len(values) > 1:
            mean, half_width = mean_interval(values if len(several) == 1 else np.array([one.mean() for one in by_run if len(one)]))
            axes.errorbar(number + 0.35, mean, half_width, fmt="o", color="black", markersize=3, linewidth=0.9, capsize=2)
    names = [textwrap.fill(f"{label} ({sum(map(len, several))})", 24) for label, several in settings]
    axes.set_xticks(range(len(settings)), names, fontsize="small")
    axes.set_ylabel("share of its ligament that\nthe second crack crosses" if measure == "reach" else
                    f"second crack's share when\nthe first has crossed {FAR:g}")
    axes.set_ylim(0, 1)
    axes.set_xlabel(f"{title} (samples)", fontsize="small")
    axes.legend(handles=[Line2D([], [], marker=".", linestyle="", color=style.notch_colour(1), alpha=0.5, label="a sample"),
                         Line2D([], [], marker="o", color="black", markersize=3, linewidth=0.9, label="mean, 95 % interval")],
                ncols=2, loc="upper right")
    first = None
    for number, (label, several) in enumerate(settings):
        axes = figure.add_subplot(grid[1, number], sharey=first, sharex=first)
        axes.set_title(textwrap.fill(label, 24), fontsize="small")
        for rows in several:
            axes.plot([float(y) for y in SECTIONS], 1e3 * leading_path(rows).T, color=style.notch_colour(0), linewidth=0.5, alpha=0.5)
        if first is None:
            axes.set_ylabel("z of the leading crack [mm]")
            first = axes
        else:
            axes.tick_params(labelleft=False)
    figure.supxlabel("y from the leading notch's side [mm]", fontsize="medium")
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
    axes.axvline(DEVELOPED, color=style.MUTED, linewidth=0.9, linestyle="--", label="limit of the program")
    axes.set_xlabel("share of its ligament that the second crack crosses")
    axes.set_ylabel("samples")
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend()
    return figure


def fringes(series: list[FringeSeries]) -> Figure:
    """Roughness of each sample's fringe order, and its likeness to the others' mean, over time."""
    figure = Figure(figsize=(style.PAGE_WIDTH, 2.8), layout="constrained")
    for axes, name, label in zip(figure.subplots(1, 2), ("roughness", "likeness"),
                                 ("roughness of the fringe order", "correlation with the others' mean")):
        curves = np.array([getattr(one, name) for one in series])
        time = 1e6 * series[0].time
        axes.plot(time, curves.T, color=style.notch_colour(0), linewidth=0.5, alpha=0.35)
        axes.plot(time, np.median(curves, axis=0), color="black", linewidth=1.5, label=f"median of {len(series)} samples")
        axes.set_xlabel("time since onset [µs]")
        axes.set_ylabel(label)
        axes.set_ylim(bottom=min(0, curves.min()))
        axes.legend()
    return figure
