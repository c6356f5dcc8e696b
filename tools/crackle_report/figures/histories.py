# SPDX-License-Identifier: GPL-3.0-or-later
"""Load over displacement or time, growth and speed of the cracks, and when they arrive at the sections."""
from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from crackle.curves import load_limits, while_held
from crackle.units import MM, NEWTON, US, Unit, fitting

from .. import style
from ..choosing import samples_in_detail
from ..drawing import draw_grid
from ..options import Options
from ..fields import History
from ..results import Ensemble
from .picture import Picture, Section

BAND = (10, 90)  # per cent of the samples
BAND_POINTS = 200
MOST_OVER = 2.5  # times the Rayleigh speed, up to which speeds are drawn
MIN_BAND = 4  # samples from which on a band is drawn


def section(ensemble: Ensemble, options: Options) -> Section | None:
    histories = {int(i): ensemble.files.history(int(i)) for i in ensemble.done}
    histories = {i: history for i, history in histories.items() if history is not None and history.governing_load.size > 1}
    if not histories:
        return None
    detailed = [i for i in options.samples or samples_in_detail(ensemble) if i in histories]
    result = Section("Load, cracks and time" if ensemble.n_notches else "Load and time", _explain(histories, ensemble.n_notches > 0))
    result.pictures.append(Picture("load", "Load of all samples over " + _abscissa(histories), _load(histories, detailed)))
    if ensemble.n_notches and any(history.in_last_phase.any() for history in histories.values()):
        result.pictures.append(Picture("crack-speed", "Crack length and tip speed over time",
                                       _growth(ensemble, histories, detailed)))
    if np.isfinite(ensemble.samples.arrival[ensemble.done]).any():
        n_before = int((ensemble.samples.arrival[ensemble.done] <= _earliest(ensemble)).sum())
        left_out = f"; without {n_before} arrivals before the last dynamic phase, whose times are negative" if n_before else ""
        result.pictures.append(Picture("arrival", f"When the cracks arrive at the sections{left_out}", _arrivals(ensemble)))
    return result


def _explain(histories: dict[int, History], has_cracks: bool) -> str:
    words = ["Load and displacement are those of the testing machine along the loading direction, from the same "
             "boundary conditions throughout. Grey lines are all samples, coloured ones those shown in detail;"
             f" where there are {MIN_BAND} samples or more, the black line is their median and the band holds {BAND[1] - BAND[0]} % of them."]
    if _is_quasi_static(histories):
        words.append("While the load grows slowly the figure shows equilibria; the last dynamic phase then runs at an almost "
                     "unchanged load or displacement.")
    if has_cracks:
        words.append("The length of a crack is taken along its path, the speed of a tip as the through-thickness mean "
                     "over a tenth of the ligament, but over four mean spacings of the mesh at least.")
    return " ".join(words)


def _is_quasi_static(histories: dict[int, History]) -> bool:
    return any((history.phase == 0).any() for history in histories.values())


def _abscissa(histories: dict[int, History]) -> str:
    return "displacement" if _is_quasi_static(histories) else "time"


def _values(history: History, what: str) -> np.ndarray:
    return {"load": history.governing_load, "displacement": history.governing_displacement, "time": history.time}[what]


def _units(histories: dict[int, History]) -> dict[str, Unit]:
    """Of load, displacement and time."""
    usual = {"load": (NEWTON, 0.1), "displacement": (MM, 1e-3), "time": (US, 0.5)}
    shown = {what: [np.abs(_values(history, what)[while_held(history.governing_load, history.phase) if what != "time" else slice(None)]).max()
                    for history in histories.values()] for what in usual}
    return {what: fitting(shown[what], *unit_and_least) for what, unit_and_least in usual.items()}


def _curves(histories: dict[int, History], of: str, units: dict[str, Unit]) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """@param of: "load over displacement", "load over time" or "displacement over time"."""
    what, over = of.split(" over ")
    return {i: (units[over].of(_values(history, over)), units[what].of(_values(history, what))) for i, history in histories.items()}


