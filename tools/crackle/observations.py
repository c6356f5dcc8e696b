# SPDX-License-Identifier: GPL-3.0-or-later
"""The samples of an ensemble as an experiment would see them: their cracks, loads and times."""
from __future__ import annotations

import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Iterable, Optional, Sequence

import numpy as np

from .experiments import Experiment, ExperimentsError
from .files import SAMPLE_KIND, ResultsError, results
from .path_frame import (Gaps, PathFrame, Window, arc_lengths, extended, length_of, offsets, path_frame, point_at, project,
                         with_reading_error)
from .program import observed_of

SAME_LOAD = 0.999  # loads with a larger correlation over the samples are one quantity
MUCH_NEARER = 5  # a crack begins at the first point of its path unless the last one is this much nearer to a start
OUTSIDE_SHARE = 0.1  # places may lie outside of the body by this share of its size
DRAWN_OUT = 1.5  # arms are drawn out by this, in mean distances of their points, which are those of slabs
SAME_ROOT = 3  # lines that begin within this distance begin at one place [slabs]
AT_HOLE = 0.2  # a crack ends at a hole within this share of the hole's size
N_PIECES = 100  # into which an arm is cut to measure how much of it is in a box
QUANTITIES = ("path", "onset_load", "peak_load", "tip_times", "stiffness")


@dataclass(frozen=True)
class Arm:
    """A crack's main arm: points n x 2 [m] with the times since the last dynamic phase began [s]."""
    points: np.ndarray
    time: np.ndarray
    is_turned: bool = False  # by a symmetry of the body
    holes: frozenset[int] = frozenset()  # through which it goes on, by crack start


@dataclass(frozen=True)
class Start:
    """A place where cracks start, in the y-z plane [m]; see src/geometry/crack_start.h."""
    name: str
    is_straight: bool
    is_free_surface: bool
    is_hole: bool
    tip: np.ndarray
    end: np.ndarray
    slot: np.ndarray  # smallest and largest y, z
    walls: np.ndarray  # k x 2 ends x 2

    @property
    def is_notch(self) -> bool:
        return not self.is_hole and not self.is_free_surface

    def distance(self, place: np.ndarray, under_way: bool = False) -> float:
        """To the tip of a notch with a ligament, else to the nearest wall.

        @param under_way: the crack may have come to the place along the ligament
        """
        if self.is_straight:
            line = np.array([self.tip, self.end if under_way else self.tip])
            return float(project(line, place[None])[1][0])
        return min((float(project(wall, place[None])[1][0]) for wall in self.walls), default=np.inf)

    def holds(self, places: np.ndarray) -> np.ndarray:
        """Whether each place (n x 2) lies within the walls of a hole."""
        a, b = self.walls[:, 0], self.walls[:, 1]
        with np.errstate(divide="ignore", invalid="ignore"):
            at = a[:, 1] + (places[:, :1] - a[:, 0]) / (b[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])
            is_above = ((a[:, 0] > places[:, :1]) != (b[:, 0] > places[:, :1])) & (places[:, 1:] < at)
        return is_above.sum(axis=1) % 2 == 1


@dataclass(frozen=True)
class Symmetry:
    """A map of the body and its loads onto themselves."""
    crack_start: tuple[int, ...]  # the image of each
    matrix: np.ndarray
    shift: np.ndarray

    def image(self, points: np.ndarray) -> np.ndarray:
        return points @ self.matrix.T + self.shift


@dataclass
class ObservedSample:
    """A sample that is done. `arms` has for each crack start of the body those that an experiment's crack from there is compared
    with; it is empty where paths are not needed."""
    number: int
    leading_start: int
    onset_load: float  # [N]; without quasi-static loading that of the first break; NaN if it has none
    peak_load: float  # [N]
    is_unbroken: bool = False  # peak_load is what it bore
    inputs: tuple[float, ...] = ()  # random ones [SI]
    arms: list[list[Arm]] = field(default_factory=list)
    stiffness: float = np.nan  # load over displacement of the first equilibrium under load [N/m]; NaN from rest, or where not needed


