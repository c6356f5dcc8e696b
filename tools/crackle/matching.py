# SPDX-License-Identifier: GPL-3.0-or-later
"""Experiments beside the samples of an ensemble: which ways their cracks took, whether each could be one of them, where its path
leaves theirs, and what several say together. The same in each call."""
from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Iterator, Optional, Sequence

import numpy as np
import pandas as pd

from . import match_text, weibull
from .experiments import Experiment, read_experiments
from .files import ResultsError
from .inference import Difference
from .observations import (Observable, ObservedSamples, SeenPaths, check_places, distinct, needs_arms, needs_files, observe_load, observe_path,
                           observe_stiffness, observe_tips, observed_samples, seen_paths, start_of)
from .path_frame import N_STATIONS, length_of
from .rank_tests import (LEVEL, ROUNDING, Scatter, distances_of, group_test, joint_distances, least_p_value, power, random_stream, rank_test,
                         samples_needed, scatter)
from .text import json_text, plain
from .ways import Ways, least_distance, moved_onto, ways_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

N_NEAREST = 5  # samples that are told
THOUSAND = 0.5  # decades by which a load may differ from a thousand times the samples'
PLOTTED = "0.6"  # colour of samples


class Match:
    """What `crackle match` finds. `str()` is the text that it prints, `document` what it prints with --json, in SI units."""

    def __init__(self, document: dict[str, Any], walls: Sequence[np.ndarray] = ()) -> None:
        """@param walls: ends of the body's walls in the y-z plane, each 2 x 2 [m]"""
        self.document, self.warnings, self._walls = document, document["warnings"], walls

    def __str__(self) -> str:
        return match_text.text(self.document)

    @property
    def json(self) -> str:
        """The document as `crackle match --json` prints it."""
        return json_text(self.document)

    @property
    def experiments(self) -> pd.DataFrame:
        """A row for each experiment and quantity ("path", "peak_load", ..., "jointly"): p-values, mean distances [SI], and the numbers
        of the nearest samples with their distances."""
        rows = {(one["name"], name): {**by, "nearest": [each["sample"] for each in by["nearest"]],
                                      "distance": [each["distance"] for each in by["nearest"]]}
                for one in self.document["experiments"] for name, by in one["by"].items()}
        return pd.DataFrame(list(rows.values()), index=pd.MultiIndex.from_tuples(rows, names=["experiment", "by"]) if rows else None)

    @property
    def ways(self) -> pd.DataFrame:
        """A row for each experiment with a path and each way: how many samples took it, and whether the experiment did."""
        return pd.DataFrame([{"experiment": one["name"], "way": way["name"], "samples": way["n_samples"], "taken": way["name"] == one["way"]["name"]}
                             for one in self.document["experiments"] if one["way"] for way in one["way"]["ways"]],
                            columns=["experiment", "way", "samples", "taken"])

    @property
    def together(self) -> Optional[pd.DataFrame]:
        """A row for each quantity that several experiments have; None where none has."""
        found = self.document["set"]
        return pd.json_normalize([{"by": name, **by} for name, by in found["by"].items()], sep="_").set_index("by") if found and found["by"] else None

    def plot_path(self, experiment: str, axes: Optional["Axes"] = None) -> "Axes":
        """The whole measured path over those of the samples, with their band [mm]. Raises KeyError for an experiment without a path
        that could be compared."""
        one = {each["name"]: each for each in self.document["experiments"] if each["path"]}[experiment]
        path = one["path"]
        if axes is None:
            import matplotlib.pyplot as plt
            axes = plt.subplots(layout="constrained")[1]
        for wall in self._walls:
            axes.plot(*1e3 * wall.T, color="0.3", linewidth=0.8)
        for k, line in enumerate(path["sample_lines"]):
            axes.plot(*1e3 * np.array(line).T, color=PLOTTED, linewidth=0.5, label="samples" if k == 0 else None)
        place, normal = np.array(path["place"]), np.array(path["normal"])
        low, high = (1e3 * (place + np.array(path[name], float)[:, None] * normal) for name in ("band_lower", "band_upper"))
        shown = np.isfinite(low).all(axis=1) & np.isfinite(high).all(axis=1)
        axes.fill(*np.vstack([low[shown], high[shown][::-1]]).T, color="C0", alpha=0.2, linewidth=0, label="their band")
        for k, line in enumerate(one["observed"]["lines"]):
            axes.plot(*1e3 * np.array(line).T, color="C3", label=experiment if k == 0 else None)
        axes.set(aspect="equal", xlabel="y [mm]", ylabel="z [mm]")
        axes.legend(fontsize="small")
        return axes


