# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of the report, as HTML."""
from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from html import escape
from typing import Any, Callable, Iterable, Iterator, Optional, Union

import numpy as np
from crackle.files import DONE, FAILED
from crackle.text import probability, readable
from crackle.units import MM2, NEWTON, Unit, fitting, named

from . import style
from .results import Ensemble, Paths, Ranks, Result, Samples

STATUS_NAMES = ("pending", "done", "failed")
MISSING = "–"
TEXT = ' class="text"'


@dataclass(frozen=True)
class Column:
    title: str
    unit: str
    value: Callable[[Samples, int], Union[float, int, str]]
    format: str = ""  # of a number; texts are left-aligned


def _column(result: Result, table: Samples) -> Column:
    """The column of a result, as the program describes it; in another unit where its numbers would be hard to read."""
    if result.categories:
        words = dict(enumerate(result.categories))
        return Column(result.label, "", lambda s, i: words.get(int(s.numbers[result.name][i]), MISSING))
    kind = int if result.format == "d" else float
    units, factor, form = result.units, result.factor, result.format
    usual = named(result.units)
    if usual is not None and result.format.endswith("f"):
        fit = fitting(table.numbers[result.name][table.status == DONE], usual, _least_shown(result))
        if fit != usual:
            units, factor, form = fit.name, 1 / fit.size, ".3f"
    return Column(result.label, units, lambda s, i: kind(s.numbers[result.name][i] * factor), form)


def _least_shown(result: Result) -> float:
    """The least value in its unit of which the format shows two digits; of areas, whose prefixes are far apart, less."""
    return 1e-3 if "^2" in result.units and "/" not in result.units else 10.0 ** (1 - int(result.format[1:-1]))


def samples(ensemble: Ensemble) -> str:
    """One row for each sample; what is not known of any sample, or of a pending or failed one, is left out."""
    table = ensemble.samples
    done = table.status == DONE
    columns = [Column("sample", "", lambda s, i: i, "d"),
               Column("status", "", lambda s, i: STATUS_NAMES[int(s.status[i])])]
    meets_holes = "hole" in table.numbers and bool((table.numbers["hole"][done] >= 0).any())
    without = {"place" if ensemble.n_notches else "path"} | (set() if meets_holes else {"hole"})
    columns += [_column(result, table) for result in table.results
                if result.about not in without and not (done.any() and np.isnan(table.numbers[result.name][done]).all())]
    head = "".join(_head(column) for column in columns)
    body = []
    for i in range(len(table)):
        status = int(table.status[i])
        if status == DONE:
            cells = "".join(_cell(column, table, i) for column in columns)
        else:
            cells = "".join(_cell(column, table, i) for column in columns[:2])
            reason = table.error[i] if status == FAILED else ""
            cells += f'<td class="text reason" colspan="{len(columns) - 2}">{escape(reason)}</td>'
        body.append(f'<tr class="{STATUS_NAMES[status]}">{cells}</tr>')
    return (f'<div class="scroll wide"><table class="sortable"><thead><tr>{head}</tr></thead>\n<tbody>'
            + "\n".join(body) + "</tbody></table></div>")


def sections(ensemble: Ensemble) -> str:
    """The mean crack position at each section: of leading and following cracks, then of all cracks of each notch."""
    interval = f"{100 * ensemble.confidence:g} % interval"
    unit = ensemble.plate.lengths.name
    titles = (("cracks", ""), ("section", ""), ("samples that arrived", ""), ("mean position", unit),
              (interval, f"± {unit}"), ("standard deviation", unit),
              ("spread through the thickness", f"mean over the samples, {unit}"))
    rows = [row for group, paths in ensemble.ranks.items() for shown in ensemble.rows_shown(group)
            for row in [*_positions(ensemble, ensemble.rank_name(group, shown), paths, shown, paths.counted[shown]),
                        *_groups(ensemble, ensemble.rank_name(group, shown), paths, shown)]]
    rows += [row for notch in range(ensemble.n_notches)
             for row in _positions(ensemble, f"all of {ensemble.plate.name_of(notch)}, leading and following", ensemble.statistics, notch)]
    return f"<p>{escape(_about_ranks(ensemble))}{escape(_unreached(ensemble))}</p>" + _table(titles, _without_repetitions(rows))


def _unreached(ensemble: Ensemble) -> str:
    names = [section.name for section, n in zip(ensemble.sections, ensemble.statistics.reached.sum(axis=0)) if n == 0]
    return f" No crack reaches {', '.join(names)}." if names else ""


def _without_repetitions(rows: Iterable[list[str]]) -> Iterator[list[str]]:
    """Those of sections that any crack reached; without cracks that are the same as those of a name before, as where all lead."""
    seen: list[list[list[str]]] = []
    for _, of_name in itertools.groupby(rows, key=lambda row: row[0]):
        block = [row for row in of_name if not row[2].startswith("0")]
        content = [[section, arrived.partition(" ")[0], *others] for _, section, arrived, *others in block]
        if content not in seen:
            yield from block
        seen.append(content)