@dataclass
class ObservedSamples:
    """Those that count; `failed`, `undecided` and `missing` are numbers of others. `document` is the program's whole answer."""
    samples: list[ObservedSample]
    starts: list[Start]
    symmetries: list[Symmetry]
    lower: np.ndarray  # of the body: y, z
    upper: np.ndarray
    document: dict[str, Any]
    missing: list[int]
    gaps: Gaps = field(default_factory=Gaps)  # between their paths, as far as they are known
    paths: dict[tuple, Any] = field(default_factory=dict)  # of samples_paths, likewise

    @property
    def share_base(self) -> bool:
        return self.document["base"] == "shared" or self.document["has_points"]

    @property
    def seed(self) -> int:
        return int(self.document["seed"])


# Reading.

def _symmetries(found: Iterable[dict]) -> list[Symmetry]:
    return [Symmetry(tuple(one["crack_start"]), np.array(one["matrix"]), np.array(one["shift"])) for one in found]


def observed_samples(folder: Path, with_arms: bool, program: Optional[Path] = None) -> ObservedSamples:
    """The samples of an ensemble's folder.

    @param with_arms: also their cracks, from the sample files
    Raises ResultsError where these are needed and missing, or no sample is done.
    """
    document = observed_of(folder, program)
    folder = folder.parent if folder.is_file() else folder
    starts = [Start(**{name: np.array(value) if isinstance(value, list) else value for name, value in one.items()})
              for one in document["starts"]]
    symmetries = _symmetries(document["symmetries"])
    rows = document["samples"]
    if not rows:
        raise ResultsError(f"'{folder}' has no sample that is done and decided")
    samples = [ObservedSample(row["number"], row["leading_start"], *(np.nan if row[name] is None else row[name] for name in ("onset_load", "peak_load")),
                              row["is_unbroken"], tuple(row["inputs"])) for row in rows]
    missing = list(document["missing"])
    if with_arms:
        for sample, row in zip(samples, rows):
            file = folder / "samples" / f"{sample.number:04d}.h5"
            if not file.is_file():
                missing.append(sample.number)
                continue
            try:
                lines, sample.stiffness = _main_lines(file), _stiffness(file)
            except ResultsError as error:
                print(f"sample {sample.number} is left out: {error}", file=sys.stderr)
                missing.append(sample.number)
            else:
                own = _symmetries(row["symmetries"]) if "symmetries" in row else symmetries
                sample.arms = _arms(lines, sample.leading_start, starts, own)
        samples = [sample for sample in samples if sample.arms]
        if not samples:
            raise ResultsError(f"'{folder}' holds no sample files; paths, tips and slopes are compared with what is in these, loads alone "
                               "with ensemble.h5, too")
    return ObservedSamples(samples, starts, symmetries, np.array(document["lower"]), np.array(document["upper"]), document, sorted(missing))


def _main_lines(file: Path) -> list[tuple[int, Arm]]:
    """Crack start and line of each ligament's crack; branches do not count."""
    with results(file, SAMPLE_KIND) as root:
        found, table = root["crack_lines"], root["crack_lines/lines"]
        points = found["position"][...]
        time = found["time"][...] if "time" in found else np.full(len(points), np.nan)
        if not np.isfinite(points).all():
            raise ResultsError(f"cannot use '{file}': places of its crack lines are not numbers")
        return [(int(start), Arm(points[first:first + count], time[first:first + count]))
                for first, count, start, parent in zip(*(table[name][...] for name in ("first", "count", "notch", "parent")))
                if parent < 0 and count >= 2]