def match(folder: Path, experiments: Path, program: Optional[Path] = None) -> Match:
    """Experiments (a TOML file) beside the samples of an ensemble's folder. Raises ResultsError."""
    given = read_experiments(experiments)
    samples = observed_samples(folder, needs_files(given), program)
    check_places(experiments, given, samples)
    return match_with(given, samples)


def match_with(experiments: Sequence[Experiment], samples: ObservedSamples) -> Match:
    """The same of what has been read."""
    document = samples.document
    return Match(plain({
        "experiments": [_match_one(one, samples) for one in experiments],
        "set": _match_set(experiments, samples),
        "warnings": [*_warnings(experiments, samples)],
        "samples": {"planned": document["planned"], "used": len(samples.samples), "failed": document["failed"], "undecided": document["undecided"],
                    "missing": samples.missing, "unbroken": [one.number for one in samples.samples if one.is_unbroken],
                    "loads": [{"sample": one.number, "onset_load": math.nan if one.is_unbroken else one.onset_load, "peak_load": one.peak_load,
                               "is_unbroken": one.is_unbroken} for one in samples.samples]}}),
        [wall for start in samples.starts for wall in start.walls])


# One experiment.

def _match_one(experiment: Experiment, samples: ObservedSamples) -> dict[str, Any]:
    seen = seen_paths([experiment], samples)
    ways = ways_of(seen, samples.starts, samples.gaps) if seen else None
    taken = ways.members(ways.of_experiments[0]) if ways else []
    # Of a way that no sample took, beside all of them.
    path = observe_path([experiment], samples, seen, taken or [i for i, arm in enumerate(seen.arms) if arm]) if seen and any(seen.arms) else None
    found = [path, *(observe_load([experiment], samples, load) for load in ("onset_load", "peak_load")), observe_tips(experiment, samples), observe_stiffness([experiment], samples)]
    observables = [_clipped(each) for each in found if each is not None and len(each.samples)]
    by = {each.quantity: _match_by([each], samples) for each in observables}
    if len(jointly := distinct(observables)) > 1:
        by["jointly"] = _match_by(jointly, samples)
    last = list(by.values())[-1] if by else None
    p = last["p_value"] if last else math.nan
    if ways and len(set(ways.of_samples) | {ways.of_experiments[0]}) > 1:  # which way, and then within it
        p = ways.p_value(0, p if taken and not math.isnan(p) else 1.0)
    way = _way(ways, 0) if ways else None
    return {"name": experiment.name, "p_value": p, "least_p_value": way["least_p_value"] if way else last["least_p_value"] if last else None,
            "samples_needed": samples_needed(), "way": way, "by": by, "nearest": last["nearest"] if last else [],
            "path": _match_path(path, seen, samples, bool(taken)) if path else None,
            "note": "; ".join(_notes(experiment, seen, path, by, samples)), "observed": _observed(experiment)}


def _way(ways: Ways, experiment: int) -> dict[str, Any]:
    own, n = ways.of_experiments[experiment], len(ways.of_samples)
    each = [{"name": name, "n_samples": ways.count(k)} for k, name in enumerate(ways.names) if ways.count(k) or k == own]
    return {"name": ways.names[own], "n_samples": ways.count(own), "p_value": ways.p_value(experiment), "least_p_value": least_p_value(n),
            "ways": sorted(each, key=lambda way: -way["n_samples"])}


def _clipped(observable: Observable) -> Observable:
    """Loads up to the least that something bore without breaking: what lies above cannot be told apart from it."""
    bounds = np.concatenate([observable.of_experiments[observable.unbroken_experiments].ravel(),
                             observable.of_samples[observable.unbroken_samples].ravel()])
    if not bounds.size:
        return observable
    limit = float(bounds.min())
    tables = {name: np.minimum(getattr(observable, name), limit) for name in ("of_experiments", "of_samples", "with_error")}
    return replace(observable, limit=limit, unclipped=observable, **tables)


def _common(observables: Sequence[Observable]) -> tuple[list[int], list[int], list[np.ndarray]]:
    """Experiments and samples that have all of them, and of each a table with the experiments first."""
    experiments, samples = (sorted(set.intersection(*(set(getattr(each, name)) for each in observables))) for name in ("experiments", "samples"))
    tables = [np.vstack([each.of_experiments[[each.experiments.index(i) for i in experiments]],
                         each.with_error[[each.samples.index(i) for i in samples]]]) for each in observables]
    return experiments, samples, tables


