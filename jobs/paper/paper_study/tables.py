# SPDX-License-Identifier: GPL-3.0-or-later
"""The studies' tables, in Markdown."""
from __future__ import annotations

import math
from dataclasses import replace
from typing import Callable, Iterable

import numpy as np

from crackle_runs import markdown

from .comparing import (DEVELOPED, binomial_test, difference, distances, groups, in_base_frame, leading_notch, leading_path,
                        mean_interval, path_distance, reach, same_path_test, same_share_test, scatter_of_means,
                        share_difference, share_interval)
from .course import LONG_ARM
from .rows import SECTIONS, Rows
from .studies import FIRST_BASE, TARGET_LOAD, Run


def patterns(rows: Rows) -> str:
    return " / ".join(str(rows.share(p)) for p in (1, 2, 3, 0))


def spread(values: np.ndarray, form: str) -> str:
    """Mean and standard deviation."""
    values = values[np.isfinite(values)]
    deviation = values.std(ddof=1) if len(values) > 1 else math.nan
    return f"{values.mean():{form}} ± {deviation:{form}}" if len(values) else "–"


def share_of(rows: Rows, name: str) -> str:
    """Of the samples in which this is more than none."""
    return share(int((rows.values[name] > 0).sum()), len(rows)) if rows.knows(name) else "–"


def share(count: int, n: int) -> str:
    """In percent, with Wilson's 95 % interval."""
    if n == 0:
        return "–"
    low, high = share_interval(count, n)
    return f"{100 * count / n:.0f} % ({100 * low:.0f} to {100 * high:.0f})"


def notches(all_rows: list[Rows]) -> str:
    lines = []
    for rows in all_rows:
        load = rows.values["onset_force"]
        depth, distance = rows.label.split(", ")
        lines.append([distance, depth, str(len(rows)), f"{np.median(load):.0f} ({load.min():.0f} to {load.max():.0f})",
                      patterns(rows), spread(rows.values["overlap"], ".2f"), spread(rows.values["crack_speed_ratio"], ".2f")])
    return markdown(["distance", "depth", "samples", "onset [N], median (range)", "one / two cracks / other / none",
                     "overlap", "speed / c_R"], lines)


def branching(all_rows: list[Rows]) -> str:
    """What makes cracks fork."""
    lines = []
    for rows in all_rows:
        v = rows.values
        lines.append([
            rows.label, str(len(rows)), f"{np.median(v['onset_force']):.0f} ({v['onset_force'].min():.0f} to {v['onset_force'].max():.0f})",
            f"{np.median(v['onset_time']):.1f}", patterns(rows), *(share_of(rows, name) for name in ("bifurcations_projected", "long_forks", "bifurcations")),
            spread(v["crack_speed_ratio"], ".2f"), spread(v["overlap"], ".2f"), f"{np.median(rows.seconds):.0f} s"])
    return markdown(["setting", "samples", "onset [N], median (range)", "t₀ [s], median", "one / two cracks / other / none",
                     "with forks in the projection", f"with arms of {1e3 * LONG_ARM:g} mm", "with forks in space",
                     "speed / c_R", "overlap", "median time"], lines)


def by_eye(counts: list[dict[str, str]], all_rows: list[Rows]) -> str:
    """The program's count of forks in the projection beside two counts by eye of the same pictures, without its marks.

    @param counts lines of forks-by-eye.csv: run, sample, and of each reader the number of forks and whether it is doubtful
    """
    found = {(rows.name, int(sample)): int(count) for rows in all_rows
             for sample, count in zip(rows.sample, rows.values["bifurcations_projected"])}
    lines = [line for line in counts if (line["run"], int(line["sample"])) in found]
    program = np.array([found[line["run"], int(line["sample"])] > 0 for line in lines], bool)
    readers = {name: np.array([int(line[name]) > 0 for line in lines], bool) for name in ("first", "second")}
    sure = np.array([line["first_doubtful"] == line["second_doubtful"] == "0" for line in lines], bool)
    pairs = [("program", "first reader", program, readers["first"]), ("program", "second reader", program, readers["second"]),
             ("first reader", "second reader", readers["first"], readers["second"])]
    table = []
    for one, other, a, b in pairs:
        for label, chosen in (("all", np.ones(len(lines), bool)), ("neither reader in doubt", sure)):
            x, y = a[chosen], b[chosen]
            table.append([f"{one}, {other}", label, str(len(x)), str(int((x & y).sum())), str(int((~x & ~y).sum())),
                          str(int((x & ~y).sum())), str(int((~x & y).sum())), share(int((x == y).sum()), len(x)),
                          f"{_kappa(x, y):.2f}"])
    return markdown(["who", "pictures", "number", "both see forks", "neither does", "only the former", "only the latter",
                     "agree", "Cohen's kappa"], table)


