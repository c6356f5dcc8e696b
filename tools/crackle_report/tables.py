# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of the report, as HTML."""
from __future__ import annotations

import math
from dataclasses import dataclass
from html import escape
from typing import Callable, Union

import numpy as np

from . import style
from .confidence import mean_of_present
from .results import DONE, FAILED, Ensemble, Samples
from .statistics import wilson_interval

STATUS_NAMES = ("pending", "done", "failed")
OUTCOME_NAMES = ("unbroken", "arrested", "separated", "duration over")
MISSING = "–"


@dataclass(frozen=True)
class Column:
    title: str
    unit: str
    value: Callable[[Samples, int], Union[float, int, str]]
    format: str = ""  # of a number; texts are left-aligned


SAMPLE_COLUMNS = (
    Column("sample", "", lambda s, i: i, "d"),
    Column("status", "", lambda s, i: STATUS_NAMES[int(s.status[i])]),
    Column("onset time", "s", lambda s, i: float(s.onset_time[i]), ".2f"),
    Column("onset force", "N", lambda s, i: float(s.onset_force[i]), ".1f"),
    Column("end", "", lambda s, i: _name(OUTCOME_NAMES, int(s.outcome[i]))),
    Column("pattern", "", lambda s, i: style.pattern_name(int(s.pattern[i]))),
    Column("overlap", "%", lambda s, i: 100 * float(s.overlap[i]), ".0f"),
    Column("branchings", "", lambda s, i: int(s.bifurcations[i]), "d"),
    Column("kinks", "", lambda s, i: int(s.kinks[i]), "d"),
    Column("crack area", "mm²", lambda s, i: float(s.crack_area[i]) * 1e6, ".1f"),
    Column("largest crack speed", "m/s", lambda s, i: float(s.crack_speed_max[i]), ".0f"),
    Column("over Rayleigh's", "", lambda s, i: float(s.crack_speed_ratio[i]), ".2f"),
    Column("released energy per crack area", "J/m²", lambda s, i: float(s.effective_toughness[i]), ".3g"),
    Column("energy error", "of the work", lambda s, i: float(s.energy_error[i]), ".1e"),
)


def samples(ensemble: Ensemble) -> str:
    """One row for each sample; what is not known of a pending or failed one is left out."""
    head = "".join(_head(column) for column in SAMPLE_COLUMNS)
    body = []
    for i in range(len(ensemble.samples)):
        status = int(ensemble.samples.status[i])
        if status == DONE:
            cells = "".join(_cell(column, ensemble.samples, i) for column in SAMPLE_COLUMNS)
        else:
            cells = "".join(_cell(column, ensemble.samples, i) for column in SAMPLE_COLUMNS[:2])
            reason = ensemble.samples.error[i] if status == FAILED else ""
            cells += f'<td class="text reason" colspan="{len(SAMPLE_COLUMNS) - 2}">{escape(reason)}</td>'
        body.append(f'<tr class="{STATUS_NAMES[status]}">{cells}</tr>')
    return (f'<div class="scroll"><table class="sortable"><thead><tr>{head}</tr></thead>\n<tbody>'
            + "\n".join(body) + "</tbody></table></div>")


def sections(ensemble: Ensemble) -> str:
    """The mean crack position of each notch at each section."""
    statistics = ensemble.statistics
    interval = f"{100 * ensemble.confidence:g} % interval"
    titles = (("notch", ""), ("section y", "mm"), ("samples that arrived", ""), ("mean z", "mm"),
              (interval, "± mm"), ("standard deviation", "mm"),
              ("spread through the thickness", "mean over the samples, mm"))
    head = "".join(f"<th>{title}<small>{unit}</small></th>" for title, unit in titles)
    body = []
    spread = mean_of_present(ensemble.samples.z_spread)
    for notch in range(ensemble.n_notches):
        for k, y in enumerate(ensemble.sections):
            numbers = (statistics.z_mean, statistics.z_half_width, statistics.z_std, spread)
            cells = [str(notch), f"{y / style.MILLIMETRE:g}", str(int(statistics.reached[notch, k]))]
            cells += [_number(float(values[notch, k]) / style.MILLIMETRE, ".2f") for values in numbers]
            body.append("<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>")
    return (f'<div class="scroll"><table><thead><tr>{head}</tr></thead>\n<tbody>' + "\n".join(body)
            + "</tbody></table></div>")


def tiles(ensemble: Ensemble) -> str:
    """The ensemble in a few numbers."""
    table = ensemble.samples
    done = table.status == DONE
    entries = [(f"{done.sum()} of {len(table)}", _others(table) + _stopped(ensemble))]
    force = table.onset_force[done & np.isfinite(table.onset_force)]
    if force.size:
        entries.append((f"{np.median(force):.0f} N",
                        f"median onset force ({force.min():.0f} to {force.max():.0f} N)"))
    for pattern in (1, 2):
        if done.any():
            count = int((table.pattern[done] == pattern).sum())
            low, high = wilson_interval(count, int(done.sum()), ensemble.confidence)
            entries.append((f"{100 * count / done.sum():.0f} %",
                            f"{style.pattern_name(pattern)} ({100 * low:.0f} to {100 * high:.0f} %)"))
    branched = int(np.count_nonzero(table.bifurcations[done] > 0))
    if done.any():
        entries.append((str(branched), "samples with branchings"))
    return '<div class="tiles">' + "".join(
        f'<div class="tile"><b>{escape(value)}</b><span>{escape(label)}</span></div>'
        for value, label in entries) + "</div>"


def provenance(ensemble: Ensemble) -> str:
    rows = "".join(f'<tr><td class="text">{escape(name)}</td><td class="text reason">{escape(value)}</td></tr>'
                   for name, value in ensemble.provenance.items())
    return f'<div class="scroll"><table><tbody>{rows}</tbody></table></div>'


def _name(names: tuple[str, ...], number: int) -> str:
    return names[number] if 0 <= number < len(names) else str(number)


def _others(table: Samples) -> str:
    failed, pending = table.count(FAILED), table.count(0)
    parts = [f"{failed} failed"] * (failed > 0) + [f"{pending} pending"] * (pending > 0)
    return "samples done" + (f" ({', '.join(parts)})" if parts else "")


def _stopped(ensemble: Ensemble) -> str:
    if ensemble.n_planned == len(ensemble.samples):
        return ""
    return f"; enough, {ensemble.n_planned} were planned"


def _head(column: Column) -> str:
    kind = "" if column.format else ' class="text"'
    return f'<th scope="col"{kind}>{column.title}<small>{column.unit}</small></th>'


def _cell(column: Column, table: Samples, i: int) -> str:
    value = column.value(table, i)
    if isinstance(value, str):
        return f'<td class="text">{escape(value)}</td>'
    return f'<td data-key="{value!r}">{_number(value, column.format)}</td>'


def _number(value: float, form: str) -> str:
    return format(value, form) if math.isfinite(value) else MISSING
