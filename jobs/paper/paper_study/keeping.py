# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts what the studies gave into a folder of the project: a table of all samples and a picture for each, and the
tables of its pages.
"""
from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from typing import Callable, Iterable

import numpy as np

from crackle_readme import put_block
from crackle_report import style
from crackle_report.writing import write_light_figure

from . import campaign, figures, fringes, rows, tables
from .against_paper import against_paper
from .rows import Rows
from .studies import CAMPAIGN, DISTANCE, FAST_FROM_ZERO, FIRST_BASE, FROM_ZERO, IMMEDIATE, OWN, PERTURBATION, PERTURBATIONS, STUDIES, Run


Kept = dict[str, dict[str, Rows]]  # by study and run
Show = Callable[[Kept, Path], None]


def keep(studies: list[str], output: Path, folder: Path, of_any_input: bool = False) -> None:
    """Reads the runs in `output`, finished or not, and brings `folder` up to date.

    @param of_any_input: also what was computed from another input than the study now gives
    @raise RunError: `folder` has samples that would be lost
    """
    def results_of(run: Run) -> Path | None:
        """The run's folder, when it has results that count."""
        results = output / run.name / "out"
        if not (results / "ensemble.h5").is_file():
            return None
        if of_any_input or rows.input_of(results) == rows.digest(run.input_text()):
            return results
        print(f"{run.name}: {results} is of another input than the study now gives, and left out")
        return None

    style.apply()
    folder.mkdir(parents=True, exist_ok=True)
    for study in studies:
        found = {run.name: rows.read(run, results) for run in STUDIES[study] if (results := results_of(run))}
        found = {name: one for name, one in found.items() if len(one) > 0}
        if not found:
            print(f"{study}: nothing computed yet")
            continue
        table = folder / f"{study}.csv"
        # What was computed elsewhere stays: other runs, and other samples of the same ones.
        known = {one.name: one for one in rows.read_csv(table)} if table.is_file() else {}
        known |= {name: rows.joined(known[name], one) if name in known else one for name, one in found.items()}
        rows.write_csv([known[run.name] for run in STUDIES[study] if run.name in known], table)
        if study == "softening" and (immediate := results_of(IMMEDIATE)):
            if table_of_laws := campaign.keep_laws(immediate, output / "softening" / "out", folder):
                _put(folder, "fringes", table_of_laws)
        if study == "campaign":
            campaign.keep_ensemble(output / CAMPAIGN.name / "out", folder)
            campaign.keep_pictures(output / CAMPAIGN.name / "out", folder)
        if study == "steps" and IMMEDIATE.name in found:
            campaign.keep_fringes(output / IMMEDIATE.name / "out", found[IMMEDIATE.name], folder / "fringes.csv")
    kept = {study: {one.name: one for one in rows.read_csv(folder / f"{study}.csv")} for study in STUDIES
            if (folder / f"{study}.csv").is_file()}
    for study in studies:
        if study in kept:
            SHOW[study](kept, folder)
    if {"campaign", "own", "steps"} & set(studies) and "campaign" in kept:
        mine = kept["campaign"][CAMPAIGN.name]
        _put(folder, "paper", against_paper(mine, _fringes(kept, folder), kept.get("own", {}).get(OWN.name)))


def _fringes(kept: Kept, folder: Path) -> list[fringes.FringeSeries]:
    """Those of the campaign's bodies with large steps; of another input than the kept one they would say nothing."""
    file, mine = folder / "fringes.csv", kept.get("steps", {}).get(IMMEDIATE.name)
    return fringes.read_csv(file) if mine and file.is_file() and fringes.contents(file)[0] == mine.input else []


def _branching(kept: Kept, folder: Path) -> None:
    mine = list(kept["branching"].values())
    _put(folder, "branching", tables.branching(mine))
    write_light_figure(figures.forks(mine), folder / "branching.png")
    if (by_eye := folder / "forks-by-eye.csv").is_file():
        with open(by_eye, newline="") as stream:
            _put(folder, "by-eye", tables.by_eye(list(csv.DictReader(stream)), mine))


def _notches(kept: Kept, folder: Path) -> None:
    mine = list(kept["notches"].values())
    write_light_figure(figures.onset_against_depth(mine), folder / "onset-against-depth.png")
    chosen = [one for one in mine if one.label.endswith(f", {DISTANCE:g} mm")]
    if len(chosen) < 4:
        return
    curve, depth = tables.median_curve(chosen)
    scatter = np.nan_to_num(tables.base_scatter(list(kept.get("bases", {}).values())))
    low, high = tables.depth_interval(chosen, scatter)
    _put(folder, "notches", tables.notches(mine) + (
        f"\nAt {DISTANCE:g} mm the curve through the medians meets {tables.TARGET_LOAD} N at a depth of {depth:.2f} mm (95 %: "
        f"{low:.2f} to {high:.2f} mm), where it falls by {-np.polyval(np.polyder(curve), depth):.0f} N/mm.\n"))