def _kappa(one: np.ndarray, other: np.ndarray) -> float:
    """Agreement beyond what two independent readers with these shares would have."""
    chance = one.mean() * other.mean() + (1 - one.mean()) * (1 - other.mean()) if len(one) else 1
    return ((one == other).mean() - chance) / (1 - chance) if chance < 1 else math.nan


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
    inside = inside[np.polyval(np.polyder(curve), inside) < 0]  # the deeper the notches, the lower the load
    return curve, float(inside[0]) if len(inside) else math.nan


def depth_interval(all_rows: list[Rows], base_scatter: float, rounds: int = 200) -> tuple[float, float]:
    """95 % interval of the depth at the target load [mm], by drawing each run's samples anew.

    @param base_scatter standard deviation of the onset from base to base [N]: each run has a base of its own
    """
    generator = np.random.Generator(np.random.Philox(2012))
    depths = []
    for _ in range(rounds):
        drawn = []
        for rows in all_rows:
            chosen = generator.integers(0, len(rows), len(rows))
            load = rows.values["onset_force"][chosen] + base_scatter * generator.standard_normal()
            drawn.append(replace(rows, sample=rows.sample[chosen], values={"onset_force": load}))
        depths.append(median_curve(drawn)[1])
    if np.isnan(depths).mean() > 0.01:  # curves that do not come to the load
        return math.nan, math.nan
    return float(np.nanquantile(depths, 0.025)), float(np.nanquantile(depths, 0.975))


def comparison(references: dict[str, Rows], runs: list[tuple[Run, Rows]]) -> str:
    """Each setting against the run that it is to be compared with, sample by sample: the bodies are the same."""
    lines = []
    for run, rows in runs:
        reference = references.get(run.reference)
        line = [rows.label, str(len(rows)), f"{np.median(rows.values['onset_force']):.0f}", patterns(rows)]
        line += [""] * 7 if reference is None or reference is rows else [reference.label, *_against(reference, rows)]
        lines.append(line + _run_figures(rows))
    titles = ["setting", "samples", "onset [N], median", "one / two cracks / other / none", "against", "onset [N]",
              "share that the second crack crosses", "mean leading path, where it differs most [mm]", "samples with one crack",
              "with forks in the projection", "same bodies"]
    return markdown(titles + RUN_TITLES, lines)


RUN_TITLES = ["crack area [mm²]", "speed / c_R", "with branching", "largest energy error",
              "force evaluations, median time"]


def _run_figures(rows: Rows) -> list[str]:
    return [spread(rows.values["crack_area"] * 1e6, ".0f"), spread(rows.values["crack_speed_ratio"], ".2f"),
            str(int((rows.values["bifurcations"] > 0).sum())), f"{np.nanmax(rows.values['energy_error']):.0e}",
            f"{np.median(rows.values['forces']):.0f}, {np.median(rows.seconds):.0f} s"]