def _stiffness(file: Path) -> float:
    with results(file, SAMPLE_KIND) as root:
        if "history" not in root:
            return np.nan
        phase, load, displacement = (root["history"][name][...] for name in ("phase", "governing_load", "governing_displacement"))
    loaded = np.flatnonzero((phase == 0) & (load > 0) & (displacement > 0))
    return float(load[loaded[0]] / displacement[loaded[0]]) if loaded.size else np.nan


def symmetry_to(symmetries: Sequence[Symmetry], start: int, wanted: int) -> Optional[Symmetry]:
    """The first that maps one crack start onto another."""
    return next((each for each in symmetries if each.crack_start[start] == wanted), None)


def _arms(lines: list[tuple[int, Arm]], leading: int, starts: list[Start], symmetries: list[Symmetry]) -> list[list[Arm]]:
    """For a start with a ligament the main line of the leading crack, turned onto the start by a symmetry; if there is none, that
    of the start itself; with what goes on behind a hole into which it runs. For another start the main lines of all its ligaments
    and, if two of them begin at one place, both as one."""
    arms: list[list[Arm]] = []
    for s, start in enumerate(starts):
        symmetry = symmetry_to(symmetries, leading, s) if start.is_straight and leading >= 0 and leading != s else None
        its = [arm for number, arm in lines if number == (leading if symmetry else s)]
        if start.is_notch and (fronts := [arm for arm in its if hole_at(arm.points[0], starts) is None]):
            its = [_through_holes(arm, lines, starts) for arm in fronts]
        if symmetry:
            its = [Arm(symmetry.image(arm.points), arm.time, True, frozenset(symmetry.crack_start[hole] for hole in arm.holes)) for arm in its]
        if len(its) == 2 and np.linalg.norm(its[0].points[0] - its[1].points[0]) <= SAME_ROOT * (_slab(its[0]) + _slab(its[1])) / 2:
            its.append(Arm(np.vstack([its[0].points[::-1], its[1].points]), np.append(its[0].time[::-1], its[1].time), its[0].is_turned))
        arms.append(its)
    return arms


def _through_holes(arm: Arm, lines: list[tuple[int, Arm]], starts: list[Start]) -> Arm:
    """The crack with the longest line that goes on from the hole in which it ends, and so on."""
    passed: set[Optional[int]] = {None}
    while (hole := hole_at(arm.points[-1], starts, SAME_ROOT * _slab(arm))) not in passed:
        passed.add(hole)
        beyond = max((each for _, each in lines if each is not arm and hole_at(each.points[0], starts) == hole),
                     key=lambda each: length_of(each.points), default=None)
        if beyond:
            arm = Arm(np.vstack([arm.points, beyond.points]), np.append(arm.time, beyond.time), holes=arm.holes | {hole})
    return arm


def hole_at(place: np.ndarray, starts: Sequence[Start], tolerance: float = 0.0) -> Optional[int]:
    """The hole in or at which a place lies."""
    near = ((start.distance(place) if not start.holds(place[None])[0] else 0.0, s) for s, start in enumerate(starts) if start.is_hole)
    distance, hole = min(near, default=(np.inf, -1))
    return hole if hole >= 0 and distance <= max(tolerance, AT_HOLE * np.linalg.norm(np.ptp(starts[hole].slot, axis=0))) else None


def whole_path(experiment: Experiment, starts: Sequence[Start]) -> tuple[np.ndarray, frozenset[int]]:
    """The path of its main arm and, where that ends at a hole, of the arm that goes on from there; and the holes between."""
    path, rest, holes = experiment.lines[0], list(experiment.lines[1:]), set()
    while rest and (hole := hole_at(path[-1], starts)) is not None:
        k = next((k for k, line in enumerate(rest) if hole_at(line[0], starts) == hole), None)
        if k is None:
            break
        path = np.vstack([path, rest.pop(k)])
        holes.add(hole)
    return path, frozenset(holes)


def _slab(arm: Arm) -> float:
    return length_of(arm.points) / (len(arm.points) - 1)