def _groups(ensemble: Ensemble, name: str, ranks: Ranks, row: int) -> Iterator[list[str]]:
    """Each group of the row's cracks at the sections where they are apart."""
    groups = ranks.groups_of(row)
    for number, group in enumerate(groups, 1):
        for k in np.flatnonzero(ranks.is_divided[row]):
            section = ensemble.sections[k]
            mean, *others = (_number(ensemble.plate.lengths.of(float(values[k])), ".2f") for values in (
                group.z_mean, group.z_half_width, group.z_std))
            yield [f"{name}: path {number} of {len(groups)}, {group.size}", section.name, str(int(group.reached[k])),
                   mean if mean == MISSING else f"{section.along} = {mean}", *others, MISSING]


def _positions(ensemble: Ensemble, name: str, paths: Paths, row: int, counted: Optional[np.ndarray] = None) -> Iterator[list[str]]:
    for k, section in enumerate(ensemble.sections):
        mean, *others = (_number(ensemble.plate.lengths.of(float(value)), ".2f") for value in (
            paths.z_mean[row, k], paths.z_half_width[row, k], paths.z_std[row, k], paths.spread_mean[row, k]))
        if paths.is_divided[row, k]:
            mean, others = "several paths", [MISSING, MISSING, others[2]]
        yield [name, section.name, str(int(paths.reached[row, k])) + (f" of {int(counted[k])}" if counted is not None else ""),
               mean if mean in (MISSING, "several paths") else f"{section.along} = {mean}", *others]


def linked(titles: Iterable[tuple[str, str]], rows: Iterable[list[str]], links: dict[str, str]) -> str:
    """A table as wide as the window allows.

    @param links where cells with these texts lead
    """
    return _table(titles, rows, links=links, is_wide=True)


def _table(titles: Iterable[tuple[str, str]], rows: Iterable[list[str]], kind: str = "", links: Optional[dict[str, str]] = None,
           is_wide: bool = False) -> str:
    """Of cells without markup; the titles have a second line, and the first column has text where it is no number."""
    def shown(cell: str) -> str:
        return f'<a href="{escape(links[cell])}">{escape(cell)}</a>' if links and cell in links else escape(cell)

    head = "".join(f"<th>{title}<small>{below}</small></th>" for title, below in titles)
    body = "\n".join("<tr>" + "".join(f'<td{TEXT if k == 0 and not cell.isdigit() else str()}>{shown(cell)}</td>'
                                      for k, cell in enumerate(row)) + "</tr>" for row in rows)
    return f'<div class="scroll{" wide" * is_wide}"><table{kind}><thead><tr>{head}</tr></thead>\n<tbody>{body}</tbody></table></div>'


def _about_ranks(ensemble: Ensemble) -> str:
    """Which samples lead, in sentences."""
    done = ensemble.leading[ensemble.done]
    counts = [f"{ensemble.plate.name_of(notch)} in {int((done == notch).sum())}" for notch in range(ensemble.n_notches)]
    text = "The leading crack of a sample crosses the largest share of its ligament: " + ", ".join(counts)
    if (done < 0).any():
        text += f", none in {int((done < 0).sum())}"
    text = " ".join([text + ".", *ensemble.notes])
    turned = [f"{ensemble.plate.name_of(notch)} as if {ensemble.plate.name_of(symmetry.reference)} did" for notch, symmetry in enumerate(ensemble.symmetries)
              if notch != symmetry.reference]
    if turned:
        text += f" The body's symmetry maps the samples led by some notches: {', '.join(turned)}."
    return text


def places(ensemble: Ensemble) -> str:
    """Where each sample broke."""
    lengths, times, areas = ensemble.plate.lengths, ensemble.times, fitting([place.largest_area for place in ensemble.places.values()], MM2, 1e-3)
    titles = (("sample", ""), *((f"first break, {axis}", lengths.name) for axis in "xyz"), ("first break", "s"),
              *((f"largest crack, {axis}", lengths.name) for axis in "xyz"), ("its area", areas.name), ("it began", f"{times.name} since onset"))
    rows = [[str(number), *(_number(lengths.of(value), ".2f") for value in place.first), _number(place.first_time, ensemble.samples.result("first_break_time").format),
             *(_number(lengths.of(value), ".2f") for value in place.largest), _number(areas.of(place.largest_area), ".3f"),
             _start(times, place.largest_start)] for number, place in ensemble.places.items()]
    return _table(titles, rows, ' class="sortable"')


def _start(times: Unit, since_onset: float) -> str:
    return "before the onset" if since_onset < 0 else _number(times.of(since_onset), ".2f")


