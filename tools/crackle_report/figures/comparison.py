# SPDX-License-Identifier: GPL-3.0-or-later
"""What differs between this ensemble and others, with intervals: the numbers of `crackle compare`."""
from __future__ import annotations

from pathlib import Path
from typing import Any, Optional

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from crackle.units import Unit

from .. import style
from ..options import Options
from ..results import Ensemble
from .picture import Picture, Section

LIMIT = 0.05  # of p over all looks, below which a difference is marked
ROW_HEIGHT = 0.2  # [inch]
SURE, UNSURE = style.NOTCH_COLOURS[1], style.MUTED


def section(ensemble: Ensemble, options: Options) -> Optional[Section]:
    """Nothing where no other ensemble is given."""
    if options.comparison is None:
        return None
    result = Section("Compared with other ensembles",
                     "Differences of means and shares, the other ensemble minus this one, with their intervals. Significant "
                     f"differences are marked: the adjusted p of a permutation test is below {LIMIT}.")
    answers = []
    for number, comparison in enumerate(options.comparison["comparisons"]):
        name = Path(comparison["second"]).resolve().name
        result.pictures.append(Picture(f"comparison-{number}", f"Differences between {name} and this ensemble",
                                       _figure(comparison, options.comparison["sections"], ensemble.plate.lengths)))
        answers.append(_answer(name, comparison))
    result.answer = " ".join(answers)
    return result


def _label(entry: dict[str, Any]) -> str:
    """With units, as the time and the load of an event have one label."""
    if entry["share_of"]:
        return f"{entry['label']}: {entry['share_of']}"
    if _is_bounded(entry):
        return f"{entry['label']}, median [{entry['shown_units']}]"
    return f"{entry['label']} [{entry['shown_units']}]" if entry["shown_units"] else entry["label"]


def _difference(entry: dict[str, Any]) -> dict[str, Any]:
    """Of medians, where samples that did not break bound a load."""
    return entry["difference_of_medians" if _is_bounded(entry) else "difference_of_means"]


def _first(entry: dict[str, Any]) -> Optional[float]:
    return entry["median_first" if _is_bounded(entry) else "mean_first"]


def _is_bounded(entry: dict[str, Any]) -> bool:
    return entry["n_bounds_first"] + entry["n_bounds_second"] > 0


def _is_sure(entry: dict[str, Any]) -> bool:
    return entry["p_adjusted"] is not None and entry["p_adjusted"] < LIMIT


def _answer(name: str, comparison: dict[str, Any]) -> str:
    differing = [f"{_label(entry).partition(' [')[0]} ({_shown(entry)})" for entry in comparison["results"] if _is_sure(entry)]
    differing += [f"the paths led by start {paths['leading_notch']}" for paths in comparison["paths"] if _is_sure(paths)]
    how = f"{comparison['n_pairs']} pairs of samples with the same bodies" if comparison["paired"] else comparison["note"]
    found = "differs in " + ", ".join(differing) if differing else "does not differ significantly"
    return f"{name} {found} ({how})."


def _shown(entry: dict[str, Any]) -> str:
    """The difference as people read it: "+12 %" of a number's mean or median, "+12 points" of a share."""
    difference = _difference(entry)["value"]
    if difference is None:
        return "by an unknown amount"
    if entry["share_of"]:
        return f"{100 * difference:+.0f} points"
    if not _first(entry):
        return f"{entry['shown_factor'] * difference:+.3g} {entry['shown_units']}".strip()
    return f"{100 * difference / abs(_first(entry)):+.1f} %"


def _figure(comparison: dict[str, Any], sections: list[str], lengths: Unit) -> Figure:
    # Without a value where only one of the ensembles has the result.
    known = [entry for entry in comparison["results"] if _difference(entry)["value"] is not None]
    numbers = [entry for entry in known if not entry["share_of"] and _first(entry)]
    shares = [entry for entry in known if entry["share_of"]]
    panels = [("percent of this ensemble's mean", [(_label(entry), _difference(entry), 100 / abs(_first(entry)), _is_sure(entry))
                                                   for entry in numbers]),
              ("percentage points of the samples", [(_label(entry), entry["difference_of_means"], 100, _is_sure(entry)) for entry in shares]),
              (lengths.label("mean position"), [(f"start {paths['leading_notch']} leads, {where}", difference, 1 / lengths.size, _is_sure(paths))
                                      for paths in comparison["paths"] for where, difference in zip(sections, paths["difference_of_means"])
                                      if difference["value"] is not None])]
    panels = [panel for panel in panels if panel[1]]
    heights = [len(rows) + 1 for _, rows in panels]
    figure = Figure(figsize=(style.PAGE_WIDTH, ROW_HEIGHT * sum(heights) + 0.4 * len(panels)), layout="constrained")
    for axes, (unit, rows) in zip(figure.subplots(len(panels), height_ratios=heights, squeeze=False)[:, 0], panels):
        _draw(axes, unit, rows)
    return figure


def _draw(axes: Axes, unit: str, rows: list[tuple[str, dict[str, Any], float, bool]]) -> None:
    axes.axvline(0, color=style.OUTLINE, linewidth=0.8)
    for place, (_, difference, factor, is_sure) in enumerate(rows):
        colour = SURE if is_sure else UNSURE
        if None not in (difference["lower"], difference["upper"]):
            axes.plot([factor * difference["lower"], factor * difference["upper"]], [place, place], color=colour, linewidth=1.6)
        axes.plot(factor * difference["value"], place, "o", color=colour, markersize=4)
    axes.set_yticks(range(len(rows)), [label for label, *_ in rows])
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_xlabel(unit, labelpad=1)
    axes.grid(axis="x", color=style.BODY, linewidth=0.6)
    axes.tick_params(axis="y", length=0)