def _against(reference: Rows, rows: Rows) -> list[str]:
    """Differences to the reference with their 95 % intervals."""
    _, first, second = np.intersect1d(reference.sample, rows.sample, return_indices=True)

    def pair(value: Callable[[Rows], np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        return value(reference)[first], value(rows)[second]

    onsets, reaches, paths = pair(onset), pair(second_reach), pair(leading_path)
    single, forked, (lead, other_lead) = pair(has_one_crack), pair(lambda rows: rows.forked), pair(leading_notch)
    equal = np.abs(onsets[0] - onsets[1]) < 0.01
    return [plus_minus(difference(*onsets, paired=True), 1), plus_minus(difference(*reaches, paired=True), 3),
            _path_difference(*paths),
            _share_difference(*single),
            _share_difference(*forked) if reference.knows("bifurcations_projected") and rows.knows("bifurcations_projected") else "–",
            f"onset equal in {equal.sum()}, notch that leads in {((lead == other_lead) & (lead >= 0)).sum()}, pattern in {(single[0] == single[1]).sum()}; paths "
            f"{1e3 * np.nanmedian(path_distance(*paths)):.2f} mm apart, those of different bodies "
            f"{1e3 * np.nanmedian(distances(leading_path(reference))):.2f} mm"]


def onset(rows: Rows) -> np.ndarray:
    return rows.values["onset_force"]


def second_reach(rows: Rows) -> np.ndarray:
    return reach(rows)[1]


def has_one_crack(rows: Rows) -> np.ndarray:
    return rows.values["pattern"] == 1


def _none_some_all(bases_of: list[Rows]) -> str:
    """In how many bases no sample has a fork in the projection, some have, and all."""
    shares = [rows.forked.mean() for rows in bases_of]
    return f"{sum(s == 0 for s in shares)} / {sum(0 < s < 1 for s in shares)} / {sum(s == 1 for s in shares)}"


def _share_difference(one: np.ndarray, other: np.ndarray) -> str:
    value, low, high = (100 * part for part in share_difference(one, other))
    return f"{other.sum()} against {one.sum()} of {len(one)}, {value:+.0f} % ({low:+.0f} to {high:+.0f})"


def _path_difference(one: np.ndarray, other: np.ndarray) -> str:
    """Of paired paths: mean difference at the section where it is largest, and p of none at any section."""
    all_differences = [difference(*pair, paired=True) for pair in zip(1e3 * one.T, 1e3 * other.T)]
    if all(math.isnan(mean) for mean, _ in all_differences):
        return "–"
    largest = int(np.nanargmax([abs(mean) for mean, _ in all_differences]))
    return f"{plus_minus(all_differences[largest], 2)} at {SECTIONS[largest]} mm; p {_small(same_path_test(other - one))}"


def plus_minus(estimate: tuple[float, float], digits: int) -> str:
    return f"{estimate[0]:+.{digits}f} ± {estimate[1]:.{digits}f}"


def rates(slow: Rows, all_rows: list[Rows]) -> str:
    """Rates of loading against slow loading of the same bodies."""
    usual = float(np.nanmedian(slow.values["other_when_far"]))
    lines = []
    for rows in (slow, *all_rows):
        _, first, second = np.intersect1d(slow.sample, rows.sample, return_indices=True)
        other, lead = rows.values["other_when_far"], leading_notch(rows)
        pair = slow.values["other_when_far"][first], other[second]
        far = np.isfinite(other)
        leads = np.stack([leading_notch(slow)[first], lead[second]])
        leads = leads[:, (leads >= 0).all(axis=0)]
        lines.append([
            rows.label, str(len(rows)), spread(rows.values["onset_force"], ".0f"), spread(other, ".2f"),
            "" if rows is slow else plus_minus(difference(*pair, paired=True), 3),
            share(int((other[far] > usual).sum()), int(far.sum())), f"{(lead == 0).sum()} / {(lead == 1).sum()}",
            "" if rows is slow else f"{(leads[0] == leads[1]).sum()} of {leads.shape[1]}",
            patterns(rows), spread(second_reach(rows), ".2f"), spread(rows.values["overlap"], ".2f"),
            share_of(rows, "bifurcations_projected"), *_run_figures(rows)[:4]])
    return markdown(["rate", "samples", "load at the notches when the first crack starts [N]",
                     "share that the other crack has crossed when the first one has crossed 0.8", "against 5 N/s",
                     f"more than the {usual:.2f} of 5 N/s", "lower / upper notch leads", "same notch as at 5 N/s",
                     "at the end: one / two cracks / other / none", "share that the second crack crosses",
                     "overlap of one crack with the other turned", "with forks in the projection", *RUN_TITLES[:4]], lines)


def on_bases(title: str, usual: str, settings: list[tuple[str, list[Rows]]], same_bases: bool) -> str:
    """Settings of the mesh, each on several bases; the unit of comparison is the base.

    @param usual label of the setting that the others are compared with
    @param same_bases: runs of one seed have the same base, whatever the setting
    """
    reference = dict(settings)[usual]
    lines = []
    for label, bases_of in settings:
        others = None if label == usual else reference
        inside = math.sqrt(np.mean([onset(rows).var(ddof=1) for rows in bases_of]))
        between, limit = scatter_of_means([onset(rows) for rows in bases_of])

        def over(value: Callable[[Rows], np.ndarray], digits: int) -> str:
            return _over_bases(value, bases_of, others, digits, same_bases)

        counted = all(rows.knows("bifurcations_projected") for rows in (*bases_of, *reference))
        paths = [leading_path(rows) for rows in bases_of]
        same = np.concatenate([distances(one) for one in paths])
        different = np.concatenate([distances(one, other) for i, one in enumerate(paths) for other in paths[:i]])
        lines.append([label, f"{len(bases_of)} × {round(np.mean([len(rows) for rows in bases_of]))}",
                      over(onset, 1), f"{inside:.1f}, {between:.1f} (up to {limit:.0f})",
                      over(lambda rows: 100.0 * has_one_crack(rows), 0), over(second_reach, 3),
                      *((over(lambda rows: 100.0 * rows.forked, 0), _none_some_all(bases_of)) if counted else ("–", "–")),
                      f"{1e3 * np.nanmedian(same):.2f}, {1e3 * np.nanmedian(different):.2f}", _same_lead(bases_of),
                      *_run_figures(merged(bases_of))])
    return markdown([title, "bases × samples", "onset [N]", "its scatter within, between bases (95 % limit) [N]", "samples with one crack [%]",
                     "share that the second crack crosses", "samples with forks in the projection [%]",
                     "bases of which none, some, all samples fork", "paths apart: same, different bases [mm]",
                     "pairs of one base in which the same notch of the base leads", *RUN_TITLES], lines)


def _over_bases(value: Callable[[Rows], np.ndarray], bases_of: list[Rows], others: list[Rows] | None, digits: int,
                same_bases: bool) -> str:
    """Mean of the bases' means, and its difference to that of other bases, or to the same bases' with another setting."""
    means, other_means = ({rows.name.rpartition("-")[2]: value(rows).mean() for rows in some} for some in (bases_of, others or []))
    text = f"{np.mean(list(means.values())):.{max(0, digits - 1)}f}"
    if others is None:
        return text
    both = [seed for seed in means if seed in other_means]
    found = (difference(*(np.array([of[seed] for seed in both]) for of in (other_means, means)), paired=True) if same_bases else
             difference(*(np.array(list(of.values())) for of in (other_means, means)), paired=False))
    return f"{text} ({plus_minus(found, digits)})" if found[1] != 0 else f"{text} ({found[0]:+.{digits}f} in every base)"


def _same_lead(bases_of: list[Rows]) -> str:
    """How often two samples of one base are led by the same notch of the base; half of the pairs by chance."""
    same = pairs = 0
    for rows in bases_of:
        lead = in_base_frame(rows, leading_notch(rows))
        lead = lead[lead >= 0]
        first, second = np.triu_indices(len(lead), 1)
        same, pairs = same + int((lead[first] == lead[second]).sum()), pairs + len(first)
    return f"{100 * same / pairs:.0f} %" if pairs else "–"


def merged(several: list[Rows]) -> Rows:
    """The samples of several runs in one table."""
    return replace(several[0], sample=np.concatenate([rows.sample for rows in several]),
                   values={name: np.concatenate([rows.values[name] for rows in several]) for name in several[0].values},
                   z=np.concatenate([rows.z for rows in several]), seconds=np.concatenate([rows.seconds for rows in several]))


def group_limits(rows: Rows) -> str:
    """What becomes of the groups with other limits."""
    lines = []
    for limit in (0.3, 0.35, 0.4, 0.45, 0.5):
        one, two, other = groups(rows, limit)
        lines.append([f"{limit:g}", *(share(count, len(rows)) for count in (one, two)), str(other)])
    table = markdown(["share of the ligament from which a second crack counts", "one crack", "two cracks", "other"], lines)
    load, one = onset(rows), has_one_crack(rows)
    ends = [-np.inf, 510, 530, 545, np.inf]
    of = []
    for low, high in zip(ends, ends[1:]):
        inside = (load > low) & (load <= high)
        of.append(f"{int(one[inside].sum())} of {int(inside.sum())}")
    correlation = np.corrcoef(load, second_reach(rows))[0, 1]
    return table + (
        f"\nThe higher the load at the onset, the farther the second crack runs (correlation {correlation:.2f}). One crack, at a limit of {DEVELOPED:g}: {of[0]} samples "
        f"at up to {ends[1]} N, {of[1]} at up to {ends[2]} N, {of[2]} at up to {ends[3]} N, {of[3]} above.\n")


def bases(all_rows: list[Rows]) -> str:
    """What depends on the base distribution of mother points."""
    lines, lower_leads = [], {}
    for rows in all_rows:
        lead = leading_notch(rows)
        lower_leads[rows.name] = (lead == 0)[lead >= 0].astype(float)
        lines.append([rows.label, str(len(rows)), f"{np.median(rows.values['onset_force']):.0f}", patterns(rows),
                      str(int((lead == 0).sum())), str(int((lead == 1).sum()))])
    table = markdown(["`seed`", "samples", "onset [N], median", "one / two cracks / other / none", "lower notch leads",
                      "upper notch leads"], lines)
    others = [lower_leads[rows.name] for rows in other_bases(all_rows) if len(lower_leads[rows.name])]
    if len(others) < 2:
        return table

    def same_share(leads: Iterable[np.ndarray]) -> str:
        return _small(same_share_test(*zip(*((int(one.sum()), len(one)) for one in leads))))

    mean, half = np.concatenate(others).mean(), mean_interval(np.array([one.mean() for one in others]))[1]
    between, _ = scatter_of_means(others)
    return table + (
        f"\nThe same share with all bases: p {same_share(lower_leads.values())}, without the first {same_share(others)}. Without the first the lower notch leads in {100 * mean:.0f} % of the "
        f"samples, ± {100 * half:.0f} % at 95 % confidence of the mean over bases; beyond the chance of ten samples this share "
        f"scatters by {100 * between:.0f} % from base to base, and the mean onset by {base_scatter(all_rows):.1f} N.\n")


def other_bases(all_rows: list[Rows]) -> list[Rows]:
    """The runs of the study `bases` but the first, on which notches were chosen."""
    return [rows for rows in all_rows if rows.name != FIRST_BASE.name]


def base_scatter(all_rows: list[Rows]) -> float:
    """Standard deviation of the mean onset [N] over the bases of the study `bases` but the first one."""
    return scatter_of_means([rows.values["onset_force"] for rows in other_bases(all_rows)])[0]


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
    lead, one = leading_notch(rows), has_one_crack(rows)
    lines = []
    for label, chosen in (("one crack", one), ("all", np.ones(len(rows), bool))):
        for place, notch in (("in the body", lead), ("of the base, turned back", in_base_frame(rows, lead))):
            first, second = int((notch[chosen] == 0).sum()), int((notch[chosen] == 1).sum())
            lines.append([label, place, str(first), str(second), share(first, first + second),
                          f"{binomial_test(first, first + second):.2g}"])
    return markdown(["samples", "notch", "lower leads", "upper leads", "share of the lower one", "p of equal chances"], lines)


def base_notches(rows: Rows) -> str:
    """The samples by the notch of the base, turned back, that leads."""
    lead, path = in_base_frame(rows, leading_notch(rows)), leading_path(rows)
    lines = [[name, str(int(mine.sum())), share(int(has_one_crack(rows)[mine].sum()), int(mine.sum())),
              spread(second_reach(rows)[mine], ".2f"), *(spread(1e3 * column[mine], ".2f") for column in path.T)]
             for name, mine in (("lower", lead == 0), ("upper", lead == 1))]
    differences = [difference(*(column[lead == k] * 1e3 for k in (1, 0)), paired=False) for column in path.T]
    return markdown(["notch of the base that leads", "samples", "one crack", "share that the second crack crosses",
                     *(f"z at {y} mm [mm]" for y in SECTIONS)], lines) + (
        f"\nLower less upper, z [mm]: {', '.join(plus_minus(one, 2) for one in differences)} (95 %, each by itself).\n")
