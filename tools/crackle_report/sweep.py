# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of a sweep: its results over the values that it runs through, as `crackle stats --json` has them."""
from __future__ import annotations

import math
import re
import tomllib
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any, Optional

import numpy as np
from crackle.files import ResultsError
from crackle.units import Unit, fitting, named, quantity_of
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from . import page, style, tables
from .figures.picture import Picture, Section

N_COLUMNS, ROW_HEIGHT = 3, 2.1  # of panels [inch]
MOST_LABELS = 8  # values that are words, on an axis


@dataclass(frozen=True)
class Shown:
    """A result, or the share of a category, in each case; NaN where there is none."""

    label: str
    is_share: bool
    unit: Unit
    value: np.ndarray  # in this unit
    lower: np.ndarray  # ends of its interval
    upper: np.ndarray


@dataclass(frozen=True)
class Swept:
    """A key, and its values in the cases."""

    key: str
    texts: list[str]
    numbers: Optional[np.ndarray]  # None of words
    unit: str

    @property
    def n_values(self) -> int:
        return len(set(self.texts))


def is_sweep(folder: Path) -> bool:
    return (folder / "sweep.toml").is_file()


def case_folders(folder: Path, document: dict[str, Any]) -> list[Path]:
    """@param document of `crackle stats --json`"""
    return [folder / one["folder"] for one in document["cases"]]


def section(document: dict[str, Any]) -> Section:
    """The pictures. Raises ResultsError when no sample of any case has ended."""
    shown = _results(document)
    if not shown:
        raise ResultsError("no sample of any case of the sweep has ended")
    keys = _swept(document)
    across, others = _arranged(keys)
    text = (f"A point for each case over {across.key}: means over the samples that have the result (of loads over those that broke), with their "
            f"{100 * document['confidence']:g} % intervals (Student's), and shares of the samples with Wilson's. Samples of the same number have the same meshes in all cases unless the sweep changes these, so that "
            "crackle compare, which pairs them, finds smaller differences than these intervals show.")
    if others:
        text += f" Lines of one colour have one value of {' and '.join(one.key for one in others)}."
    result = Section("Results over the swept values", text)
    for name, what, of_kind in (("sweep", "Means", [one for one in shown if not one.is_share]),
                                ("sweep-shares", "Shares of the samples", [one for one in shown if one.is_share])):
        if of_kind:
            result.pictures.append(Picture(name, f"{what} over {across.key}", _figure(of_kind, across, others)))
    return result


def render(folder: Path, document: dict[str, Any], drawn: Section, images: list[bytes]) -> str:
    """The page."""
    title = f"crackle: sweep {folder.resolve().name}"
    cases = document["cases"]
    done, planned = (sum(one[name] for one in cases) for name in ("n_done", "n_samples"))
    parts = [f"<h1>{escape(title)}</h1>", f'<p class="muted">{len(cases)} cases, {done} of {planned} samples done</p>',
             *page.of_section(drawn, images), "<h2>Cases</h2>", _about_reports(folder, document), _table(folder, document),
             f"<h2>Input</h2>\n<pre>{escape((folder / 'sweep.toml').read_text(encoding='utf-8', errors='replace'))}</pre>"]
    return page.document(title, parts, [])


def _about_reports(folder: Path, document: dict[str, Any]) -> str:
    missing = [one.name for one in case_folders(folder, document) if not (one / "report.html").is_file()]
    if not missing:
        return "<p>Each case has a report of its own.</p>"
    return (f"<p>A case with a link has a report of its own; <code>crackle-report {escape(str(folder))} --cases</code> writes those of all "
            "cases.</p>")


def _table(folder: Path, document: dict[str, Any]) -> str:
    keys, shown, cases = _swept(document), _results(document), document["cases"]
    titles = [("case", ""), *((escape(one.key), "") for one in keys), ("done", ""), ("failed", ""), ("unbroken", "not in means of loads"),
              *((escape(one.label), one.unit.name) for one in shown)]
    rows = [[one["folder"], *(of.texts[k] for of in keys), f"{one['n_done']} of {one['n_samples']}", str(one["n_failed"]), str(one["n_unbroken"]),
             *(_cell(of, k) for of in shown)] for k, one in enumerate(cases)]
    links = {one["folder"]: f"{one['folder']}/report.html" for one in cases if (folder / one["folder"] / "report.html").is_file()}
    return tables.linked(titles, rows, links)


def _cell(of: Shown, k: int) -> str:
    value, lower, upper = of.value[k], of.lower[k], of.upper[k]
    if math.isnan(value):
        return tables.MISSING
    if of.is_share:
        return f"{value:.0f} ({lower:.0f} to {upper:.0f})"
    return f"{value:.4g}" + (f" ± {upper - value:.2g}" if math.isfinite(upper) else "")


