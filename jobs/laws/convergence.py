# SPDX-License-Identifier: GPL-3.0-or-later
"""The slotted plate with each law on several meshes: the load at the last break, and where the crack goes."""
from __future__ import annotations

import csv
import math
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from crackle_readme import put_block
from crackle_runs import ROOT, RunError, markdown, mean_interval, with_keys

LAWS = {"immediate": {},
        # Its cracks arrest and restart repeatedly, and take longer to cross the sections.
        "averaged": {"fracture.length": '"0.6 mm"', "time.duration": '"60 us"'},
        "softening": {"fracture.release": '"softening"', "fracture.toughness": '"150 J/m^2"'}}


@dataclass(frozen=True)
class Run:
    law: str
    spacing: float  # in the region [mm]

    def input_text(self) -> str:
        return slot_text(self.law, self.spacing)


def slot_text(law: str, spacing: float) -> str:
    """The input of the slotted plate with a law, and a spacing [mm] where the crack runs."""
    text = f'"{spacing:g} mm"'
    return with_keys((ROOT / "jobs" / "laws" / "slot.toml").read_text(),
                     {"mesh.notch_spacing": text, "mesh.region.spacing": text, **LAWS[law]})


RUNS = {f"{law}-{spacing:g}": Run(law, spacing)
        for law, spacings in (("immediate", (0.4, 0.3, 0.2, 0.15, 0.1)), ("averaged", (0.4, 0.3, 0.2, 0.15)),
                              ("softening", (0.2, 0.14, 0.1, 0.07, 0.05)))
        for spacing in spacings}
LOAD_RATE = 1.0  # of slot.toml [N/s]
SECTION = 2  # y = 7 mm, where paths are compared


def load_at_run_away(root: h5py.File) -> float:
    """Of a sample [N]; NaN where nothing broke."""
    times = root["breaks/load_time"][:] if "breaks" in root else np.array([])
    return LOAD_RATE * float(times.max()) if times.size else np.nan


def rows(folder: Path) -> list[dict]:
    """One for each sample that is there."""
    found = []
    for name, one in RUNS.items():
        for file in sorted((folder / name / "out" / "samples").glob("*.h5")):
            with h5py.File(file) as root:
                load = load_at_run_away(root)
                if np.isnan(load):
                    continue
                found.append({"law": one.law, "spacing_mm": one.spacing, "sample": int(root.attrs["sample"]),
                              "tetrahedra": root["mesh/tetrahedra"].shape[0],
                              "load_n": load,
                              "z_mm": 1e3 * float(root["summary/position"][0, SECTION]),
                              "seconds_quasi_static": float(root["timing/quasi_static"][()]),
                              "seconds_dynamic": float(root["timing/dynamic"][()]),
                              "steps": int(root["counts/steps"][()])})
    return found


def slope(spacings: np.ndarray, loads: np.ndarray) -> tuple[float, float]:
    """d ln F / d ln h over all samples, and half the width of its 95 % interval."""
    if len(set(spacings)) < 2 or len(spacings) < 3:
        return np.nan, np.nan
    x, y = np.log(spacings) - np.log(spacings).mean(), np.log(loads)
    b = float((x * y).sum() / (x * x).sum())
    residual = y - y.mean() - b * x
    from scipy import stats  # not needed for a run
    return b, float(stats.t.ppf(0.975, len(y) - 2)) * float(np.sqrt((residual**2).sum() / (len(y) - 2) / (x * x).sum()))


