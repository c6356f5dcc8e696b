# SPDX-License-Identifier: GPL-3.0-or-later
"""The studies' tables, in Markdown."""
from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from crackle_report.statistics import wilson_interval

from .comparing import (DEVELOPED, binomial_test, difference, distance_between_bodies, fisher_test, groups, in_base_frame,
                        leading_notch, leading_path, path_distance, reach, same_share_test)
from .rows import Rows
from .studies import TARGET_LOAD, Run

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
    if n == 0:
        return "–"
    low, high = wilson_interval(count, n, 0.95)
    return f"{100 * count / n:.0f} % ({100 * low:.0f} to {100 * high:.0f})"


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


def depth_interval(all_rows: list[Rows], rounds: int = 200) -> tuple[float, float]:
    """95 % interval of the depth at the target load [mm], by drawing each run's samples anew."""
    generator = np.random.Generator(np.random.Philox(2012))
    depths = []
    for _ in range(rounds):
        drawn = []
        for rows in all_rows:
            chosen = generator.integers(0, len(rows), len(rows))
            drawn.append(replace(rows, sample=rows.sample[chosen], values={"onset_force": rows.values["onset_force"][chosen]}))
        depths.append(median_curve(drawn)[1])
    return float(np.nanquantile(depths, 0.025)), float(np.nanquantile(depths, 0.975))


def comparison(references: dict[str, Rows], runs: list[tuple[Run, Rows]]) -> str:
    """Each setting against the run that it is to be compared with: sample by sample where the bodies are the same."""
    lines = []
    for run, rows in runs:
        reference = references.get(run.reference)
        path, seconds = leading_path(rows), float(np.median(rows.seconds))
        line = [rows.label, str(len(rows)), f"{np.median(rows.values['onset_force']):.0f}", patterns(rows)]
        if reference is None or reference is rows:
            line += [""] * 5
        else:
            line += [reference.label, *_against(reference, rows, run.same_bodies)]
        line += [spread(1e3 * path[:, MIDDLE], ".2f"), spread(rows.values["crack_area"] * 1e6, ".0f"),
                 spread(rows.values["crack_speed_ratio"], ".2f"), str(int((rows.values["bifurcations"] > 0).sum())),
                 f"{np.nanmax(rows.values['energy_error']):.0e}",
                 f"{np.median(rows.values['forces']):.0f}, {seconds:.0f} s"]
        lines.append(line)
    titles = ["setting", "samples", "onset [N], median", "one / two cracks / other / none", "against", "onset [N]",
              "z of the leading path at mid-width [mm]", "one crack", "same bodies"]
    titles += ["z of the leading path at mid-width, mean [mm]", "crack area [mm²]", "speed over Rayleigh's", "with branching",
               "largest energy error", "force evaluations, median time"]
    return markdown(titles, lines)


def _against(reference: Rows, rows: Rows, same_bodies: bool) -> list[str]:
    """Differences to the reference with their 95 % intervals, of pairs where the bodies are the same."""
    if same_bodies:
        _, first, second = np.intersect1d(reference.sample, rows.sample, return_indices=True)
    else:
        first, second = np.arange(len(reference)), np.arange(len(rows))
    onsets = [one.values["onset_force"][chosen] for one, chosen in ((reference, first), (rows, second))]
    paths = [leading_path(one)[chosen] for one, chosen in ((reference, first), (rows, second))]
    single = [one.values["pattern"][chosen] == 1 for one, chosen in ((reference, first), (rows, second))]
    cells = [plus_minus(difference(*onsets, same_bodies), 1),
             plus_minus(difference(1e3 * paths[0][:, MIDDLE], 1e3 * paths[1][:, MIDDLE], same_bodies), 2)]
    counts = f"{single[1].sum()} of {len(second)} against {single[0].sum()} of {len(first)}"
    if not same_bodies:
        p = fisher_test(int(single[1].sum()), len(second), int(single[0].sum()), len(first))
        return [*cells, f"{counts}, p = {p:.2f}", ""]
    more, fewer = int((single[1] & ~single[0]).sum()), int((single[0] & ~single[1]).sum())
    lead = leading_notch(reference)[first] == leading_notch(rows)[second]
    equal = np.abs(onsets[0] - onsets[1]) < 0.01
    return [*cells, f"{counts}, p = {binomial_test(more, more + fewer):.2f}",
            f"onset equal in {equal.sum()}, notch that leads in {lead.sum()}, pattern in {len(first) - more - fewer} of "
            f"{len(first)}; paths {1e3 * np.nanmedian(path_distance(*paths)[lead]):.2f} mm apart, those of different bodies "
            f"{1e3 * distance_between_bodies(reference):.2f} mm"]


def plus_minus(estimate: tuple[float, float], digits: int) -> str:
    return f"{estimate[0]:+.{digits}f} ± {estimate[1]:.{digits}f}"


def counts(rows: Rows, early: bool) -> tuple[int, int, int]:
    """Samples with one crack, with two and with neither; if early by how far the cracks are rows.EARLY after the start."""
    return groups(rows, DEVELOPED, early=True) if early else (rows.share(1), rows.share(2), rows.share(3))