# What of it an experiment sees.

def needs_arms(experiments: Iterable[Experiment]) -> bool:
    return any(each.lines or len(each.tip_times) for each in experiments)


def needs_files(experiments: Sequence[Experiment]) -> bool:
    return needs_arms(experiments) or any(each.stiffness is not None for each in experiments)


def _seen_points(experiment: Experiment) -> np.ndarray:
    return np.vstack([*experiment.lines[:1], experiment.tip_places])


def start_of(experiment: Experiment, samples: ObservedSamples) -> int:
    """The start of the samples' cracks with which an experiment's is compared. Of one that begins at a hole, it is the notch from which
    most cracks come that go on from there; of one at the free surface, where no sample has a crack, the start from which most lead."""
    start = crack_start_of(experiment, samples.starts)
    if not 0 <= start < len(samples.starts):
        return start
    if samples.starts[start].is_free_surface and not any(start < len(sample.arms) and sample.arms[start] for sample in samples.samples):
        leading = [sample.leading_start for sample in samples.samples if sample.leading_start >= 0]
        start = int(np.bincount(leading).argmax()) if leading else start
    if not samples.starts[start].is_hole:
        return start
    notches = [s for s, each in enumerate(samples.starts) if each.is_notch]
    n_from = [sum(any(start in arm.holes or hole_at(arm.points[-1], samples.starts) == start for arm in sample.arms[s])
                  for sample in samples.samples if s < len(sample.arms)) for s in notches]
    n_at = sum(bool(start < len(sample.arms) and sample.arms[start]) for sample in samples.samples)
    return notches[int(np.argmax(n_from))] if notches and 2 * max(n_from) > n_at else start


def check_places(file: Path, experiments: Iterable[Experiment], samples: ObservedSamples) -> None:
    """Refuses paths and tips that lie elsewhere than the body. Raises ExperimentsError that names all experiments concerned."""
    margin = OUTSIDE_SHARE * (samples.upper - samples.lower)
    messages = []
    for experiment in experiments:
        points = _seen_points(experiment)
        if len(points) and not ((points >= samples.lower - margin) & (points <= samples.upper + margin)).all():
            spans = [f"y = {1e3 * low[0]:.4g} to {1e3 * high[0]:.4g} mm and from z = {1e3 * low[1]:.4g} to {1e3 * high[1]:.4g} mm"
                     for low, high in ((points.min(axis=0), points.max(axis=0)), (samples.lower, samples.upper))]
            messages.append(f'{file}: experiment "{experiment.name}": its crack goes from {spans[0]}, the body from {spans[1]}; set origin, '
                            "angle and mirror, or the units in the header of the file")
    if messages:
        raise ExperimentsError(messages)


def crack_start_of(experiment: Experiment, starts: Sequence[Start]) -> int:
    """The crack start nearest to an end of the main arm: the tip of a notch with a ligament, else a wall; the free surface only if
    an end of the arm is nearer to it than to any other start. Without a path, the start whose ligament or wall is nearest to the
    first tip. -1 if there is none."""
    surface = next((s for s, start in enumerate(starts) if start.is_free_surface), -1)

    def nearest(place: np.ndarray, under_way: bool = False) -> tuple[float, int]:
        return min(((start.distance(place, under_way), s) for s, start in enumerate(starts) if not start.is_free_surface),
                   default=(np.inf, -1))

    if not experiment.lines:
        found = nearest(experiment.tip_places[0], True)[1] if len(experiment.tip_places) else -1
        return found if found >= 0 or not len(experiment.tip_places) else surface
    ends = whole_path(experiment, starts)[0][[0, -1]]
    first, last = nearest(ends[0]), nearest(ends[1])
    distance, start = first if first[0] <= MUCH_NEARER * last[0] else last
    if surface < 0:
        return start
    end = ends[0] if first[0] <= MUCH_NEARER * last[0] else ends[1]
    return start if distance <= starts[surface].distance(end) else surface


