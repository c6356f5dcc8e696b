# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts what the studies gave into a folder of the project: a table of all samples and a picture for each, and the
tables of its README.md.
"""
from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Callable

from matplotlib.figure import Figure

from crackle_report import style
from crackle_report.writing import put_between_marks

from . import campaign, figures, fringes, rows, tables
from .rows import Rows
from .studies import CAMPAIGN, DISTANCE, FAST_CAMPAIGN, STUDIES


def keep(studies: list[str], output: Path, folder: Path, front_page: Path | None) -> None:
    """Reads the runs in `output`, finished or not, and brings `folder` up to date.

    @param front_page where the comparison with the paper goes, a README.md with marks for it; None: nowhere else
    """
    style.apply()
    folder.mkdir(parents=True, exist_ok=True)
    for study in studies:
        found = {run.name: rows.read(run, output / run.name / "out") for run in STUDIES[study]
                 if (output / run.name / "out" / "ensemble.h5").is_file()}
        found = {name: one for name, one in found.items() if len(one) > 0}
        if not found:
            print(f"{study}: nothing computed yet")
            continue
        rows.write_csv(list(found.values()), folder / f"{study}.csv")
        if study == "campaign":
            _keep_campaign(found[CAMPAIGN.name], output / CAMPAIGN.name / "out", folder)
    kept = {study: {one.name: one for one in rows.read_csv(folder / f"{study}.csv")} for study in STUDIES
            if (folder / f"{study}.csv").is_file()}
    for study in studies:
        if study in kept:
            SHOW[study](kept, folder)
    if "campaign" in studies and "campaign" in kept:
        table = tables.against_paper(kept["campaign"][CAMPAIGN.name], _fringes(folder))
        print(table, end="")
        if front_page is not None:
            put_between_marks(front_page, "paper", table)


def _keep_campaign(found: Rows, results: Path, folder: Path) -> None:
    campaign.keep_ensemble(results, folder)
    campaign.keep_pictures(results, folder)
    campaign.keep_fringes(results, found, folder / "fringes.csv")


def _fringes(folder: Path) -> list[fringes.FringeSeries]:
    file = folder / "fringes.csv"
    return fringes.read_csv(file) if file.is_file() else []


def _notches(kept: dict[str, dict[str, Rows]], folder: Path) -> None:
    mine = list(kept["notches"].values())
    _put(folder, "notches", tables.notches(mine))
    chosen = [one for one in mine if one.label.endswith(f", {DISTANCE:g} mm")]
    _, depth = tables.median_curve(chosen)
    print(f"notches: {tables.TARGET_LOAD} N at a depth of {depth:.3f} mm, distance {DISTANCE:g} mm")
    _save(figures.onset_against_depth(mine), folder / "onset-against-depth.png")


def _bases(kept: dict[str, dict[str, Rows]], folder: Path) -> None:
    _put(folder, "bases", tables.bases(list(kept["bases"].values())))


def _campaign(kept: dict[str, dict[str, Rows]], folder: Path) -> None:
    mine = kept["campaign"][CAMPAIGN.name]
    _put(folder, "symmetry", tables.symmetry(mine))
    _save(figures.overlap(mine), folder / "overlap.png")
    if series := _fringes(folder):
        _save(figures.fringes(series), folder / "fringes.png")


def _convergence(kept: dict[str, dict[str, Rows]], folder: Path) -> None:
    others = dict(kept["convergence"])
    reference = kept.get("campaign", {}).get(CAMPAIGN.name) or others.pop(FAST_CAMPAIGN.name)
    _put(folder, "convergence", tables.comparison(reference, list(others.values())))


def _against_fast(study: str, title: str, label: str, place: int) -> Callable[[dict[str, dict[str, Rows]], Path], None]:
    """Shares of a study's runs; the fast campaign is among them under this label, at this place."""
    def show(kept: dict[str, dict[str, Rows]], folder: Path) -> None:
        mine = list(kept[study].values())
        fast = kept["convergence"].get(FAST_CAMPAIGN.name)
        if fast is not None:
            mine.insert(place, replace(fast, label=label))
        _put(folder, study, tables.shares(mine, title))
        _save(figures.shares_and_paths(mine), folder / f"{study}.png")
    return show


SHOW = {"notches": _notches, "bases": _bases, "campaign": _campaign, "convergence": _convergence,
        "disturbance": _against_fast("disturbance", "disturbance", "perturbation 0.2", 2),
        "rate": _against_fast("rate", "rate", "5 N/s", 0)}


def _save(figure: Figure, file: Path) -> None:
    figure.savefig(file, metadata={"Software": None})


def _put(folder: Path, place: str, table: str) -> None:
    """Into README.md between the marks of this place, if the folder has one; and to the standard output."""
    print(table, end="")
    if (folder / "README.md").is_file():
        put_between_marks(folder / "README.md", place, table)