def shares(all_rows: list[Rows], title: str, early: bool) -> str:
    """Counts as shares with Wilson's 95 % intervals, and spread of the paths."""
    lines = []
    for rows in all_rows:
        cells = [rows.label, str(len(rows)), spread(rows.values["onset_force"], ".1f")]
        cells += [share(count, len(rows)) for count in counts(rows, early)]
        cells += [spread(reach(rows, early)[1], ".2f"), spread(1e3 * leading_path(rows)[:, MIDDLE], ".2f"),
                  f"{1e3 * distance_between_bodies(rows):.2f}", spread(rows.values["crack_speed_ratio"], ".2f"),
                  str(int((rows.values["bifurcations"] > 0).sum()))]
        lines.append(cells)
    return markdown([title, "samples", "onset [N]", "one crack", "two cracks", "other",
                     "share of its ligament that the second crack crosses", "z of the leading path at mid-width [mm]",
                     "distance of two samples' paths, median [mm]", "speed over Rayleigh's", "with branching"], lines)


def group_limits(rows: Rows) -> str:
    """What becomes of the groups with other limits."""
    lines = []
    for limit in (0.3, 0.35, 0.4, 0.45, 0.5):
        one, two, other = groups(rows, limit)
        lines.append([f"{limit:g}", *(share(count, len(rows)) for count in (one, two)), str(other)])
    return markdown(["share of the ligament from which a second crack counts", "one crack", "two cracks", "other"], lines)


def bases(all_rows: list[Rows]) -> str:
    """What depends on the base distribution of mother points."""
    lines, hits, totals = [], [], []
    for rows in all_rows:
        lead = leading_notch(rows)
        hits.append(int((lead == 0).sum()))
        totals.append(int((lead >= 0).sum()))
        lines.append([rows.label, str(len(rows)), f"{np.median(rows.values['onset_force']):.0f}", patterns(rows),
                      str(hits[-1]), str(totals[-1] - hits[-1])])
    table = markdown(["`seed`", "samples", "onset [N], median", "one / two cracks / other / none", "lower notch leads",
                      "upper notch leads"], lines)
    n, k = np.array(totals[1:]), np.array(hits[1:])
    mean, half = k.sum() / n.sum(), difference(np.zeros(len(n)), k / n, paired=True)[1]
    between = math.sqrt(max(0.0, (k / n).var(ddof=1) - mean * (1 - mean) * (1 / n).mean()))
    medians = np.array([np.mean(rows.values["onset_force"]) for rows in all_rows[1:]])
    within = np.mean([rows.values["onset_force"].var(ddof=1) / len(rows) for rows in all_rows[1:]])
    return table + (
        f"\nThe same share with all bases: p {_small(same_share_test(hits, totals))}, without the first "
        f"{_small(same_share_test(hits[1:], totals[1:]))}. Without the first the lower notch leads in {100 * mean:.0f} % of the "
        f"samples, ± {100 * half:.0f} % at 95 % confidence of the mean over bases; beyond the chance of ten samples this share "
        f"scatters by {100 * between:.0f} % from base to base, and the mean onset by "
        f"{math.sqrt(max(0.0, medians.var(ddof=1) - within)):.1f} N.\n")


def _small(p: float) -> str:
    return "< 0.001" if p < 0.001 else f"= {p:.3f}"


def turning(unturned: Rows, rows: Rows) -> str:
    """The same samples with their meshes as the base lies and set into the body at random."""
    lines = []
    for label, chosen in (("as it lies, or reflected through the thickness", rows.values["turned"] == 0),
                          ("turned by 180 degrees", rows.values["turned"] == 1)):
        _, first, second = np.intersect1d(unturned.sample, rows.sample[chosen], return_indices=True)
        second = np.flatnonzero(chosen)[second]
        onsets = [one.values["onset_force"][i] for one, i in ((unturned, first), (rows, second))]
        equal = np.abs(onsets[0] - onsets[1]) < 0.1
        lead = leading_notch(unturned)[first] == in_base_frame(rows, leading_notch(rows))[second]
        lines.append([label, str(len(first)), str(int(equal.sum())), plus_minus(difference(*onsets, paired=True), 1),
                      str(int(lead.sum()))])
    return markdown(["mesh", "samples", "onset equal to 0.1 N", "difference of the onset [N]",
                     "same notch of the base leads"], lines)


def symmetry(rows: Rows) -> str:
    """Which notch leads: by its place in the body, where the supports could make a difference, and by its place in the base."""
    lead, one = leading_notch(rows), rows.values["pattern"] == 1
    lines = []
    for label, chosen in (("one crack", one), ("all", np.ones(len(rows), bool))):
        for place, notch in (("in the body", lead), ("of the base, turned back", in_base_frame(rows, lead))):
            first, second = int((notch[chosen] == 0).sum()), int((notch[chosen] == 1).sum())
            lines.append([label, place, str(first), str(second), share(first, first + second),
                          f"{binomial_test(first, first + second):.2g}"])
    return markdown(["samples", "notch", "lower leads", "upper leads", "share of the lower one", "p of equal chances"], lines)
