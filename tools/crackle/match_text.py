# SPDX-License-Identifier: GPL-3.0-or-later
"""The document of a match as readable tables and sentences."""
from __future__ import annotations

import math
from typing import Any, Callable, Iterator, Optional, Sequence

from .rank_tests import LEVEL, ROUNDING, least_p_value
from .text import aligned, count, named, p_is, percent, probability, quantity, readable

ENOUGH = 0.8  # power below which a test that finds nothing cannot tell
Document = dict[str, Any]


def text(document: Document) -> str:
    samples = document["samples"]
    lacking = [named(samples[name], name) for name in ("failed", "undecided", "missing") if samples[name]]
    unbroken = [f"; {named(samples['unbroken'], 'unbroken')}"] if samples["unbroken"] else []
    parts = [f"{samples['used']} of {samples['planned']} samples{'; left out: ' if lacking else ''}{', '.join(lacking)}{''.join(unbroken)}\n",
             *(f"warning: {warning}\n" for warning in document["warnings"]), _table(document), *_remarks(document)]
    tests = [by for one in document["experiments"] for by in one["by"].values() if by["p_value"] is not None]
    if tests:
        parts.append(f"p: the share of samples and experiment that are at least as unusual; {least_p_value(samples['used']):.2g} at least. Unusual: a small "
                     "share lies as far from the others on average (p of mean), or from the k-th nearest of them (p of nearest, k = "
                     f"{tests[0]['n_neighbours']}). p is not the probability that the model is right. Usual: the samples' median distance. Offset: mean "
                     "signed distance from the samples' mean; std: its standard deviation over samples.\n")
    if document["set"]:
        parts += ["\n", *_set(document["set"])]
    return "".join(parts)


def _table(document: Document) -> str:
    rows = [["experiment", "by", "p", "of mean", "of nearest", "distance", "usual", "offset", "std", "nearest samples"]]
    for one in document["experiments"]:
        name = one["name"]
        for by_name, by in one["by"].items():
            rows.append([name, readable(by_name), *(probability(by.get(key)) for key in ("p_value", "p_value_of_mean", "p_value_of_neighbours")),
                         *quantities_of(by)])
            name = ""
    return "\n" + aligned(rows, 2, True) if len(rows) > 1 else ""


def quantities_of(by: Document) -> list[str]:
    """Distance, usual distance, offset and its standard deviation, all in one unit, and the nearest samples."""
    sizes = [by.get(key) for key in ("mean_distance", "usual_distance", "offset", "standard_deviation")]
    largest = max((abs(size) for size in sizes[:3] if size is not None), default=None)
    return [*(quantity(size, by["unit"], 3, largest) for size in sizes),
            ", ".join(f"{each['sample']} ({quantity(each['distance'], by['unit'], 3, by.get('mean_distance'))})" for each in by["nearest"])]


def _place(point: Sequence[float]) -> str:
    return f"({', '.join(quantity(value, 'm') for value in point)})"


def _departures(path: Document) -> str:
    axis = "y" if path["is_along_y"] else "z"
    return "; ".join(f"from {_place(part['from'])} to {_place(part['to'])}, " + (
        "where it has ended" if part["is_missing"] else "where none of them goes on" if part["beyond"] is None else
        f"by up to {quantity(abs(part['beyond']), 'm', 3)} towards {'larger' if part['beyond'] > 0 else 'smaller'} {axis}") for part in path["departures"])


def way_text(way: Document, p_value: Optional[float]) -> str:
    """Which way, and how many samples took it; empty where all took the same. @param p_value by the way and what is compared within it"""
    n = sum(each["n_samples"] for each in way["ways"])
    others = ", ".join(f"{each['n_samples']} {each['name']}" for each in way["ways"] if each["name"] != way["name"])
    if not others:
        return ""
    whose = f"{way['n_samples']} of {n} samples" if way["n_samples"] else "no sample"
    return f"it went {way['name']}, as {whose} ({others}), {p_is(way['p_value'])}" + (f"; with what is compared within it {p_is(p_value)}" if way["n_samples"] else "")