def _distances(tables: Sequence[np.ndarray]) -> np.ndarray:
    each = [distances_of(table) for table in tables]
    return each[0] if len(each) == 1 else joint_distances(each)


def _match_by(observables: Sequence[Observable], samples: ObservedSamples) -> dict[str, Any]:
    _, rows, tables = _common(observables)
    only = observables[0] if len(observables) == 1 else None
    numbers = [samples.samples[i].number for i in rows]
    found = {"p_value": math.nan, "least_p_value": least_p_value(len(rows)), "n_samples": len(rows), "unit": only.unit if only else "1",
             "left_out": [one.number for i, one in enumerate(samples.samples) if i not in set(rows)], "mean_distance": math.nan,
             "usual_distance": math.nan, "offset": math.nan, "standard_deviation": math.nan, "nearest": [],
             "limit": only.limit if only else None}
    if not rows:
        return found
    apart = _distances(tables)
    test = rank_test(apart)
    among = apart[1:, 1:]
    comparable = np.logical_and.reduce([(~np.isnan(table[1:]) & ~np.isnan(table[0])).any(axis=1) for table in tables])
    order = sorted(np.flatnonzero(comparable), key=lambda i: apart[0, i + 1])[:N_NEAREST]
    found.update(p_value=test.p, p_value_of_mean=test.p_mean, p_value_of_neighbours=test.p_near, n_neighbours=test.k,
                 mean_distance=test.mean[0] if comparable.any() else math.nan,
                 usual_distance=np.median(among.sum(axis=1)) / (len(rows) - 1) if len(rows) > 1 else math.nan,
                 neighbour_distance=test.near[0] if comparable.any() else math.nan, usual_neighbour_distance=np.median(test.near[1:]),
                 nearest=[{"sample": numbers[i], "distance": apart[0, i + 1]} for i in order])
    if only and only.quantity != "tip_times" and only.limit is None:
        reached = ~np.isnan(tables[0][0])
        if reached.any():
            with np.errstate(all="ignore"):
                means = np.array([np.mean(row[~np.isnan(row)]) if (~np.isnan(row)).any() else np.nan for row in tables[0][:, reached]])
            others = means[1:][~np.isnan(means[1:])]
            if others.size:
                found["offset"] = means[0] - others.mean()
            if others.size > 1:
                found["standard_deviation"] = others.std(ddof=1)
    return found


