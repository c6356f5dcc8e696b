# SPDX-License-Identifier: GPL-3.0-or-later
"""Ensembles compared with a first one: differences with intervals, and p-values adjusted for all comparisons made."""
from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Optional

import numpy as np
import pandas as pd

from . import inference
from .files import FAILED, PENDING, ResultsError
from .inference import Censored, Difference, TwoSamples
from .outcomes import UNDECIDED, Ends
from .program import statistics_of
from .text import aligned, count, json_text, plain, probability, shown, shown_range, unit_for

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def compare(*ensembles: Any, confidence: float = 0.95, program: str | Path | None = None) -> "Comparisons":
    """Each further ensemble beside the first: folders of `crackle run`, their ensemble.h5, or opened ones.

    Samples with the same bodies are compared in pairs, others as independent; those of one draw of the random inputs as a whole. Samples that
    did not break count as stronger than the largest load applied. Raises crackle.ResultsError.
    """
    names = [str(getattr(one, "folder", one)) for one in ensembles]
    if len(names) < 2:
        raise ResultsError("give two ensembles or more")
    compared = [Rows(name, statistics_of(Path(name), program, sensitivities=False)) for name in names]
    return Comparisons(names, compared[0].sections, [_Comparison(compared[0], other, confidence) for other in compared[1:]])


class Comparisons:
    """What `crackle compare` prints: `print(comparisons)`. `document` is what it prints with --json."""

    def __init__(self, names: list[str], sections: list[tuple[str, str]], comparisons: list["_Comparison"]) -> None:
        self.names, self._sections, self._comparisons = names, sections, comparisons

    def __str__(self) -> str:
        return "\n".join(one.text(self.names[0], name, self._sections) for one, name in zip(self._comparisons, self.names[1:]))

    @property
    def document(self) -> dict[str, Any]:
        return plain({"first": self.names[0], "sections": [name for name, _ in self._sections],
                      "comparisons": [one.document(name) for one, name in zip(self._comparisons, self.names[1:])]})

    @property
    def json(self) -> str:
        return json_text(self.document)

    @property
    def results(self) -> pd.DataFrame:
        """A row for each ensemble, result and share that is compared [SI]: means, medians of loads that are partly bounds, the difference
        with its interval, p, and p of all comparisons."""
        return pd.DataFrame([
            {"second": name, "result": one.info["name"], "share_of": one.share_of, "n_first": one.n[0], "n_second": one.n[1], "first": one.centres[0],
             "second_value": one.centres[1], **one.main._asdict(), "p": one.p, "p_adjusted": one.adjusted}
            for comparison, name in zip(self._comparisons, self.names[1:]) for one in comparison.results]).set_index(["second", "result", "share_of"])

    @property
    def paths(self) -> pd.DataFrame:
        """A row for each ensemble, class of leading crack and section: the difference of mean positions [m]; energy distance and its p."""
        return pd.DataFrame([
            {"second": name, "leading_notch": one.start, "section": section, **difference._asdict(), "energy_distance": one.distance, "p": one.p,
             "p_adjusted": one.adjusted}
            for comparison, name in zip(self._comparisons, self.names[1:]) for one in comparison.paths
            for (section, _), difference in zip(self._sections, one.of_means)])

    def plot(self, axes: Optional["Axes"] = None) -> "Axes":
        """Differences of the results, in standard errors of their intervals, with p of all comparisons."""
        from .plots import _axes
        axes = _axes(axes)
        table = self.results.dropna(subset=["lower", "upper"]).iloc[::-1]
        half = (table["upper"] - table["lower"]) / 2
        axes.errorbar(table["value"] / half, range(len(table)), xerr=np.clip([(table["value"] - table["lower"]) / half, (table["upper"] - table["value"]) / half], 0, None),
                      fmt="o", capsize=2, linewidth=0.9)
        axes.axvline(0, color="0.3", linewidth=0.8)
        axes.set_yticks(range(len(table)), [f"{result.replace('_', ' ')}{': ' + share if share else ''}, p = {probability(p)}"
                                            for (_, result, share), p in zip(table.index, table["p_adjusted"])])
        axes.set_xlabel("difference, of half its interval")
        return axes