def path_text(one: Document) -> str:
    """Whether its path lies in the band of the samples that took its way."""
    path, n = one["path"], len(one["path"]["samples"])
    far = f"{quantity(path['farthest']['distance'], 'm', 3)} from the nearest, sample {path['farthest']['sample']}, at its farthest"
    if one["way"]["n_samples"] == 0:
        return f"it lies outside the samples, {far}"
    whose = f"the band of {count(n, 'sample')}"
    if not path["departures"]:
        return f"its path stays within {whose}, {far}"
    p, k = path["band_p_value"], round(path["band_p_value"] * (n + 1)) - 1
    is_outside = p <= max(LEVEL, least_p_value(n)) + ROUNDING
    verdict = (f"leaves {whose} {_departures(path)}; {'none' if k == 0 else k} of these samples {'leave' if k > 1 or k == 0 else 'leaves'} that of "
               f"the others by as much ({p_is(p)})")
    return f"its path {verdict}: {'outside' if is_outside else 'as samples do'}; {far}"


def sentences(one: Document) -> list[str]:
    """What is said of an experiment, without its name and the last full stop."""
    has_path = one["path"] and not one["note"].startswith("its path does not")
    return [sentence for sentence in (way_text(one["way"], one["p_value"]) if one["way"] else "", path_text(one) if has_path else "", one["note"]) if sentence]


def _remarks(document: Document) -> Iterator[str]:
    for one in document["experiments"]:
        for sentence in sentences(one):
            yield f"{one['name']}: {sentence}{'' if sentence.endswith('?') else '.'}\n"
        by = one["by"].get("path")
        if by and by["p_value_of_mean"] == 1 and one["observed"]["path_error"] > 0 and by["n_samples"] >= 19:
            yield f"{one['name']}: it lies nearer to all samples than any of them; path_error may be too large.\n"
    told: list[tuple] = []  # most experiments lack the same samples
    for one in document["experiments"]:
        for name, by in one["by"].items():
            lack = (name, *by["left_out"])
            if name not in ("jointly", "path") and by["left_out"] and lack not in told:
                told.append(lack)
                yield f"Left out by {readable(name)}, which they lack: {named(by['left_out'], 'sample' if len(by['left_out']) == 1 else 'samples')}.\n"
            if by["limit"] is not None and (name, "limit") not in told:
                told.append((name, "limit"))
                yield (f"By {readable(name)} all count up to {quantity(by['limit'], 'N')}, the least that something bore without breaking: "
                       "no test sees what lies above.\n")


def _interval(found: Document, show: Callable[[float], str]) -> str:
    if found["value"] is None or math.isnan(found["value"]):
        return "-"
    if found["lower"] is None or math.isnan(found["lower"]):
        return show(found["value"])
    return f"{show(found['value'])} ({show(found['lower'])} to {show(found['upper'])})"


def _times(value: float) -> str:
    return f"{value:.2g}" if value < 99.5 else f"{value:.0f}"


def _shift(by: Document) -> Callable[[float], str]:
    largest = max((abs(value) for value in by["shift"].values() if value is not None and not math.isnan(value)), default=None)
    return lambda value: quantity(value, by["unit"], 3, largest)


def interval_cells(by: Document) -> list[str]:
    """Of the shift and of the ratio of scatters."""
    return [_interval(by["shift"], _shift(by)), _interval(by["scatter_ratio"], _times)] if "shift" in by else ["-", "-"]


def _set(found: Document) -> Iterator[str]:
    rows = [["together by", "experiments", "p", "of energy", "of depth", "shift", "scatter, ratio"]]
    for name, by in found["by"].items():
        rows.append([readable(name), str(by["n_experiments"]), *(probability(by[key]) for key in ("p_value", "energy_p_value", "depth_p_value")),
                     *interval_cells(by)])
    if found["by"]:
        yield aligned(rows, 2, True)
    for one in found["left_out"]:
        yield f"Left out by {readable(one['by'])}: {one['name']}, {one['reason']}.\n"
    if found["ways"] and len(found["ways"]["ways"]) > 1:
        shares = "; ".join(f"{each['name']}: {count(each['n_experiments'], 'experiment')}, {count(each['n_samples'], 'sample')}"
                           for each in found["ways"]["ways"])
        yield f"Ways: {shares}; {p_is(found['ways']['p_value'])} of shares as different, were there no difference.\n"
    for name, by in found["by"].items():
        if by.get("advice"):
            yield f"By {readable(name)}: {by['advice']}\n"
        if by.get("power", {}).get("n_trials"):
            yield f"  {power_text(by)}\n"
        for whose, fit in (by.get("weibull") or {}).items():
            if fit:
                yield f"  {whose}: {weibull_text(fit)}\n"
    if found["by"]:
        last = list(found["by"].values())[-1]
        yield ("p: of a difference as large, were there none, by energy distance and by ranks of depth "
               f"({last['n_permutations']} permutations{', all there are' if last['all_permutations'] else ''}), the smaller one doubled.\n")