def arm_in_sight(sample: ObservedSample, start: int, points: np.ndarray) -> Optional[Arm]:
    """The arm of which most is in the box round these points, which is widened by its half diagonal; None without a crack."""
    if start < 0 or start >= len(sample.arms) or not sample.arms[start]:
        return None
    if len(sample.arms[start]) == 1:
        return sample.arms[start][0]
    lower, upper = points.min(axis=0), points.max(axis=0)
    margin = np.linalg.norm(upper - lower) / 2

    def length_within(arm: Arm) -> float:
        length = length_of(arm.points)
        places = point_at(arm.points, length * (np.arange(N_PIECES) + 0.5) / N_PIECES)
        return length * ((places >= lower - margin) & (places <= upper + margin)).all(axis=1).mean()

    return max(sample.arms[start], key=length_within)


def drawn_out_by(arm: Arm) -> float:
    return DRAWN_OUT * _slab(arm)


def arrival_at(arm: Arm, place: np.ndarray) -> float:
    """When the crack came to the nearest point of its path, 0 if it was there before it ran away; NaN if it ended before."""
    margin, length = drawn_out_by(arm), length_of(arm.points)
    at = project(extended(arm.points, margin), place[None])[0][0]
    if at >= length + 2 * margin * (1 - 1e-9):  # the very end of what was drawn out: the place lies farther ahead
        return np.nan
    return float(np.interp(np.clip(at - margin, 0, length), arc_lengths(arm.points), np.maximum(0.0, arm.time)))


@dataclass
class Observable:
    """A quantity of experiments and of samples alike, in rows; NaN: a crack did not get there."""
    quantity: str  # of QUANTITIES
    unit: str
    error: float  # of reading or measuring in the experiments: standard deviation, their root mean square
    experiments: list[int]  # those that have it
    samples: list[int]  # indices of those that have it
    of_experiments: np.ndarray
    of_samples: np.ndarray  # as computed
    with_error: np.ndarray  # of samples, as if they had been read or measured
    error_length: float = 0.0  # correlation length of the error along paths, their mean [m]
    frame: Optional[PathFrame] = None
    turned: list[int] = field(default_factory=list)  # samples whose paths are turned by a symmetry of the body
    unbroken_experiments: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))  # whose loads are bounds from below
    unbroken_samples: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))  # likewise
    limit: Optional[float] = None  # up to which loads are compared [N], where some are bounds
    unclipped: Optional["Observable"] = None  # without that limit


def errors_of(samples: ObservedSamples, sample: ObservedSample, quantity: str) -> np.random.Generator:
    """The stream of a sample's errors: the same in each call, and for all experiments."""
    return np.random.Generator(np.random.Philox(np.random.SeedSequence([samples.seed, sample.number, QUANTITIES.index(quantity)])))


def _root_mean_square(values: Iterable[float]) -> float:
    return float(np.sqrt(np.mean(np.square(list(values)))))


def is_same_load(one: Observable, other: Observable) -> bool:
    """Two loads are one quantity in the samples, such as onset and peak of cracks that do not stop. @pre the same samples have them"""
    if one.unit != "N" or other.unit != "N" or one.samples != other.samples or len(one.samples) < 3:
        return False
    a, b = (each.of_samples[:, 0] - each.of_samples[:, 0].mean() for each in (one, other))
    return bool((a * b).sum() > SAME_LOAD * np.sqrt((a ** 2).sum() * (b ** 2).sum()))


def distinct(observables: Sequence[Observable]) -> list[Observable]:
    """Loads that are one quantity count once."""
    found: list[Observable] = []
    for each in observables:
        if not any(other.experiments == each.experiments and is_same_load(other, each) for other in found):
            found.append(each)
    return found