class Rows:
    """The samples of an ensemble that count. @param found: what `crackle stats --json` says of it"""

    def __init__(self, name: str, found: dict[str, Any]) -> None:
        if "sampling" not in found:
            raise ResultsError(f"'{name}' holds a sweep; give the folder of one of its cases, such as {Path(name) / 'case-0'}")
        if not found["n_done"]:
            raise ResultsError(f"'{name}' has no completed sample")
        self.sampling, self.infos = found["sampling"], found["results"]
        self.rows = {key: values for key, values in found["samples"].items() if isinstance(values, list)}
        self.n, self.status = found["n_samples"], np.array(self.rows["status"])
        self.ends = Ends.of(self.status, self.rows)
        self.peak = _numbers(self.rows["peak_load"])
        self.draw = np.arange(self.n) // self.sampling["replicates"]
        path = found["crack_path"]
        self.sections = list(zip(path["section_name"], path["section_coordinate"]))
        self.leader = np.array(path["leader"], float).reshape(self.n, len(self.sections))
        self.reference = np.array(found["statistics"]["reference_notch"] or [0])
        self.leading = _numbers(self.rows["leading_notch"])

    @property
    def is_done(self) -> np.ndarray:
        return self.ends.is_done

    def is_open(self, info: dict[str, Any]) -> np.ndarray:
        """Which ended before a result was decided."""
        return self.ends.is_open(info["of_unbroken"], info["tells_the_end"])

    def broke(self, info: dict[str, Any]) -> np.ndarray:
        """Which ended with the result decided, though it may have none."""
        return self.is_done & ~self.is_open(info)

    def known(self, info: dict[str, Any]) -> np.ndarray:
        """A result of each sample; NaN where there is none, or a bound at most."""
        column = self.rows[info["name"]]
        values = _numbers(column)
        if all(isinstance(value, int) for value in column):
            values[values < 0] = np.nan
        values[~self.is_done | self.is_open(info)] = np.nan
        return values

    def observed(self, info: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
        """And whether it is a bound. Bounds mean nothing where samples broke, but none of them has the result: an onset after a start from rest."""
        known, broke = self.known(info), self.broke(info)
        if broke.any() and np.isnan(known[broke]).all():
            return known, np.zeros(self.n, bool)
        is_bound = self.ends.is_bound(info["of_unbroken"], info["tells_the_end"]) & ~np.isnan(self.peak)
        return np.where(is_bound, self.peak, known), is_bound

    def counts(self) -> dict[str, int]:
        return {"n_done": int(self.is_done.sum()), "n_undecided": int(np.sum(self.is_done & (np.array(self.rows["outcome"]) == UNDECIDED))),
                "n_unbroken": int(self.ends.is_unbroken.sum()), "n_held": int(self.ends.is_held.sum()),
                "n_failed": int(np.sum(self.status == FAILED)), "n_left": int(np.sum(self.status == PENDING))}


def _numbers(column: list[Any]) -> np.ndarray:
    return np.array([np.nan if value is None else value for value in column], float)


@dataclass
class _Result:
    """Comparison of one number or share."""

    info: dict[str, Any]
    share_of: str
    n: tuple[int, int]
    centres: tuple[float, float]  # means or shares, or medians where there are bounds
    p: float
    of_means: Difference = Difference()
    of_medians: Difference = Difference()
    bounds: tuple[int, int] = (0, 0)
    are_bounds: tuple[bool, bool] = (False, False)  # the medians
    adjusted: float = 1.0
    least: float = np.nan
    same_as: str = ""

    @property
    def is_censored(self) -> bool:
        return sum(self.bounds) > 0

    @property
    def main(self) -> Difference:
        return self.of_medians if self.is_censored else self.of_means

    @property
    def name(self) -> str:
        return f"{self.info['label']}: {self.share_of}" if self.share_of else self.info["label"]


@dataclass
class _Paths:
    """Of the leading cracks of one class."""

    start: int
    n: tuple[int, int]
    distance: float
    p: float
    of_means: list[Difference]
    adjusted: float = 1.0


@dataclass
class _Comparison:
    first: Rows
    second: Rows
    confidence: float
    note: str = ""
    remarks: list[str] = field(default_factory=list)
    results: list[_Result] = field(default_factory=list)
    paths: list[_Paths] = field(default_factory=list)

    def __post_init__(self) -> None:
        one, other = (each.sampling["body_settings"] for each in (self.first, self.second))
        only = [next((line for line in a if line not in b), None) for a, b in ((one, other), (other, one))]
        self.are_paired = only == [None, None]
        notes = []
        if not self.are_paired:
            notes.append("not paired, because the bodies differ: {} in one, {} in the other".format(*(line or "no such setting" for line in only)))
        notes += sorted({each.sampling["note"] for each in (self.first, self.second)} - {""})
        both = min(self.first.n, self.second.n)
        is_pair = self.first.is_done[:both] & self.second.is_done[:both]
        self._rows = (np.flatnonzero(is_pair), np.flatnonzero(is_pair)) if self.are_paired else (np.flatnonzero(self.first.is_done), np.flatnonzero(self.second.is_done))
        self.n_pairs = int(is_pair.sum()) if self.are_paired else 0
        of_pairs = max(self.first.sampling["replicates"], self.second.sampling["replicates"])
        self._draws = tuple(rows // of_pairs if self.are_paired else each.draw[rows] for each, rows in zip((self.first, self.second), self._rows))
        self._tests: list[TwoSamples] = []
        self._path_tests: list[TwoSamples] = []
        self._add_scope()
        self._compare_results()
        if self.first.sections != self.second.sections:
            notes.append("paths are not compared, because the sections differ")
        elif any(line and line.startswith("specimen.") for line in only):
            notes.append("paths are not compared, because the bodies differ")
        else:
            self._compare_paths()
        self.note = "; ".join(notes)
        self._adjust()

    def _take(self, of_first: np.ndarray, of_second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which of the rows have a value; of pairs, both."""
        has = [~np.isnan(values if values.ndim == 1 else values[:, 0]) for values in (of_first, of_second)]
        return (has[0] & has[1],) * 2 if self.are_paired else tuple(has)  # type: ignore[return-value]

    def _samples(self, of_first: np.ndarray, of_second: np.ndarray, has: Optional[tuple[np.ndarray, np.ndarray]] = None) -> TwoSamples:
        a, b = has or self._take(of_first, of_second)
        return TwoSamples(of_first[a], of_second[b], self.are_paired, self._draws[0][a], self._draws[1][b])

    def _compare_results(self) -> None:
        infos = {info["name"]: info for info in self.second.infos}
        for info in self.first.infos:
            name = info["name"]
            is_pattern = name == "pattern"
            if name not in infos or not all(name in each.rows for each in (self.first, self.second)):
                continue
            if info["about"] in ("computation", "place") or (info["reduction"] == "none" and not is_pattern):
                continue
            if is_pattern or info["reduction"] == "shares":
                if any(not (_numbers(each.rows[name]) >= 0).any() for each in (self.first, self.second)):
                    continue  # such as the pattern of a body that is no plate
                for k, word in enumerate(info["categories"]):
                    self._add_share(info, word, lambda values, k=k: values == k)
            elif info["reduction"] == "counts":
                self._add_share(info, "any", lambda values: values > 0)
            else:
                self._add_number(info)

    def _add_share(self, info: dict[str, Any], word: str, is_hit: Callable[[np.ndarray], np.ndarray]) -> None:
        samples = self._samples(*(is_hit(_numbers(each.rows[info["name"]])[rows]).astype(float) for each, rows in zip((self.first, self.second), self._rows)))
        n_ones, n = samples.first.sum() + samples.second.sum(), len(samples.first) + len(samples.second)
        if 0 < n_ones < n:  # a share of 0 or of 1 on both sides is no comparison
            self._add(info, word, samples, of_means=inference.difference_of_shares(samples, self.confidence))

    def _add_number(self, info: dict[str, Any]) -> None:
        observed = [[values[rows] for values in each.observed(info)] for each, rows in zip((self.first, self.second), self._rows)]
        has = self._take(observed[0][0], observed[1][0])
        kept = [(values[one], is_bound[one]) for (values, is_bound), one in zip(observed, has)]
        has_known, has_bounds = (any(which.any() for which in found) for found in zip(*((~is_bound, is_bound) for _, is_bound in kept)))
        if has_bounds and (has_known or not any(each.broke(info).any() for each in (self.first, self.second))):
            lists = [Censored(values, is_bound, draws[one]) for (values, is_bound), draws, one in zip(kept, self._draws, has)]
            scores = TwoSamples(*inference.gehan_scores(*lists), self.are_paired, lists[0].group, lists[1].group)
            medians = [one.median() if len(one.value) else (np.nan, False) for one in lists]
            self._add(info, "", scores, centres=(medians[0][0], medians[1][0]), are_bounds=(medians[0][1], medians[1][1]),
                      bounds=(int(lists[0].is_bound.sum()), int(lists[1].is_bound.sum())),
                      of_medians=inference.difference_of_censored_medians(*lists, self.confidence))
            return
        samples = self._samples(*(each.known(info)[rows] for each, rows in zip((self.first, self.second), self._rows)))
        if len(samples.first) + len(samples.second):
            self._add(info, "", samples, of_means=inference.difference_of_means(samples, self.confidence),
                      of_medians=inference.difference_of_medians(samples, self.confidence))

    def _add(self, info: dict[str, Any], share_of: str, samples: TwoSamples, centres: Optional[tuple[float, float]] = None, **found: Any) -> None:
        means = tuple(float(np.mean(values)) if len(values) else np.nan for values in (samples.first, samples.second))
        p = np.nan if samples.is_empty else inference.permutation_probability(samples)
        self.results.append(_Result(info, share_of, (len(samples.first), len(samples.second)), centres or means, p, **found))
        self._tests.append(samples)

    def _compare_paths(self) -> None:
        first, second = self.first, self.second
        for start in range(len(first.reference)):
            if first.reference[start] != start:
                continue
            leaders, led = [], []
            for each, rows in zip((first, second), self._rows):
                leading = each.leading[rows]
                led.append(np.array([notch >= 0 and each.reference[int(notch)] == start for notch in leading], bool))
                leaders.append(np.where(led[-1][:, None], each.leader[rows], np.nan))
            has = (led[0] & led[1],) * 2 if self.are_paired else tuple(led)
            paths = self._samples(leaders[0], leaders[1], has)
            if not len(paths.first) and not len(paths.second):
                continue
            of_means = []
            for s in range(len(first.sections)):
                at = self._samples(leaders[0][:, s], leaders[1][:, s])
                of_means.append(Difference() if at.is_empty else inference.difference_of_means(at, self.confidence))
            distance, p = inference.energy_distance(paths)
            self.paths.append(_Paths(start, (len(paths.first), len(paths.second)), distance, p, of_means))
            self._path_tests.append(paths)

    def _adjust(self) -> None:
        joint = self._joint = inference.joint_test(self._tests, self._path_tests)
        for i, one in enumerate([*self.results, *self.paths]):
            # The joint permutations also change which samples lack a value; p alone does not.
            one.adjusted = max(joint.adjusted[i], one.p) if not np.isnan(joint.adjusted[i]) else np.nan
        for one, samples, same in zip(self.results, self._tests, joint.same_as):
            one.least = np.nan if samples.is_empty else inference.Units(samples).design.least
            one.same_as = self.results[same].name if same >= 0 else ""
        if joint.least > inference.SIGNIFICANT:
            self.remarks.append(f"With so few samples no difference could be significant: the least p is {joint.least:.3f}.")
        elif joint.n_too_small:
            self.remarks.append("One of the comparisons has too few samples for any p of 0.05 and is not counted." if joint.n_too_small == 1 else
                                f"{joint.n_too_small} of the comparisons have too few samples for any p of 0.05 and are not counted.")

    def _add_scope(self) -> None:
        """Remarks on what the numbers hold for, and leave out."""
        shared = [each.sampling["base"] == "shared" for each in (self.first, self.second)]
        self.has_shared_base = any(shared)
        if self.has_shared_base:
            whose = "these base points" if all(shared) else f"the {'first' if shared[0] else 'second'} ensemble's base points"
            self.remarks.append(f'Intervals and p-values hold for {whose} only (mesh.base = "shared"): with another base the answer may differ.')
        if max(self.first.sampling["replicates"], self.second.sampling["replicates"]) > 1:
            self.remarks.append("Samples of one draw are not independent: intervals and p-values are by whole draws, {} and {}.".format(*(np.unique(d).size for d in self._draws)))
        counts = (self.first.counts(), self.second.counts())
        for key, sentence in (("n_failed", "Failed samples are in no number: {}."),
                              ("n_unbroken", "Some samples did not break ({}): loads count them as stronger than the largest applied, by medians (Kaplan and Meier) and p of "
                               "Gehan's scores; times, displacements and work are of those that broke."),
                              ("n_held", "Some samples arrested at their largest load, as the loading ended ({}): onset and peak load count likewise."),
                              ("n_undecided", "Undecided samples count with what they had reached, in all numbers: {}.")):
            if counts[0][key] + counts[1][key]:
                self.remarks.append(sentence.format(f"{counts[0][key]} in the first, {counts[1][key]} in the second"))

    def text(self, first: str, second: str, sections: list[tuple[str, str]]) -> str:
        lines = [f"{second} minus {first}"]
        if self.are_paired:
            lines.append(f"{count(self.n_pairs, 'pair')} of samples with the same bodies; differences are within pairs")
        lines += [self.note] if self.note else []
        lines += self.remarks
        table = [["", "samples", "first", "second", "difference", f"{100 * self.confidence:g} % interval", "p", "of all comparisons"]]
        for one in self.results:
            table += _rows_of(one)
        for paths in self.paths:
            table.append([f"paths led by start {paths.start}: energy distance [mm]", f"{paths.n[0]}, {paths.n[1]}", "", "", shown(paths.distance, ".4f", 1e3), "",
                          probability(np.nan if np.isnan(paths.distance) else paths.p), probability(paths.adjusted)])
            table += [[f"  mean {coordinate} at {name} [mm]", "", "", "", shown(one.value, ".3f", 1e3), _interval(one, ".3f", 1e3), "", ""]
                      for (name, coordinate), one in zip(sections, paths.of_means)]
        return "\n".join(lines) + "\n" + aligned(table) + (
            f"p: by permutations, of a difference of means or shares as large were there none. Of all {self._joint.n_looks} comparisons: Westfall and Young's step-down max-T, so that one "
            f"below 0.05 is by chance in 5 % of such tables at most; least p possible: {probability(self._joint.least)}. Intervals hold each for itself.\n")

    def document(self, second: str) -> dict[str, Any]:
        return {"second": second, "paired": self.are_paired, "note": self.note, "n_pairs": self.n_pairs, "confidence": self.confidence,
                "results": [_entry(one) for one in self.results],
                "paths": [{"leading_notch": one.start, "n_first": one.n[0], "n_second": one.n[1], "energy_distance": one.distance, "p": one.p,
                           "p_adjusted": one.adjusted, "difference_of_means": [each._asdict() for each in one.of_means]} for one in self.paths],
                "notes": self.remarks, "has_shared_base": self.has_shared_base, "n_looks": self._joint.n_looks, "p_least": self._joint.least,
                "samples": [self.first.counts(), self.second.counts()]}


def _interval(difference: Difference, form: str, factor: float) -> str:
    return "all equal" if difference.has_no_width else shown_range(difference.lower, difference.upper, form, factor)


def _decimals(form: str, width: float) -> str:
    """A format such as ".6f" with no more decimals than an interval of this width makes known."""
    if not form.endswith("f") or not 0 < width < np.inf:
        return form
    return f".{min(int(form[1:-1]), max(0, 2 - int(np.floor(np.log10(width)))))}f"


def _rows_of(one: _Result) -> list[list[str]]:
    info = one.info
    unit, factor, form = "%", 100.0, ".0f"
    if not one.share_of:
        unit, factor = unit_for(info["shown_units"], info["shown_factor"], info["units"], np.fmax(*np.abs(one.centres)))
        form = _decimals(info["format_of_any"], factor * (one.main.upper - one.main.lower))
    label = one.name + (f" [{unit}]" if unit else "")

    def row(name: str, shown_centres: list[str], difference: Difference, *p: str) -> list[str]:
        return [name, f"{one.n[0]}, {one.n[1]}", *shown_centres, shown(difference.value, form, factor), _interval(difference, form, factor), *p]
    p = [probability(one.p), f"as {one.same_as}" if one.same_as else probability(one.adjusted)]
    centres = [("> " if is_bound else "") + shown(value, form, factor) for value, is_bound in zip(one.centres, one.are_bounds)]
    if one.is_censored:
        return [row(label + ", median", centres, one.of_medians, *p)]
    if one.share_of:
        return [row(label, centres, one.of_means, *p)]
    return [row(label + ", mean", centres, one.of_means, *p), row("  median", ["-", "-"], one.of_medians, "", "")]


def _entry(one: _Result) -> dict[str, Any]:
    info = one.info
    means = (np.nan, np.nan) if one.is_censored else one.centres
    entry = {"name": info["name"], "label": info["label"], "shown_units": info["shown_units"], "shown_factor": info["shown_factor"],
             "units": "1" if one.share_of else info["units"], "share_of": one.share_of, "n_first": one.n[0], "n_second": one.n[1],
             "n_bounds_first": one.bounds[0], "n_bounds_second": one.bounds[1], "mean_first": means[0], "mean_second": means[1],
             "difference_of_means": one.of_means._asdict(), "p": one.p, "p_adjusted": one.adjusted, "p_least": one.least, "same_as": one.same_as}
    if not one.share_of:
        entry["difference_of_medians"] = one.of_medians._asdict()
    if one.is_censored:
        entry["median_first"], entry["median_second"] = (np.nan if is_bound else value for value, is_bound in zip(one.centres, one.are_bounds))
    return entry