def experiments(match: dict[str, Any]) -> str:
    """Each experiment, and all together, as `crackle match` has them."""
    titles = (("experiment", ""), ("by", ""), ("p", "rank among the samples"), ("samples", ""), ("distance", "mean to the samples"),
              ("usual distance", "median of the samples"), ("offset", "from the samples' mean"), ("nearest samples", "and their distances"))
    from crackle.match_text import interval_cells, quantities_of  # with SciPy
    rows = [[experiment["name"], readable(name), probability(by["p_value"]), str(by["n_samples"]), *sizes[:3], nearest]
            for experiment in match["experiments"] for name, by in experiment["by"].items() for *sizes, nearest in [quantities_of(by)]]
    table = _table(titles, rows)
    if match["set"] is None:
        return table
    titles = (("together by", ""), ("experiments", ""), ("p", "of a difference as large"), ("p of energy", ""), ("p of depth", ""), ("shift", ""),
              ("scatter", "of experiments over samples"))
    return table + _table(titles, [
        [readable(name), str(by["n_experiments"]), *(probability(by[p]) for p in ("p_value", "energy_p_value", "depth_p_value")),
         *interval_cells(by)] for name, by in match["set"]["by"].items()])


def advice(match: dict[str, Any]) -> str:
    """Sentences on several experiments together, and notes on single ones."""
    from crackle import match_text  # with SciPy

    words = [f"{experiment['name']}: {sentence}." for experiment in match["experiments"] for sentence in match_text.sentences(experiment)]
    words += [f"{one['name']} is left out by {readable(one['by'])}: {one['reason']}." for one in (match["set"] or {"left_out": []})["left_out"]]
    words += [f"By {readable(name)}: {by['advice']}" for name, by in (match["set"] or {"by": {}})["by"].items() if by.get("advice")]
    return " ".join(words)


def tiles(ensemble: Ensemble) -> str:
    """The ensemble in a few numbers."""
    table = ensemble.samples
    done = table.status == DONE
    entries = [(f"{done.sum()} of {len(table)}", _others(table) + _stopped(ensemble))]
    if ensemble.load.quantiles:
        entries.append(_load(ensemble.load))
    for pattern in (1, 2) if ensemble.n_notches else ():
        if done.any():
            found = ensemble.statistics.pattern(pattern)
            entries.append((f"{100 * found.share:.0f} %",
                            f"{style.pattern_name(pattern)} ({100 * found.lower:.0f} to {100 * found.upper:.0f} %)"))
    for name, label in (("bifurcations_projected", "branching in the projection"), ("bifurcations", "branching in space")):
        if name in table.numbers and table.result(name).any:
            entries.append((str(table.result(name).n_any), f"samples with {label}"))
    return '<div class="tiles">' + "".join(
        f'<div class="tile"><b>{escape(value)}</b><span>{escape(label)}</span></div>'
        for value, label in entries) + "</div>"


def _load(load: Result) -> tuple[str, str]:
    """Median of the load that says what the samples held, and between which values it lies."""
    bounds = load.bounds or (math.nan,) * len(load.quantiles)
    unit = fitting([*load.quantiles, *bounds], NEWTON, least=10)

    def shown(k: int) -> str:
        value, above = (bounds[k], "over ") if math.isnan(load.quantiles[k]) else (load.quantiles[k], "")
        return above + (f"{unit.of(value):.0f}" if unit == NEWTON else f"{unit.of(value):.3g}")

    unbroken = f"; {load.n_bounds} bore more" if load.n_bounds else ""
    return f"{shown(2)} {unit.name}", f"median {load.label} ({shown(0)} to {shown(4)} {unit.name}{unbroken})"


def provenance(ensemble: Ensemble) -> str:
    rows = "".join(f'<tr><td class="text">{escape(name)}</td><td class="text reason">{escape(value)}</td></tr>'
                   for name, value in ensemble.provenance.items())
    return f'<div class="scroll"><table><tbody>{rows}</tbody></table></div>'


def _others(table: Samples) -> str:
    failed, pending = table.count(FAILED), table.count(0)
    parts = [f"{failed} failed"] * (failed > 0) + [f"{pending} pending"] * (pending > 0)
    return "samples done" + (f" ({', '.join(parts)})" if parts else "")


def _stopped(ensemble: Ensemble) -> str:
    if ensemble.n_planned == len(ensemble.samples):
        return ""
    return f"; these suffice, {ensemble.n_planned} were planned"


def _head(column: Column) -> str:
    return f'<th scope="col"{"" if column.format else TEXT}>{column.title}<small>{column.unit}</small></th>'


def _cell(column: Column, table: Samples, i: int) -> str:
    value = column.value(table, i)
    if isinstance(value, str):
        return f'<td class="text">{escape(value)}</td>'
    return f'<td data-key="{value!r}">{_number(value, column.format)}</td>'


def _number(value: float, form: str) -> str:
    return format(value, form) if math.isfinite(value) else MISSING