def observe_load(experiments: Sequence[Experiment], samples: ObservedSamples, quantity: str) -> Optional[Observable]:
    """Of a specimen or sample that did not break, the largest load that it bore, which bounds the quantity from below."""
    loads = [one.peak_load if one.run_out else getattr(one, quantity) for one in experiments]
    if all(load is None for load in loads) or all(getattr(one, quantity) is None for one in experiments):
        return None
    having = [i for i, load in enumerate(loads) if load is not None]
    error = _root_mean_square(experiments[i].load_error for i in having)
    exact = np.array([one.peak_load if one.is_unbroken else getattr(one, quantity) for one in samples.samples])
    numbers = [int(i) for i in np.flatnonzero(~np.isnan(exact))]
    exact = exact[numbers].reshape(-1, 1)
    drawn = [errors_of(samples, samples.samples[i], quantity).standard_normal() if error > 0 else 0.0 for i in numbers]
    return Observable(quantity, "N", error, having, numbers, np.array([[loads[i]] for i in having]), exact,
                      exact + error * np.array(drawn).reshape(-1, 1), unbroken_experiments=np.array([experiments[i].run_out for i in having]),
                      unbroken_samples=np.array([samples.samples[i].is_unbroken for i in numbers], bool))


def observe_stiffness(experiments: Sequence[Experiment], samples: ObservedSamples) -> Optional[Observable]:
    having = [i for i, one in enumerate(experiments) if one.stiffness is not None]
    numbers = [i for i, one in enumerate(samples.samples) if not np.isnan(one.stiffness)]
    if not having or not numbers:
        return None
    error = _root_mean_square(experiments[i].stiffness_error for i in having)
    exact = np.array([[samples.samples[i].stiffness] for i in numbers])
    drawn = np.array([[errors_of(samples, samples.samples[i], "stiffness").standard_normal()] for i in numbers])
    return Observable("stiffness", "N/m", error, having, numbers, np.array([[experiments[i].stiffness] for i in having]), exact, exact + error * drawn)


@dataclass
class SeenPaths:
    """The paths of experiments that are compared, all on the crack start of the first one, and those of samples."""
    experiments: list[int]
    lines: list[np.ndarray]
    holes: list[frozenset[int]]  # through which they go on in another arm, by crack start
    are_reversed: list[bool]  # as given: they ended where cracks start
    windows: list[Window]
    error: float
    error_length: float
    margin: float  # by which all curves are drawn out
    arms: list[Optional[Arm]]  # of all samples
    exact: list[Optional[np.ndarray]]  # likewise, drawn out
    read: list[Optional[np.ndarray]]  # with an error of reading
    curves: list[np.ndarray]  # of the experiments, drawn out


def seen_paths(experiments: Sequence[Experiment], samples: ObservedSamples) -> Optional[SeenPaths]:
    """None without a path. Paths from other starts are turned onto the first one's by a symmetry, or left out."""
    having, lines, holes, are_reversed, wanted = [], [], [], [], None
    for i, experiment in enumerate(experiments):
        if not experiment.lines:
            continue
        (line, through), start = whole_path(experiment, samples.starts), start_of(experiment, samples)
        notch = samples.starts[start] if start >= 0 else None
        is_reversed = bool(notch and notch.is_notch and notch.distance(line[-1]) < notch.distance(line[0]))
        line = line[::-1] if is_reversed else line
        wanted = start if wanted is None else wanted
        if start != wanted:
            symmetry = symmetry_to(samples.symmetries, start, wanted)
            if symmetry is None:
                continue
            line, through = symmetry.image(line), frozenset(symmetry.crack_start[hole] for hole in through)
        having.append(i)
        lines.append(line)
        holes.append(through)
        are_reversed.append(is_reversed)
    if not having:
        return None
    windows = [Window(line[0], line[-1], experiments[i].arrested) for i, line in zip(having, lines)]
    error = _root_mean_square(experiments[i].path_error for i in having)
    error_length = float(np.mean([experiments[i].path_error_length for i in having]))
    arms = [arm_in_sight(sample, wanted, np.vstack(lines)) for sample in samples.samples]
    margin = samples.paths.setdefault(("margin", wanted), float(np.mean([drawn_out_by(arm) for arm in arms if arm] or [0.0])))
    exact, read = (samples_paths(samples, arms, margin, *of) for of in ((0.0, 0.0), (error, error_length)))
    return SeenPaths(having, lines, holes, are_reversed, windows, error, error_length, margin, arms, exact, read, [extended(line, margin) for line in lines])