def _beyond(values: np.ndarray, others: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Where a curve lies outside the others' band: the band's ends, where it is outside, and how far at most [m], also along the path
    where it stops although all others go on, or goes on where all have stopped."""
    reached = ~np.isnan(others)
    with np.errstate(invalid="ignore"):
        low = np.where(reached.any(axis=0), np.where(reached, others, np.inf).min(axis=0), np.nan)
        high = np.where(reached.any(axis=0), np.where(reached, others, -np.inf).max(axis=0), np.nan)
        off = np.fmax(values - high, low - values)
    has = ~np.isnan(values)
    lacking, alone = ~has & reached.all(axis=0), has & ~reached.any(axis=0)
    outside = lacking | alone | (np.nan_to_num(off, nan=-1.0) > 0)
    return low, high, outside, max(float(np.nan_to_num(off, nan=0.0).max(initial=0.0)), 0.0, step * lacking.sum(), step * alone.sum())


def _match_path(observable: Observable, seen: SeenPaths, samples: ObservedSamples, is_way_taken: bool) -> dict[str, Any]:
    frame, table = observable.frame, observable.with_error
    assert frame is not None
    offset = observable.of_experiments[0]
    step = length_of(frame.place) / (N_STATIONS - 1)
    low, high, outside, own = _beyond(offset, table, step)
    pool = np.vstack([offset, table])
    n = len(table)
    beyond = np.array([own, *(_beyond(pool[i], np.delete(pool, i, axis=0), step)[3] for i in range(1, n + 1))])
    stay = sum(_beyond(table[i], np.delete(table, i, axis=0), step)[3] == 0 for i in range(n)) if n > 1 else 0
    distance, nearest = least_distance(seen, 0, samples.gaps)
    numbers = [samples.samples[i].number for i in observable.samples]
    return {"place": frame.place, "normal": frame.normal, "offset": offset, "band_lower": low, "band_upper": high,
            "band_level": stay / n, "band_p_value": float(np.mean(beyond >= own - ROUNDING * own)) if is_way_taken else math.nan,
            "beyond": own, "usual_beyond": float(np.median(beyond[1:])), "most_beyond": float(beyond[1:].max()),
            "departures": list(_departures(frame.place, low, high, outside, offset)), "is_along_y": frame.is_along_y,
            "farthest": {"distance": distance, "sample": samples.samples[nearest].number}, "samples": numbers,
            "turned": [samples.samples[i].number for i in observable.turned], "sample_offsets": observable.of_samples,
            "sample_lines": [seen.arms[i].points for i in observable.samples if seen.arms[i]]}


def _departures(place: np.ndarray, low: np.ndarray, high: np.ndarray, outside: np.ndarray, offset: np.ndarray) -> Iterator[dict[str, Any]]:
    """One for each connected part that lies outside; signed along the normals, NaN where the crack ended before."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], outside.astype(int), [0]])))
    for first, end in zip(edges[::2], edges[1::2]):
        beyond = np.where(offset > high, offset - high, np.where(offset < low, offset - low, np.nan))[first:end]
        known = beyond[~np.isnan(beyond)]
        yield {"from": place[first], "to": place[end - 1], "beyond": known[np.abs(known).argmax()] if known.size else math.nan,
               "is_missing": bool(np.isnan(offset[first:end]).all())}


def _notes(experiment: Experiment, seen: Optional[SeenPaths], path: Optional[Observable], by: dict[str, Any],
           samples: ObservedSamples) -> Iterator[str]:
    if experiment.lines and seen is None or seen and not any(seen.arms):
        yield "no sample has a crack from where its path begins"
    elif seen and path is None:
        yield "its path has no part in common with those of the samples"
    if seen and any(seen.arms):
        if path is None or np.isnan(path.of_experiments[0]).all():
            yield "its path does not run along those of the samples; if it should, check origin, angle and mirror"
        line = seen.lines[0]
        distance, _ = least_distance(seen, 0, samples.gaps)
        if distance > 0.25 * length_of(line) and (shift := moved_onto(seen, 0, samples.gaps)) is not None:
            yield f"moved by ({1e3 * shift[0]:.3g} mm, {1e3 * shift[1]:.3g} mm) its path lies among the samples': is origin right?"
        if seen.are_reversed[0]:
            yield "its points run against the samples' cracks: digitized from its end? It is compared the other way round"
    for name in ("onset_load", "peak_load"):
        load = getattr(experiment, name)
        usual = np.nanmedian([getattr(one, name) for one in samples.samples]) if load and name in by else math.nan
        decades = math.log10(usual / load) if load and usual > 0 else 0.0
        if abs(abs(decades) - 3) < THOUSAND:
            yield f"its {name.replace('_', ' ')} is a thousand times {'smaller' if decades > 0 else 'larger'} than the samples': N or kN?"
    if not by and not seen:
        yield "nothing in it can be compared with the samples"


def _observed(experiment: Experiment) -> dict[str, Any]:
    return {"lines": experiment.lines, "onset_load": experiment.onset_load, "peak_load": experiment.peak_load, "run_out": experiment.run_out,
            "load_error": experiment.load_error, "path_error": experiment.path_error,
            "pictures": [{"file": str(one.file), "time": one.time, "corner": one.corner, "right": one.right, "down": one.down,
                          "light_field": one.light_field, "reversed": one.reversed} for one in experiment.pictures]}


# Several experiments.

@dataclass
class _Together:
    observable: Observable
    left_out: dict[int, str]  # why, by number of the experiment


def _path_together(experiments: Sequence[Experiment], samples: ObservedSamples) -> Optional[tuple[_Together, dict[str, Any]]]:
    """Of the way that most of the experiments took."""
    seen = seen_paths(experiments, samples)
    if seen is None or len(seen.experiments) < 2 or not any(seen.arms):
        return None
    left_out = {i: "its crack has another start" if one.lines else "no path" for i, one in enumerate(experiments) if i not in seen.experiments}
    ways = ways_of(seen, samples.starts, samples.gaps)
    taken = [way for way in dict.fromkeys(ways.of_experiments) if ways.count(way)]
    counts = {"p_value": _p_of_ways(ways), "ways": [{"name": name, "n_experiments": ways.of_experiments.count(k), "n_samples": ways.count(k)}
                                                    for k, name in enumerate(ways.names)]}
    if not taken:
        return None
    own = max(taken, key=ways.of_experiments.count)
    left_out |= {i: f"it took another way ({ways.names[way]})" for i, way in zip(seen.experiments, ways.of_experiments) if way != own}
    kept = [one if i not in left_out else replace(one, lines=[]) for i, one in enumerate(experiments)]
    observable = observe_path(kept, samples, None, ways.members(own))
    return (_Together(observable, left_out), counts) if observable else None


def _p_of_ways(ways: Ways) -> float:
    """Of shares of the ways as different, were there none: by permutation of what is an experiment and what a sample."""
    n_experiments, n_ways = len(ways.of_experiments), len(ways.names)
    pool = np.append(ways.of_experiments, ways.of_samples)
    if n_experiments < 2 or n_ways < 2:
        return math.nan
    expected = np.bincount(pool, minlength=n_ways) * n_experiments / len(pool)

    def statistic(of: np.ndarray) -> float:
        return float(((np.bincount(of, minlength=n_ways) - expected) ** 2 / np.maximum(expected, 1e-300)).sum())

    own, random = statistic(pool[:n_experiments]), random_stream(3)
    drawn = [statistic(random.choice(pool, n_experiments, replace=False)) for _ in range(1_999)]
    return (1 + sum(value >= own - ROUNDING for value in drawn)) / 2_000


def _match_set(experiments: Sequence[Experiment], samples: ObservedSamples) -> Optional[dict[str, Any]]:
    if len(experiments) < 2:
        return None
    used: list[_Together] = []
    ways = None
    if path := _path_together(experiments, samples):
        used.append(path[0])
        ways = path[1]
    for load in ("onset_load", "peak_load"):
        if observable := observe_load(experiments, samples, load):
            used.append(_Together(_clipped(observable), {i: f"no {load.replace('_', ' ')}" for i in range(len(experiments))
                                                         if i not in observable.experiments}))
    if observable := observe_stiffness(experiments, samples):
        used.append(_Together(observable, {i: "no stiffness" for i in range(len(experiments)) if i not in observable.experiments}))
    left_out = [{"name": experiments[i].name, "by": each.observable.quantity, "reason": why} for each in used for i, why in sorted(each.left_out.items())]
    used = [each for each in used if min(len(each.observable.experiments), len(each.observable.samples)) > 1]
    if not used:
        return {"p_value": math.nan, "n_experiments": 0, "by": {}, "ways": ways, "left_out": left_out} if ways else None
    by = {each.observable.quantity: _match_set_by([each.observable], experiments, samples) for each in used}
    all_of_them = distinct([each.observable for each in used])
    least = min(each["p_value"] for each in by.values())
    p = min(1.0, len(all_of_them) * least)
    if len(all_of_them) > 1 and min(map(len, _common(all_of_them)[:2])) > 1:
        by["jointly"] = _match_set_by(all_of_them, experiments, samples)
        p = by["jointly"]["p_value"]
    return {"p_value": p, "n_experiments": max(each["n_experiments"] for each in by.values()), "by": by, "ways": ways, "left_out": left_out}


def _match_set_by(observables: Sequence[Observable], experiments: Sequence[Experiment], samples: ObservedSamples) -> dict[str, Any]:
    rows, of_samples, tables = _common(observables)
    apart = _distances(tables)
    test = group_test(apart, len(rows))
    only = observables[0] if len(observables) == 1 else None
    means = apart.sum(axis=1) / (len(apart) - 1)
    found: dict[str, Any] = {
        "p_value": test.p, "n_experiments": len(rows), "n_samples": len(of_samples), "unit": only.unit if only else "1",
        "energy_distance": test.energy, "energy_p_value": test.p_energy, "depth_p_value": test.p_depth, "n_permutations": test.n_permutations,
        "all_permutations": test.are_all, "farthest": experiments[rows[int(means[:len(rows)].argmax())]].name}
    if only is None:
        return found
    found["limit"] = only.limit
    strength = power(only.with_error, len(rows)) if only.limit is None else None
    found["power"] = {"shift_of_one_deviation": strength.of_shift / strength.n_trials if strength else math.nan,
                      "twice_the_scatter": strength.of_scatter / strength.n_trials if strength else math.nan,
                      "n_trials": strength.n_trials if strength else 0}
    differ = scatter(only.of_experiments, only.of_samples, only.error) if only.limit is None else Scatter()
    found.update(shift=_interval(differ.shift), shift_axis=("y" if only.frame.is_along_y else "z") if only.frame else "",
                 scatter_ratio=_interval(differ.ratio), degrees_of_freedom=differ.degrees, n_complete_samples=differ.n_samples)
    if only.unit == "N":
        loads = only.unclipped or only
        found["weibull"] = {whose: weibull.document(values[:, 0], ~unbroken) for whose, values, unbroken in (
            ("experiments", loads.of_experiments, loads.unbroken_experiments), ("samples", loads.of_samples, loads.unbroken_samples))}
    found["advice"] = match_text.advice(found, samples.share_base)
    return found


def _interval(found: Difference) -> dict[str, float]:
    return {"value": found.value, "lower": found.lower, "upper": found.upper}


def _warnings(experiments: Sequence[Experiment], samples: ObservedSamples) -> Iterator[str]:
    document, n = samples.document, len(samples.samples)
    if document["has_points"]:
        yield ("the samples share their base of mother points, mesh.points, an experiment does not: the p-values are too small, so not valid, "
               "and no conclusion follows from them")
    elif document["base"] == "shared":
        yield ('the samples share their base of mother points (mesh.base = "shared"), an experiment does not: they are more alike than bodies '
               'of their own are, and the p-values are too small, so not valid; compute the ensemble with base = "own"')
    if document["replicates"] > 1:
        yield (f"{document['replicates']} samples share each draw of the random inputs, so they are not independent, and the p-values are not "
               "exact")
    if n < samples_needed():
        yield (f"{n} sample{'' if n == 1 else 's'} cannot give a p-value below {least_p_value(n):.2g}, whatever the experiment; "
               f"{samples_needed()} are needed for {LEVEL}")
    starts = {start_of(one, samples) for one in experiments if needs_arms([one])}
    n_turned = sum(any(0 <= start < len(one.arms) and one.arms[start] and one.arms[start][0].is_turned for start in starts)
                   for one in samples.samples)
    if n_turned:
        yield (f"in {n_turned} of the samples another crack leads than that from the experiment's start; their paths are turned by the symmetry "
               "of body and loads")


# Samples in the place of experiments.

def as_experiment(sample: Any, samples: ObservedSamples) -> Experiment:
    """A sample as an experiment read without error: the main arm of its leading crack, arrested where it ended inside the body, and
    its loads."""
    experiment = Experiment(f"sample {sample.number}", run_out=sample.is_unbroken)
    start = sample.leading_start
    notch = next((s for s, each in enumerate(samples.starts) if each.is_notch and s < len(sample.arms) and sample.arms[s]
                  and start >= 0 and samples.starts[start].is_hole), start)
    if 0 <= notch < len(sample.arms) and sample.arms[notch]:
        arm = max(sample.arms[notch], key=lambda each: length_of(each.points))
        slab = length_of(arm.points) / (len(arm.points) - 1)
        room = min((each.distance(arm.points[-1]) for s, each in enumerate(samples.starts) if s != notch and not each.is_notch), default=math.inf)
        room = min(room, *(arm.points[-1] - samples.lower), *(samples.upper - arm.points[-1]))
        steps = np.linalg.norm(np.diff(arm.points, axis=0), axis=1)
        across = np.sort(np.argsort(steps)[len(steps) - len(arm.holes):]) + 1  # holes, behind which it is another arm
        experiment = replace(experiment, lines=np.split(arm.points, across), arrested=bool(room > 2 * slab))
    return replace(experiment, **{name: None if math.isnan(load) else load for name, load in (
        ("onset_load", math.nan if sample.is_unbroken else sample.onset_load), ("peak_load", sample.peak_load))})


def hold_out(samples: ObservedSamples, n: int) -> tuple[list[Experiment], ObservedSamples]:
    """Takes n samples at random, the same ones in each call. Raises ResultsError unless two are left."""
    if not 1 <= n <= len(samples.samples) - 2:
        raise ResultsError(f"of {len(samples.samples)} samples 1 to {max(len(samples.samples), 2) - 2} can be held out, not {n}")
    chosen = random_stream(samples.seed, 4).choice(len(samples.samples), n, replace=False)
    return ([as_experiment(samples.samples[i], samples) for i in chosen],
            replace(samples, samples=[one for i, one in enumerate(samples.samples) if i not in chosen]))


def p_values_of(of: ObservedSamples, samples: ObservedSamples) -> dict[int, float]:
    """The p-value of each sample of one ensemble as an experiment beside those of another, or of the same without it, by number."""
    found = {}
    for i, one in enumerate(of.samples):
        others = samples if of is not samples else replace(samples, samples=samples.samples[:i] + samples.samples[i + 1:])
        found[one.number] = _match_one(as_experiment(one, of), others)["p_value"]
    return found
