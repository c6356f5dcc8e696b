# SPDX-License-Identifier: GPL-3.0-or-later
"""The studies' tables, in Markdown."""
from __future__ import annotations

import math

import numpy as np

from crackle_report.confidence import running_half_width
from crackle_report.photoelasticity import STRESS_OPTIC, WAVELENGTH
from crackle_report.statistics import wilson_interval

from .comparing import (binomial_test, distance_between_bodies, fisher_test, leading_notch, leading_path,
                        path_distance, permutation_test, same_share_test, settled)
from .fringes import FringeSeries
from .rows import Rows
from .studies import TARGET_LOAD

MIDDLE = 2  # of the sections


def markdown(titles: list[str], lines: list[list[str]]) -> str:
    return "".join(f"| {' | '.join(line)} |\n" for line in [titles, ["---"] * len(titles), *lines])


def patterns(rows: Rows) -> str:
    return " / ".join(str(rows.share(p)) for p in (1, 2, 3, 0))


def spread(values: np.ndarray, form: str) -> str:
    """Mean and standard deviation."""
    values = values[np.isfinite(values)]
    deviation = values.std(ddof=1) if len(values) > 1 else math.nan
    return f"{values.mean():{form}} ± {deviation:{form}}" if len(values) else "–"


def share(count: int, n: int) -> str:
    """In percent, with Wilson's 95 % interval."""
    low, high = wilson_interval(count, n, 0.95)
    return f"{100 * count / n:.0f} % ({100 * low:.0f} to {100 * high:.0f})"


def quartiles(values: np.ndarray, digits: int) -> str:
    low, middle, high = np.quantile(values, [0.25, 0.5, 0.75])
    return f"median {middle:.{digits}f} (half of the samples {low:.{digits}f} to {high:.{digits}f})"


def notches(all_rows: list[Rows]) -> str:
    lines = []
    for rows in all_rows:
        load = rows.values["onset_force"]
        depth, distance = rows.label.split(", ")
        lines.append([distance, depth, str(len(rows)), f"{np.median(load):.0f} ({load.min():.0f} to {load.max():.0f})",
                      patterns(rows), spread(rows.values["overlap"], ".2f"), spread(rows.values["crack_speed_ratio"], ".2f")])
    return markdown(["distance", "depth", "samples", "onset [N], median (range)", "one / two cracks / other / none",
                     "overlap", "speed over Rayleigh's"], lines)


def median_curve(all_rows: list[Rows]) -> tuple[np.ndarray, float]:
    """A parabola through all onset loads of rows with one distance over depth [mm], by least absolute deviations as
    medians have them; and the depth at which it is at the target load.
    """
    depth = np.concatenate([np.full(len(rows), float(rows.label.split(" ")[0])) for rows in all_rows])
    load = np.concatenate([rows.values["onset_force"] for rows in all_rows])
    weight = np.ones(len(load))
    for _ in range(200):  # iteratively reweighted least squares
        curve = np.polyfit(depth, load, 2, w=np.sqrt(weight))
        weight = 1 / np.maximum(np.abs(load - np.polyval(curve, depth)), 1e-3)
    roots = np.roots(np.polysub(curve, [TARGET_LOAD]))
    inside = roots[np.isreal(roots) & (roots > depth.min()) & (roots < depth.max())].real
    return curve, float(inside[0]) if len(inside) else math.nan


def comparison(reference: Rows, others: list[Rows]) -> str:
    """Settings against the reference: on the same bodies sample by sample, and as ensembles."""
    lines = []
    for rows in [reference, *others]:
        path = leading_path(rows)
        line = [rows.label, str(len(rows)), spread(rows.values["onset_force"], ".1f"), patterns(rows)]
        line.append(_same_bodies(reference, rows) if rows is not reference
                    else f"others: {1e3 * distance_between_bodies(rows):.2f} mm")
        line.append(spread(1e3 * (path[:, MIDDLE]), ".2f"))
        if rows is reference:
            line += ["", ""]
        else:
            line.append(f"{permutation_test(leading_path(reference)[:, MIDDLE], path[:, MIDDLE]):.2f}")
            line.append(f"{fisher_test(reference.share(1), len(reference), rows.share(1), len(rows)):.2f}")
        line += [spread(rows.values["crack_area"] * 1e6, ".0f"), spread(rows.values["crack_speed_ratio"], ".2f"),
                 f"{rows.values['energy_error'].max():.0e}", f"{rows.seconds.mean():.0f} s"]
        lines.append(line)
    titles = ["setting", "samples", "onset [N]", "one / two cracks / other / none",
              "same bodies: onset equal, notch that leads equal, distance of paths"]
    titles += ["z of the leading path at mid-width [mm]", "p of equal means", "p of equal shares", "crack area [mm²]",
               "speed over Rayleigh's", "largest energy error", "core time per sample"]
    return markdown(titles, lines)


def _same_bodies(reference: Rows, rows: Rows) -> str:
    _, first, second = np.intersect1d(reference.sample, rows.sample, return_indices=True)
    onset = np.abs(reference.values["onset_force"][first] - rows.values["onset_force"][second]) < 0.01
    lead = leading_notch(reference)[first] == leading_notch(rows)[second]
    distance = path_distance(leading_path(reference)[first], leading_path(rows)[second])[lead]
    n = len(first)
    return f"{onset.sum()} of {n}, {lead.sum()} of {n}, {1e3 * np.nanmedian(distance):.2f} mm"