def _bases(kept: Kept, folder: Path) -> None:
    mine = list(kept["bases"].values())
    _put(folder, "bases", tables.bases(mine))
    first, fast = kept["bases"].get(FIRST_BASE.name), kept.get("convergence", {}).get(FAST_FROM_ZERO.name)
    if first and fast:
        _put(folder, "turning", tables.turning(first, fast))


def _campaign(kept: Kept, folder: Path) -> None:
    _settings(kept, folder)
    mine = kept["campaign"][CAMPAIGN.name]
    _put(folder, "symmetry", tables.symmetry(mine))
    _put(folder, "base-notches", tables.base_notches(mine))
    _put(folder, "limits", tables.group_limits(mine))
    write_light_figure(figures.second_crack(mine), folder / "second-crack.png")


SETTINGS = ("campaign", "second-base", "own", "strength", "softening")


def _settings(kept: Kept, folder: Path) -> None:
    """The paper's setting, and what else differs in one thing from it."""
    _put(folder, "settings", tables.branching([one for study in SETTINGS for one in kept.get(study, {}).values()]))


def _compared(study: str, reference: Run) -> Show:
    """A study of the reference's bodies, which is the only run of a study of its name."""
    def show(kept: Kept, folder: Path) -> None:
        mine = kept.get(reference.name, {}) | kept[study]
        runs = [(run, mine[run.name]) for run in (reference, *STUDIES[study]) if run.name in mine]
        _put(folder, study, tables.comparison(mine, runs))
    return show


def _steps(kept: Kept, folder: Path) -> None:
    _compared("steps", CAMPAIGN)(kept, folder)
    if series := _fringes(kept, folder):
        write_light_figure(figures.fringes(series), folder / "fringes.png")


def _by_label(several: Iterable[Rows]) -> dict[str, list[Rows]]:
    result: dict[str, list[Rows]] = {}
    for one in several:
        result.setdefault(one.label, []).append(one)
    return result


def _from_zero(kept: Kept) -> list[Rows]:
    """The paper's spacing and disturbance on several bases, the clock starting without load."""
    return tables.other_bases(list(kept.get("bases", {}).values()))


def _usual_disturbance(kept: Kept) -> list[Rows]:
    """The same in the paper's setting."""
    return _by_label(kept.get("disturbance", {}).values()).get(f"{PERTURBATION:g}", [])


def _on_bases(study: str, title: str, usual: str, place: int, reference: Callable[[Kept], list[Rows]],
              same_bases: bool, unit: str = "") -> Show:
    """A study of the mesh on several bases; the setting that the others are compared with is put in at this place."""
    def show(kept: Kept, folder: Path) -> None:
        settings = [(label, several) for label, several in _by_label(kept[study].values()).items() if label != usual]
        if not (others := reference(kept)):
            return
        settings.insert(place, (usual, others))
        _put(folder, study, tables.on_bases(title, usual, settings, same_bases))
        write_light_figure(figures.reach_and_paths(settings, "reach", title + unit), folder / f"{study}.png")
    return show


def _rate(kept: Kept, folder: Path) -> None:
    campaign_rows = kept.get("campaign", {}).get(CAMPAIGN.name)
    if campaign_rows is None:
        return
    slow, mine = replace(campaign_rows, label="5 N/s"), list(kept["rate"].values())
    _put(folder, "rate", tables.rates(slow, mine))
    labelled = [(one.label, [one]) for one in (slow, *mine)]
    write_light_figure(figures.reach_and_paths(labelled, "other_when_far", "rate"), folder / "rate.png")


SHOW = {"branching": _branching, "notches": _notches, "bases": _bases, "campaign": _campaign,
        **dict.fromkeys(SETTINGS[1:], _settings), "steps": _steps,
        "clock-from-zero": lambda kept, folder: None, "convergence": _compared("convergence", FROM_ZERO),
        "spacing": _on_bases("spacing", "spacing", "0.3 mm at the tips", 0, _from_zero, same_bases=False),
        "disturbance": _on_bases("disturbance", "perturbation", f"{PERTURBATION:g}",
                                 sum(p < PERTURBATION for p in PERTURBATIONS), _usual_disturbance, same_bases=True,
                                 unit=" [spacings]"),
        "heterogeneity": _on_bases("heterogeneity", "what differs from sample to sample", "mesh alone", 0, _usual_disturbance,
                                   same_bases=True),
        "rate": _rate}


def _put(folder: Path, place: str, table: str) -> None:
    """Into the page of the folder that has the marks of this place, if one has them; and to the standard output."""
    print(table, end="")
    for file in folder.glob("*.md"):
        if f"<!-- {place}:begin -->" in file.read_text():
            put_block(place, table, file)