def table(all_rows: list[dict]) -> str:
    lines = []
    for law in dict.fromkeys(one["law"] for one in all_rows):
        of_law = [one for one in all_rows if one["law"] == law]
        b, width = slope(np.array([one["spacing_mm"] for one in of_law]), np.array([one["load_n"] for one in of_law]))
        for spacing in dict.fromkeys(one["spacing_mm"] for one in of_law):
            here = [one for one in of_law if one["spacing_mm"] == spacing]

            def values(key: str) -> np.ndarray:
                return np.array([one[key] for one in here], dtype=float)

            load, load_width = mean_interval(values("load_n"))
            z, z_width = mean_interval(values("z_mm") - 25)
            arrived = values("z_mm")[np.isfinite(values("z_mm"))]
            lines.append([law, f"{spacing:g} mm", str(len(here)), f"{values('tetrahedra').mean():,.0f}",
                          f"{load:.1f} ± {load_width:.1f}", f"{b:+.3f} ± {width:.3f}", str(len(arrived)), f"{z:+.3f} ± {z_width:.3f}",
                          f"{arrived.std(ddof=1) if len(arrived) > 1 else math.nan:.3f}",
                          f"{np.median(values('seconds_quasi_static')):.0f} s"])
    return markdown(["law", "spacing", "samples", "tetrahedra", "load at the last break [N]", "d ln load / d ln spacing",
                     "paths that reach y = 7 mm", "their mean, off the slot's axis [mm]", "scatter [mm]", "quasi-static part"], lines)


def draw(all_rows: list[dict], picture: Path) -> None:
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(5.2, 3.4), constrained_layout=True)
    for law, marker in (("immediate", "o"), ("averaged", "s"), ("softening", "^")):
        of_law = [one for one in all_rows if one["law"] == law]
        spacings = sorted({one["spacing_mm"] for one in of_law})
        means = [mean_interval(np.array([one["load_n"] for one in of_law if one["spacing_mm"] == h])) for h in spacings]
        axes.errorbar(spacings, [m for m, _ in means], yerr=[np.nan_to_num(w) for _, w in means], marker=marker, capsize=3,
                      label=law)
    axes.set_xscale("log")
    axes.set_xticks([0.05, 0.1, 0.2, 0.4], ["0.05", "0.1", "0.2", "0.4"])
    axes.minorticks_off()
    axes.set_ylim(bottom=0)
    axes.set_xlabel("spacing [mm]")
    axes.set_ylabel("load at the last break [N]")
    axes.legend()
    figure.savefig(picture, dpi=130)
    plt.close(figure)


def _read_csv(file: Path) -> list[dict]:
    if not file.is_file():
        return []
    with open(file, newline="") as stream:
        return [{key: value if key == "law" else int(value) if key in ("sample", "tetrahedra", "steps") else float(value)
                 for key, value in one.items()} for one in csv.DictReader(stream)]


def keep(folder: Path, kept: Path) -> None:
    """Puts the table into the README, and rows and picture into `kept`; a run that is not in `folder` keeps its rows."""
    put_block("laws", table(keep_rows(folder, kept)))


def keep_rows(folder: Path, kept: Path) -> list[dict]:
    """Writes rows and picture.

    @return all rows
    @raise RunError: a run has fewer samples than are kept of it
    """
    found = rows(folder)
    file = kept / "convergence.csv"
    before = _read_csv(file)
    n_found, n_kept = (Counter((one["law"], one["spacing_mm"]) for one in some) for some in (found, before))
    for (law, spacing), n in n_found.items():
        if n < n_kept[law, spacing]:
            raise RunError(f"{folder / f'{law}-{spacing:g}'} has {n} of the {n_kept[law, spacing]} samples that {file} has; "
                           f"jobs/laws/study {law}-{spacing:g} computes the others")
    found += [one for one in before if (one["law"], one["spacing_mm"]) not in n_found]
    order = [(one.law, one.spacing) for one in RUNS.values()]
    found.sort(key=lambda one: (order.index((one["law"], one["spacing_mm"])), one["sample"]))
    with open(file, "w", newline="") as stream:
        writer = csv.DictWriter(stream, found[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows({key: f"{value:.6g}" if isinstance(value, float) else value for key, value in one.items()}
                         for one in found)
    draw(found, kept / "convergence.png")
    return found