def shares(all_rows: list[Rows], title: str) -> str:
    """Shares with Wilson's 95 % intervals, and spread of the paths."""
    lines = []
    for rows in all_rows:
        cells = [rows.label, str(len(rows)), spread(rows.values["onset_force"], ".1f")]
        cells += [share(rows.share(pattern), len(rows)) for pattern in (1, 2, 3)]
        cells += [spread(rows.values["overlap"], ".2f"), spread(1e3 * leading_path(rows)[:, MIDDLE], ".2f"),
                  f"{1e3 * distance_between_bodies(rows):.2f}", str(int((rows.values["bifurcations"] > 0).sum()))]
        lines.append(cells)
    return markdown([title, "samples", "onset [N]", "one crack", "two cracks", "other", "overlap",
                     "z of the leading path at mid-width [mm]", "distance of two samples' paths, median [mm]",
                     "with branching"], lines)


def bases(all_rows: list[Rows]) -> str:
    """What depends on the base distribution of mother points."""
    lines, hits, totals = [], [], []
    for rows in all_rows:
        lead = leading_notch(rows)
        hits.append(int((lead == 0).sum()))
        totals.append(int((lead >= 0).sum()))
        lines.append([rows.label, str(len(rows)), f"{np.median(rows.values['onset_force']):.0f}", patterns(rows),
                      str(hits[-1]), str(totals[-1] - hits[-1])])
    shares = np.array(hits) / np.array(totals)
    lines.append(["all", str(sum(len(rows) for rows in all_rows)), "", "",
                  f"{100 * shares.mean():.0f} ± {100 * shares.std(ddof=1):.0f} % of a base's samples",
                  f"p of the same share with all bases: {same_share_test(hits, totals):.4f}"])
    return markdown(["`seed`", "samples", "onset [N], median", "one / two cracks / other / none", "lower notch leads",
                     "upper notch leads"], lines)


def symmetry(rows: Rows) -> str:
    lead, one = leading_notch(rows), rows.values["pattern"] == 1
    lines = []
    for label, chosen in (("one crack", one), ("all", np.ones(len(rows), bool))):
        first, second = int((lead[chosen] == 0).sum()), int((lead[chosen] == 1).sum())
        lines.append([label, str(first), str(second), f"{binomial_test(first, first + second):.2f}"])
    return markdown(["samples", "lower notch leads", "upper notch leads", "p of a fair coin"], lines)


SETTLED = 0.05e-3  # [m]


def against_paper(rows: Rows, fringes: list[FringeSeries]) -> str:
    """The paper's findings beside those of the campaign."""
    n, values, lead = len(rows), rows.values, leading_notch(rows)
    one = values["pattern"] == 1
    first, second = int((lead[one] == 0).sum()), int((lead[one] == 1).sum())
    path = leading_path(rows)
    half_width = running_half_width(path[:, MIDDLE], 0.95)
    lines = [
        ["onset t₀", "76.179191 s at 5 N/s, the same for both samples shown",
         f"{quartiles(values['onset_time'], 1)} s; the notches' depth was chosen for this"],
        ["groups", "one main crack from either notch; two, more or less anti-symmetric; shares not given",
         f"one {share(rows.share(1), n)}; two {share(rows.share(2), n)}; other {rows.share(3)} of {n}. The groups are not "
         f"apart: the paths' overlap, {spread(values['overlap'], '.2f')}, has one hump"],
        ["notch that the single crack starts from", "either",
         f"lower {first}, upper {second}; p = {binomial_test(first, first + second):.2f} for equal chances"],
        ["bends and kinks", "seen", f"kinks in {int((values['kinks'] > 0).sum())} of {n}"],
        ["bifurcation", "in 4 of the 8 samples shown", f"in {int((values['bifurcations'] > 0).sum())} of {n}"],
        ["largest crack speed over Rayleigh's", "not given", spread(values["crack_speed_ratio"], ".2f")],
    ]
    if fringes:
        start = np.array([one.roughness[0] for one in fringes])
        end = np.array([one.roughness[-1] for one in fringes])
        alike = np.array([one.likeness[[0, -1]] for one in fringes])
        lines += [
            ["fringes before the cracks run", "like the experiment's",
             f"alike from sample to sample: correlation {spread(alike[:, 0], '.3f')} ({len(fringes)} samples; no experiment here)"],
            ["fringes afterwards", "blurred",
             f"roughness {np.mean(end / start):.1f} times that at t₀ after {1e6 * fringes[0].time[-1]:.0f} µs; correlation "
             f"{spread(alike[:, 1], '.2f')}"]]
    lines += [
        ["samples", "200, by the convergence of the mean crack path",
         f"{n}; the mean of the leading crack stays within {1e3 * SETTLED:.2f} mm of that of all at every section from "
         f"{settled(path, SETTLED)} samples on; half width of its 95 % interval at mid-width {1e3 * half_width[-1]:.3f} mm"],
        ["time", "not given", f"{rows.seconds.sum() / 3600:.1f} core-hours, {rows.seconds.mean():.0f} s per sample on one core"],
        ["depth and distance of the notches", "not given", "5.5 mm, 5 mm between their mid-planes (calibrated)"],
        ["β, K_f, τ_f", "2, 1e-8 without unit, the time step",
         "2, 1e-8 MPa² s, all the time over the strength (`memory = \"cumulative\"`)"],
        ["stress-optic coefficient, wavelength", "not given",
         f"{STRESS_OPTIC:.2g} 1/Pa (typical of epoxy), {1e9 * WAVELENGTH:.0f} nm"],
    ]
    return markdown(["", "paper", "`crackle`"], lines)
