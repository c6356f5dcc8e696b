# SPDX-License-Identifier: GPL-3.0-or-later
"""The command jobs/paper/campaigns: the paper beside its model and ours, row by row."""
from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Callable

import crackle
import numpy as np
import pandas as pd
from crackle.files import ENSEMBLE_KIND, results
from crackle.inference import median_interval
from crackle_readme import put_block
from crackle_runs import markdown
from shares import CONFIDENCE, share_text

PAPER = Path(__file__).resolve().parent
ENSEMBLES = {"its model": PAPER, "its model, shared base": PAPER / "shared-base", "ours": PAPER / "round-slots"}
SYMMETRIC = 0.8  # overlap from which on two cracks count as a symmetric pair

Cell = Callable[[crackle.Ensemble], str]


def share(column: str, is_one: Callable[[pd.Series], pd.Series]) -> Cell:
    """The share of the samples, with its interval by Wilson."""
    def text(ensemble: crackle.Ensemble) -> str:
        if column not in ensemble.samples:  # of an older version
            return "–"
        return share_text(int(is_one(done(ensemble)[column]).sum()), len(ensemble.done), decimals=1)
    return text


def median(column: str, form: str, unit: str = "") -> Cell:
    """The median of a result, with its interval."""
    def text(ensemble: crackle.Ensemble) -> str:
        values = done(ensemble)[column].dropna().to_numpy()
        interval = median_interval(values, np.arange(len(values)), CONFIDENCE)
        return f"{np.median(values):{form}}{unit} ({interval.lower:{form}} to {interval.upper:{form}})"
    return text


def done(ensemble: crackle.Ensemble) -> pd.DataFrame:
    return ensemble.samples.loc[ensemble.done]


def arrival(ensemble: crackle.Ensemble) -> str:
    """When leading cracks come to the last section on their way [µs]: the median, and 95 % of the samples; how many get there, if not all."""
    leads = done(ensemble).leading_notch.to_numpy()
    times = ensemble.paths.arrival_time.sel(sample=ensemble.done).to_numpy()
    there = [1e6 * times[i, leader, -1 if leader == 0 else 0] for i, leader in enumerate(leads) if leader >= 0]
    number = int(np.isfinite(there).sum())
    low, middle, high = np.nanquantile(there, (0.025, 0.5, 0.975))
    return f"{middle:.0f} µs ({low:.0f} to {high:.0f})" + ("" if number == len(leads) else f", {number} of {len(leads)}")


def half_width(ensemble: crackle.Ensemble) -> str:
    """The widest interval of the mean leading path at a section, half of it."""
    with results(ensemble.folder / "ensemble.h5", ENSEMBLE_KIND) as root:
        return f"± {1e3 * np.nanmax(root['statistics/leader/z_half_width'][0]):.2f} mm"


ROWS: tuple[tuple[str, str, Cell], ...] = (
    ("onset t₀, median", "76.18 s, both samples shown", median("onset_time", ".2f", " s")),
    ("its load", "516 N with the 135 N at the start", median("onset_force", ".1f", " N")),
    ("one crack", "one group, simulated and tested", share("pattern", lambda pattern: pattern == "one crack")),
    ("two cracks", "the other group; in experiments only roughly symmetric", share("pattern", lambda pattern: pattern == "two cracks")),
    ("symmetric pairs", "some; none of 16 experiments", share("overlap", lambda values: values > SYMMETRIC)),
    ("kinks", "visible", share("kinks", lambda values: values > 0)),
    ("forks in the projection", "4 of the 8 samples shown (22 to 78 %); some experiments, at their end",
     share("bifurcations_projected", lambda values: values > 0)),
    ("forks in space", "", share("bifurcations", lambda values: values > 0)),
    ("with branches from 2 mm", "", share("long_bifurcations", lambda values: values > 0)),
    ("largest speed / c_R, median", "not given; 0.48 where epoxy bifurcates, Suzuki et al. 2007", median("crack_speed_ratio", ".3f")),
    ("leading crack 7 mm before the far edge, median and 95 % of samples", "between t₀ + 70 and 100 µs in photographs", arrival),
    ("energy per traced area, median", "not given", median("effective_toughness", ".0f", " J/m²")),
    ("mean leading path, 95 %, at its worst section", "200 samples are said to be enough", half_width),
)


def table() -> str:
    ensembles = {name: crackle.open(folder) for name, folder in ENSEMBLES.items()}
    lines = [("samples", "200", *(str(len(ensemble.done)) for ensemble in ensembles.values())),
             *((title, paper, *(cell(ensemble) for ensemble in ensembles.values())) for title, paper, cell in ROWS)]
    return markdown(("", "paper", *ensembles), lines)


def main() -> int:
    parser = argparse.ArgumentParser(prog="campaigns", description="Prints the paper beside the ensembles stored in jobs/paper: its model, with "
                                     "base points of each sample's own and with a shared base, and ours. Brackets are 95 % intervals.")
    parser.add_argument("--keep", action="store_true", help="put the table into jobs/paper/README.md")
    arguments = parser.parse_args()
    text = table()
    print(text, end="")
    if arguments.keep:
        put_block("campaigns", text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