def _results(document: dict[str, Any]) -> list[Shown]:
    """Those that any case has; shares that are 0 everywhere, or 1, are left out."""
    table = {name: np.array([one[name] for one in document["cases"]], float) for name in ("value", "lower", "upper")}
    found = []
    for k, result in enumerate(document["results"]):
        columns = {name: values[:, k] for name, values in table.items()}
        known = columns["value"][np.isfinite(columns["value"])]
        if known.size == 0 or (result["share_of"] and (np.ptp(known) == 0 and known[0] in (0, 1))):
            continue
        usual = named(result["shown_units"])
        unit = fitting(columns["value"], usual, 1e-2) if usual else Unit(result["shown_units"], 1 / result["shown_factor"])
        label = f"{result['label']}: {result['share_of']}" if result["share_of"] else result["label"]
        found.append(Shown(label, bool(result["share_of"]), unit, **{name: unit.of(values) for name, values in columns.items()}))
    return found


def _swept(document: dict[str, Any]) -> list[Swept]:
    settings = [one["settings"] for one in document["cases"]]
    keys = []
    for k, first in enumerate(settings[0]):
        values = [tomllib.loads(f"value = {of_case[k]['value']}")["value"] for of_case in settings]
        keys.append(Swept(first["key"], [str(value) for value in values], *_numbers(values)))
    return keys


def _numbers(values: list[Any]) -> tuple[Optional[np.ndarray], str]:
    """Of values that are numbers, or texts of numbers with units of one kind, and their unit; None of others."""
    if all(isinstance(value, (int, float)) and not isinstance(value, bool) for value in values):
        return np.array(values, float), ""
    parts = [re.fullmatch(r"([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*(\S.*)?", value) if isinstance(value, str) else None for value in values]
    if not all(parts):
        return None, ""
    if len({part[2] for part in parts}) == 1:
        return np.array([float(part[1]) for part in parts]), parts[0][2] or ""
    try:
        quantities = [quantity_of(value) for value in values]
    except ValueError:
        return None, ""
    numbers, bases = np.array([value for value, _ in quantities]), {base for _, base in quantities}
    if len(bases) > 1:
        return None, ""
    unit = fitting(numbers, named(bases.pop()) or Unit("", 1.0), 1.0)
    return unit.of(numbers), unit.name


def _arranged(keys: list[Swept]) -> tuple[Swept, list[Swept]]:
    """The key along the axis, a number rather than words, of several the one with most values; and the others that vary."""
    across = max(keys, key=lambda one: (one.numbers is not None and one.n_values > 1, one.n_values))
    return across, [one for one in keys if one is not across and one.n_values > 1]


def _figure(shown: list[Shown], across: Swept, others: list[Swept]) -> Figure:
    n_rows = -(-len(shown) // N_COLUMNS)
    legend = 0.3 if others else 0.0
    figure = Figure(figsize=(style.PAGE_WIDTH, ROW_HEIGHT * n_rows + legend), layout="constrained")
    figure.get_layout_engine().set(rect=(0, 0, 1, 1 - legend / figure.get_figheight()))
    grid = figure.subplots(n_rows, N_COLUMNS, squeeze=False)
    for axes in grid.flat[len(shown):]:
        axes.set_visible(False)
    names = [", ".join(f"{one.key} = {one.texts[k]}" for one in others) for k in range(len(across.texts))]
    for axes, one in zip(grid.flat, shown):
        _panel(axes, one, across, names)
    if others:
        figure.legend(*grid.flat[0].get_legend_handles_labels(), loc="upper left", ncols=3)
    return figure


def _panel(axes: Axes, shown: Shown, across: Swept, names: list[str]) -> None:
    words = list(dict.fromkeys(across.texts))
    places = across.numbers if across.numbers is not None else np.array([words.index(text) for text in across.texts], float)
    for row, name in enumerate(dict.fromkeys(names)):
        chosen = np.array([k for k in np.argsort(places, kind="stable") if names[k] == name and np.isfinite(shown.value[k])], int)
        value = shown.value[chosen]
        reach = np.nan_to_num([np.maximum(value - shown.lower[chosen], 0), np.maximum(shown.upper[chosen] - value, 0)])
        axes.errorbar(places[chosen], value, reach, color=style.notch_colour(row), marker="o", markersize=3, linewidth=1.0, capsize=2.5,
                      elinewidth=0.8, label=name)
    if shown.is_share:
        axes.set_ylim(-3, 103)
    if across.numbers is None:
        axes.set_xticks(range(len(words)), words, rotation=0 if len(words) < 4 else 30, fontsize=6)
    elif np.all(places > 0) and places.max() > 30 * places.min():
        axes.set_xscale("log")
    axes.set_xlabel(f"{across.key} [{across.unit}]" if across.unit else across.key, fontsize=7)
    axes.set_title(shown.unit.label(shown.label), loc="left", pad=3)
    axes.grid(color=style.BODY, linewidth=0.6)
    axes.set_axisbelow(True)