def samples_paths(samples: ObservedSamples, arms: Sequence[Optional[Arm]], margin: float, error: float,
                  error_length: float) -> list[Optional[np.ndarray]]:
    """The arms of all samples drawn out by the margin and read with this error; None without a crack."""
    found: list[Optional[np.ndarray]] = []
    for sample, arm in zip(samples.samples, arms):
        key = (id(arm), margin, error, error_length)
        if arm and key not in samples.paths:
            line = extended(arm.points, margin) if error == 0 else samples.paths[id(arm), margin, 0.0, 0.0]
            samples.paths[key] = with_reading_error(line, error, error_length, errors_of(samples, sample, "path"))
        found.append(samples.paths[key] if arm else None)
    return found


def observe_path(experiments: Sequence[Experiment], samples: ObservedSamples, seen: Optional[SeenPaths] = None,
                 members: Optional[Sequence[int]] = None) -> Optional[Observable]:
    """@param members: indices of the samples with which they are compared; all by default"""
    seen = seen or seen_paths(experiments, samples)
    if seen is None:
        return None
    members = list(range(len(seen.arms)) if members is None else members)
    exact, read = ([of[i] for i in members] for of in (seen.exact, seen.read))
    frame = path_frame(seen.curves + [curve for curve in read if curve is not None], seen.windows, samples.gaps)
    if frame is None:
        return None
    tables = [np.array([offsets(frame, curve) for curve in of]).reshape(-1, len(frame.place)) for of in (seen.curves, exact, read)]
    in_hole = np.logical_or.reduce([start.holds(frame.place) for start in samples.starts if start.is_hole] or [np.zeros(len(frame.place), bool)])
    for table in tables:
        table[:, in_hole] = np.nan  # there is no crack
    return Observable("path", "m", seen.error, seen.experiments, members, *tables, seen.error_length, frame,
                      [i for i in members if seen.arms[i] and seen.arms[i].is_turned])


def observe_tips(experiment: Experiment, samples: ObservedSamples) -> Optional[Observable]:
    if not len(experiment.tip_times):
        return None
    start = start_of(experiment, samples)
    arms = [arm_in_sight(sample, start, _seen_points(experiment)) for sample in samples.samples]
    exact = np.array([[arrival_at(arm, place) if arm else np.nan for place in experiment.tip_places] for arm in arms])
    drawn = np.array([errors_of(samples, sample, "tip_times").standard_normal(exact.shape[1]) for sample in samples.samples])
    return Observable("tip_times", "s", experiment.time_error, [0], list(range(len(arms))), experiment.tip_times[None], exact,
                      exact + experiment.time_error * drawn)


def observe(experiments: Sequence[Experiment], samples: ObservedSamples) -> list[Observable]:
    """Everything that any of the experiments has, with the samples seen as the experiments were: through the same window, with
    errors of the same size. Times of tips only of a single experiment, since others have their own places. Paths from other crack
    starts than the first experiment's are turned onto that by a symmetry of the body, or left out if it has none."""
    found = [observe_path(experiments, samples), *(observe_load(experiments, samples, load) for load in ("onset_load", "peak_load")),
             observe_tips(experiments[0], samples) if len(experiments) == 1 else None, observe_stiffness(experiments, samples)]
    return [each for each in found if each is not None]