def power_text(by: Document) -> str:
    shares = []
    for key, what in (("shift_of_one_deviation", "a shift of one standard deviation"), ("twice_the_scatter", "twice the scatter")):
        share = by["power"][key]
        half = 196 * math.sqrt(share * (1 - share) / by["power"]["n_trials"])
        shares.append(f"{what} in {percent(share)} (±{half:.0f})")
    return f"{by['n_experiments']} experiments and {by['n_samples']} samples find {shares[0]}, {shares[1]} of {by['power']['n_trials']} trials."


def weibull_text(fit: Document) -> str:
    sizes = [f"Weibull's modulus {_interval(fit['modulus'], lambda value: f'{value:.3g}')}",
             f"scale {_interval(fit['scale'], lambda value: quantity(value, 'N', 3))}"]
    counts = f"{fit['n_broken']} broken" + (f", {fit['n_run_out']} not" if fit["n_run_out"] else "")
    more = fit["with_threshold"]
    if more:
        threshold = _interval(more['threshold'], lambda value: quantity(value, 'N', 3))
        sizes.append(f"with a threshold {threshold}, modulus {more['modulus']:.3g}, scale {quantity(more['scale'], 'N', 3)} ({p_is(more['p_value'])} were there none)")
    return f"{counts}: {', '.join(sizes)}"


def advice(by: Document, is_shared: bool = False) -> str:
    """Sentences on the shift and scatter of experiments: what they mean for the model."""
    if is_shared:
        return "No conclusion: the samples share their base."
    ratio, shift, p, n = by["scatter_ratio"], by["shift"], by["p_value"], by["n_experiments"]
    words, is_confirmed = [], p <= LEVEL
    if not math.isnan(ratio["value"]):
        times = f"{_times(ratio['value'])} times as much ({_times(ratio['lower'])} to {_times(ratio['upper'])})"
        if ratio["lower"] <= 1 <= ratio["upper"]:
            power = by["power"]["twice_the_scatter"]
            cannot = math.isnan(power) or power < ENOUGH
            words.append(f"The experiments scatter {times}: " + (f"{n} experiments cannot tell." if cannot else
                                                                 "no evidence that the disturbance is wrong."))
        elif is_confirmed:
            words.append(f"The experiments scatter {times}: "
                         f"{'more disturbance or a varying material' if ratio['lower'] > 1 else 'less disturbance or a finer mesh'}.")
        else:
            words.append(f"The experiments scatter {times} if their distributions are normal, but so would others in {percent(p)} of cases"
                         + (f"; look at {by['farthest']}, the farthest of the {n}, first." if ratio["lower"] > 1 else "."))
    if not math.isnan(shift["lower"]):
        size = f"{_shift(by)(shift['value'])}{' in ' + by['shift_axis'] if by['shift_axis'] else ''} " + \
            "({} to {})".format(*map(_shift(by), (shift["lower"], shift["upper"])))
        holds_zero = shift["lower"] <= 0 <= shift["upper"]
        words.append(f"A shift of {size}: no disturbance will cure that; look at material, supports and dimensions." if is_confirmed and not holds_zero
                     else f"Their mean is {size} off" + (", which may be chance." if holds_zero else f", which p = {p:.2g} does not confirm."))
    return " ".join(words)


def held_out_text(found: dict[int, float], of: str = "", is_shared: bool = False) -> str:
    """@param found: p-values by sample; @param of: the folder of the other ensemble, if any"""
    p_values = [p for p in found.values() if not math.isnan(p)]
    whose = f"{len(p_values)} samples of {of}, each as an experiment against these" if of else \
        f"{len(p_values)} samples, each as an experiment against the others"
    lines = [whose]
    for level in (0.05, 0.1, 0.25, 0.5, 0.75):
        n = sum(p <= level + ROUNDING for p in p_values)
        lines.append(f"p <= {level:<4}  {100 * n / max(1, len(p_values)):5.1f} % of them")
    lines.append("Were both ensembles of one distribution, these shares would be near the levels." if of else
                 "This checks the code only: each is ranked among the same samples, whatever they are. --of OTHER takes the samples of another "
                 "ensemble, such as one of the same input with another seed.")
    if is_shared:
        lines.append("The samples share their base: p-values beside them are too small, and no conclusion follows.")
    return "\n".join(lines) + "\n"