def _load(histories: dict[int, History], detailed: list[int]) -> Figure:
    """Load over displacement; where everything happens within waves' times, both over time."""
    over, units = _abscissa(histories), _units(histories)
    panels = ["load over displacement"] if over == "displacement" else ["load over time", "displacement over time"]
    figure = Figure(figsize=(style.PAGE_WIDTH, 3.4), layout="constrained")
    for axes, of in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels):
        curves = _curves(histories, of, units)
        for i, curve in curves.items():
            if i not in detailed:
                axes.plot(*curve, color=style.BEFORE_ONSET, linewidth=0.5, alpha=0.6)
        _band(axes, list(curves.values()))
        for k, i in enumerate(detailed):
            axes.plot(*curves[i], color=style.notch_colour(k), linewidth=1.1, label=f"sample {i}")
        if of.startswith("load"):
            of_displacement, of_load = load_limits((*curves[i], history.phase) for i, history in histories.items())
            axes.set_ylim(of_load)
            if over == "displacement":
                axes.set_xlim(of_displacement)
        axes.set_xlabel(units[over].label(over))
        what = of.split()[0]
        axes.set_ylabel(units[what].label(what))
        draw_grid(axes)
        axes.legend(loc="best")
    return figure


def _band(axes: Axes, curves: list[tuple[np.ndarray, np.ndarray]]) -> None:
    """Median and band of curves, over where at least half of them go."""
    if len(curves) < MIN_BAND:
        return
    ends = sorted(float(x.max()) for x, _ in curves)
    grid = np.linspace(0, ends[len(ends) // 2], BAND_POINTS)
    table = np.full((len(curves), grid.size), np.nan)
    for row, (x, y) in zip(table, curves):
        # Where a curve turns back, what counts is when it first gets so far.
        first = np.flatnonzero(x > np.maximum.accumulate(np.concatenate([[-np.inf], x[:-1]])))
        if first.size > 1:
            row[:] = np.interp(grid, x[first], y[first], left=np.nan, right=np.nan)
    shown = np.isfinite(table).sum(axis=0) >= max(MIN_BAND, len(curves) / 2)
    if not shown.any():
        return
    low, median, high = np.nanpercentile(table[:, shown], (BAND[0], 50, BAND[1]), axis=0)
    axes.fill_between(grid[shown], low, high, color="black", alpha=0.15, linewidth=0)
    axes.plot(grid[shown], median, color="black", linewidth=1.0, label=f"median, with {BAND[0]} to {BAND[1]} %")


def _last_motion(time: np.ndarray, tip_speed: np.ndarray) -> float:
    return float(time[np.isfinite(tip_speed)].max(initial=0))


def _common_rayleigh_speed(histories: dict[int, History]) -> float:
    """That of all tips in all samples; NaN where it differs [m/s]."""
    speeds = np.concatenate([(history.tip_speed / history.tip_speed_ratio).ravel() for history in histories.values()])
    speeds = speeds[np.isfinite(speeds)]
    if speeds.size == 0:
        return next(iter(histories.values())).rayleigh_speed
    return float(speeds[0]) if np.ptp(speeds) < 1e-6 * speeds[0] else np.nan


def _growth(ensemble: Ensemble, histories: dict[int, History], detailed: list[int]) -> Figure:
    figure = Figure(figsize=(style.PAGE_WIDTH, 3.3), layout="constrained")
    length_axes, speed_axes = figure.subplots(1, 2)
    leaders, times, lengths, latest = [], ensemble.times, ensemble.plate.lengths, 0.0
    rayleigh = _common_rayleigh_speed(histories)
    speeds = {i: history.tip_speed if np.isfinite(rayleigh) else history.tip_speed_ratio for i, history in histories.items()}
    for i, history in histories.items():
        rows, leader = history.in_last_phase, int(ensemble.leading[i])
        if leader < 0 or not rows.any():
            continue
        time = times.of(history.phase_time[rows])
        leaders.append((time, lengths.of(history.crack_length[rows, leader])))
        latest = max(latest, _last_motion(time, history.tip_speed[rows, leader]))
        if i not in detailed:
            length_axes.plot(*leaders[-1], color=style.BEFORE_ONSET, linewidth=0.5, alpha=0.6)
            speed_axes.plot(time, speeds[i][rows, leader], color=style.BEFORE_ONSET, linewidth=0.5, alpha=0.5)
    _band(length_axes, leaders)
    lines = ("-", "--", ":", "-.")
    for k, i in enumerate(detailed):
        history = histories[i]
        rows = history.in_last_phase
        for notch in range(history.crack_length.shape[1]):
            if not np.isfinite(history.tip_speed[:, notch]).any():
                continue
            time, style_of = times.of(history.phase_time[rows]), lines[notch % len(lines)]
            label = f"sample {i}, {ensemble.plate.name_of(notch)}"
            length_axes.plot(time, lengths.of(history.crack_length[rows, notch]), style_of, color=style.notch_colour(k),
                             linewidth=1.1, label=label)
            speed_axes.plot(time, speeds[i][rows, notch], style_of, color=style.notch_colour(k), linewidth=1.1)
            latest = max(latest, _last_motion(time, history.tip_speed[rows, notch]))
    limit, name, speed_label = (rayleigh, f"Rayleigh speed, {rayleigh:.0f} m/s", "tip speed [m/s]") if np.isfinite(rayleigh) else (
        1.0, "Rayleigh speed of what breaks there", "tip speed / Rayleigh speed")
    speed_axes.axhline(limit, color=style.BRANCHING, linewidth=0.8)
    speed_axes.annotate(name, (1, limit), xycoords=("axes fraction", "data"), xytext=(0, -3),
                        textcoords="offset points", ha="right", va="top", fontsize=7, color=style.BRANCHING)
    top = _top(speed_axes, limit)
    for axes, label, top in ((length_axes, lengths.label("crack length"), None), (speed_axes, speed_label, top)):
        axes.set_xlim(0, 1.15 * latest if latest > 0 else None)
        axes.set_ylim(0, top)
        axes.set_xlabel(times.label("time since onset"))
        axes.set_ylabel(label)
        draw_grid(axes)
    if length_axes.get_legend_handles_labels()[0]:
        length_axes.legend(loc="best", fontsize=6.5)
    return figure


def _top(axes: Axes, rayleigh: float) -> float:
    """Of the axes of speeds: shows them all, or where some are far above the others says how far they go."""
    fastest = max((float(np.nanmax(line.get_ydata(), initial=0.0)) for line in axes.lines), default=0.0)
    if fastest > MOST_OVER * rayleigh:
        axes.annotate("↑ up to " + (f"{fastest:,.0f}" if fastest >= 100 else f"{fastest:.3g}"), (0.01, 0.99), xycoords="axes fraction", va="top", fontsize=7)
    return 1.08 * max(rayleigh, min(fastest, MOST_OVER * rayleigh))


def _arrivals(ensemble: Ensemble) -> Figure:
    """Of the leading cracks, and of all others, at each section."""
    figure = Figure(figsize=(style.PAGE_WIDTH, 3.2), layout="constrained")
    axes = figure.subplots()
    shown = []
    groups = [(name, colour, _times_of(ensemble, name == "leading")) for name, colour in (("leading", "#0072b2"), ("following", "#d55e00"))]
    groups = [group for group in groups if any(t.size for t in group[-1])]
    for row, (name, colour, times) in enumerate(groups):
        shift = 0.26 * (row - (len(groups) - 1) / 2)
        shown.append(Line2D([], [], color=colour, marker="o", linestyle="none", markersize=3, label=f"{name} cracks"))
        for k, t in enumerate(times):
            axes.plot(np.full(t.size, k + shift), t, "o", color=colour, markersize=2.2, alpha=0.45, markeredgewidth=0)
            if t.size >= MIN_BAND:
                low, median, high = np.percentile(t, (BAND[0], 50, BAND[1]))
                axes.vlines(k + shift, low, high, color=colour, linewidth=3, alpha=0.3)
                axes.hlines(median, k + shift - 0.08, k + shift + 0.08, color=colour, linewidth=1.4)
    axes.axhline(0, color=style.MUTED, linewidth=0.6)
    axes.set_xlim(-0.5, len(ensemble.sections) - 0.5)
    axes.set_xticks(range(len(ensemble.sections)), [section.name for section in ensemble.sections])
    axes.tick_params(axis="x", labelrotation=30 if len(ensemble.sections) > 5 else 0)
    axes.set_ylabel(ensemble.times.label("arrival after onset"))
    axes.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
    axes.grid(axis="y", color=style.BODY, linewidth=0.6)
    axes.set_axisbelow(True)
    shown.append(Patch(color=style.MUTED, alpha=0.4, linewidth=0, label=f"{BAND[0]} to {BAND[1]} %, with median"))
    axes.legend(handles=shown, loc="best")
    return figure


def _earliest(ensemble: Ensemble) -> float:
    """Arrivals up to this time are before the last dynamic phase [s]."""
    return -min(1e-6, ensemble.times.size)


def _times_of(ensemble: Ensemble, leading: bool) -> list[np.ndarray]:
    """Arrival times at each section, in the ensemble's unit; those long before the last dynamic phase are left out."""
    table = ensemble.samples.arrival[ensemble.done]
    leads = ensemble.leading[ensemble.done][:, None] == np.arange(table.shape[1])
    chosen = leads if leading else ~leads
    times = [table[:, :, k][chosen] for k in range(table.shape[2])]
    return [ensemble.times.of(t[np.isfinite(t) & (t > _earliest(ensemble))]) for t in times]
