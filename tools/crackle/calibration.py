# SPDX-License-Identifier: GPL-3.0-or-later
"""The random inputs of an ensemble, given experiments: their posterior by a synthetic likelihood with an emulator of the samples' results."""
from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Optional, Sequence

import numpy as np
import pandas as pd
from scipy import optimize, signal, special, stats

from .emulator import MOST_BOUNDS, Basis, Discrete, Emulator, Inputs, Values, imputed
from .files import ResultsError
from .inference import SIGNIFICANT, wilson
from .observations import Observable, check_places, is_same_load, needs_files, observe, observed_samples
from .path_frame import PathFrame
from .posterior import FULL, PART, SMALL, Block, Likelihood, Observed, Points, Terms, observed, random_numbers, sample
from .text import aligned, count, json_text, named, p_is, percent, plain, probability, quantity, readable

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LEVEL = 0.9  # of the intervals
UNEVEN = 0.01  # p from which on the scatter of meshes is a function of the inputs
COVERAGE_LEVELS = (0.5, 0.9)
MOST_LEFT_OUT = 200  # draws
LEAST_EFFECTIVE_SIZE = 1000  # for intervals
LEAST_DRAWS_PER_INPUT = 4  # and one more, that an emulator needs
LEAST_DEGREES = 5.0  # of freedom, that the distribution of the observations needs
HELD_SHARE, MOST_COMPONENTS = 0.99, 5  # of the variance of paths, by so many components at most
LEAST_SHARE = 0.9  # of the samples that have a column which counts
EDGE = 0.95  # a median with this share of the prior on one side lies at its edge
LEAST_CORRELATION = 0.1  # worth a line
LEAST_WEIGHT = 1e-6  # that is written
LEAST_MODE = 0.1  # share of a posterior


@dataclass
class PathComponents:
    """Paths as few numbers: principal components of the samples' offsets."""

    frame: PathFrame
    stations: np.ndarray  # of the frame, that experiments and samples reach
    mean: np.ndarray  # offset at each of them [m]
    basis: np.ndarray  # stations x components, orthonormal columns
    shape_p_value: float


@dataclass
class Data:
    """Experiments and samples as components; those of the path are the first ones."""

    inputs: Inputs
    draws: np.ndarray  # draws x inputs [SI]
    values: Values  # of the samples, as computed
    as_read: np.ndarray  # likewise, as if read or measured
    seen: Observed
    is_bound: Optional[np.ndarray] = None  # values that lie above
    path: Optional[PathComponents] = None
    experiments: list[int] = field(default_factory=list)
    left_out: list[int] = field(default_factory=list)  # numbers of samples that lack a component
    notes: list[str] = field(default_factory=list)


def smooth_shape(places: np.ndarray) -> np.ndarray:
    """Covariance of a smooth deviation with unit variance at places along a line; its correlation length is a third of theirs."""
    if len(places) < 2:
        return np.eye(len(places))
    return np.exp(-((places[:, None] - places) / ((places[-1] - places[0]) / 3))**2 / 2)


# Experiments and samples as components


@dataclass
class _Part:
    block: Block
    experiments: list[int]
    samples: list[int]  # ascending
    of_experiments: np.ndarray
    of_samples: np.ndarray
    as_read: np.ndarray
    error: np.ndarray
    bounds: np.ndarray  # experiments whose value lies above
    is_bound: np.ndarray  # samples likewise


def _part(one: Observable, n_samples: int) -> Optional[_Part]:
    """With the columns that all experiments have, and enough of the samples."""
    columns = np.flatnonzero(~np.isnan(one.of_experiments).any(axis=0) & (np.sum(~np.isnan(one.of_samples), axis=0) >= LEAST_SHARE * n_samples))
    if not columns.size:
        return None
    kept = np.flatnonzero(~np.isnan(one.of_samples[:, columns]).any(axis=1))
    n = columns.size
    flags = [given if given.size else np.zeros(size, bool) for given, size in ((one.unbroken_experiments, len(one.experiments)), (one.unbroken_samples, len(one.samples)))]
    return _Part(Block(one.quantity, one.unit, 0, n, smooth_shape(np.arange(n, dtype=float))), one.experiments, [one.samples[i] for i in kept],
                 one.of_experiments[:, columns], one.of_samples[kept][:, columns], one.with_error[kept][:, columns], one.error**2 * np.eye(n), flags[0], flags[1][kept])


def _axes(offsets: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean of paths, variances in ascending order and their directions."""
    mean = offsets.mean(axis=-2, keepdims=True)
    return mean, *np.linalg.eigh(np.swapaxes(offsets - mean, -1, -2) @ (offsets - mean))


def _shape_p_value(part: _Part, kept: int) -> float:
    """Least rank of what the components leave of the experiments' offsets, for all experiments together. The components that a sample is ranked by are those of
    the others."""
    def rest(offsets: np.ndarray, mean: np.ndarray, direction: np.ndarray) -> np.ndarray:
        centred, basis = offsets - mean, direction[..., -kept:]
        return np.linalg.norm(centred - centred @ basis @ np.swapaxes(basis, -1, -2), axis=-1)
    n = len(part.of_samples)
    of_samples = np.empty(n)
    for i in range(n):
        mean, _, direction = _axes(np.delete(part.of_samples, i, axis=0))
        of_samples[i] = rest(part.as_read[i], mean[0], direction)
    mean, _, direction = _axes(part.of_samples)
    own = np.atleast_1d(rest(part.of_experiments, mean, direction)) * (1 - 1e-9)
    return float(min(1.0, min((np.sum(of_samples >= one) + 1) / (n + 1) for one in own) * len(own)))


def _reduce(one: Observable, part: _Part) -> PathComponents:
    """Replaces the offsets of a path by components."""
    assert one.frame is not None
    part.as_read = np.where(np.isnan(part.as_read), part.of_samples, part.as_read)  # what is read may miss a station that the exact path reaches
    mean, variance, direction = _axes(part.of_samples)
    kept = 1
    while kept < min(variance.size, MOST_COMPONENTS) and variance[-kept:].sum() < HELD_SHARE * variance.sum():
        kept += 1
    basis = direction[:, -kept:][:, ::-1]
    basis = basis * np.where(basis.sum(axis=0) < 0, -1, 1)
    stations = np.flatnonzero(~np.isnan(one.of_experiments).any(axis=0) & (np.sum(~np.isnan(one.of_samples), axis=0) >= LEAST_SHARE * len(one.of_samples)))
    path = PathComponents(one.frame, stations, mean[0], basis, _shape_p_value(part, kept))
    places = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(one.frame.place[stations], axis=0), axis=1))])
    apart = np.abs(places[:, None] - places)
    error = one.error**2 * (np.exp(-apart / one.error_length) if one.error_length > 0 else np.eye(places.size))
    part.of_samples, part.as_read, part.of_experiments = ((offsets - path.mean) @ basis for offsets in (part.of_samples, part.as_read, part.of_experiments))
    part.error, part.block.shape, part.block.count = basis.T @ error @ basis, basis.T @ smooth_shape(places) @ basis, kept
    return path


def calibration_data(observables: Sequence[Observable], samples: Sequence[Any], n_samples: int, inputs: Inputs, draw_of: Sequence[int]) -> Data:
    """@param draw_of number of the draw of each sample. Raises ResultsError when experiments and samples have nothing in common."""
    parts: list[_Part] = []
    used: list[Observable] = []
    notes, path = [], None
    for one in observables:
        part = _part(one, n_samples)
        same = next((other for other in used if is_same_load(one, other)), None)
        if part is None:
            notes.append(f"{one.quantity} is not used: an experiment or more than a tenth of the samples lack it")
        elif part.is_bound.size and part.is_bound.mean() > MOST_BOUNDS:
            notes.append(f"{one.quantity} is not used: {np.sum(part.is_bound)} of {count(part.is_bound.size, 'sample')} bore all that was applied, "
                         "so that most of their loads are bounds")
        elif len(part.of_samples) < 2 or np.ptp(part.of_samples, axis=0).min() <= 0:
            notes.append(f"{one.quantity} is not used: it is the same in all samples")
        elif same is not None:
            notes.append(f"{one.quantity} is not used: in the samples it goes with {same.quantity}")
        else:
            used.append(one)
            if one.frame is not None:
                path = _reduce(one, part)
            parts.append(part)
    if not parts:
        raise ResultsError("experiments and samples have nothing in common that could calibrate inputs" + (f": {notes[0]}" if notes else ""))
    common = [i for i in range(len(samples)) if all(i in part.samples for part in parts) and len(samples[i].inputs) == len(inputs)]
    left_out = [samples[i].number for i in range(len(samples)) if i not in set(common)]
    numbers, draw = np.unique([draw_of[i] for i in common], return_inverse=True)
    first = [common[int(np.argmax(draw == k))] for k in range(numbers.size)]
    draws = np.array([samples[i].inputs for i in first], float).reshape(-1, len(inputs))
    experiments = sorted({i for part in parts for i in part.experiments})
    values = np.full((len(experiments), sum(part.block.count for part in parts)), np.nan)
    columns, read, bound, error, bounds, start = [], [], [], np.zeros((values.shape[1],) * 2), [], 0
    for part in parts:
        block = part.block
        block.first = start
        rows = [part.samples.index(i) for i in common]
        columns.append(part.of_samples[rows])
        read.append(part.as_read[rows])
        bound.append(np.repeat(part.is_bound[rows][:, None], block.count, axis=1))
        for i, row, is_bound in zip(part.experiments, part.of_experiments, part.bounds):
            if is_bound:
                bounds.append((start, float(row[0])))
            else:
                values[experiments.index(i), block.columns] = row
        error[block.columns, block.columns] = part.error
        start += block.count
    seen = observed(values, error, [part.block for part in parts], bounds)
    return Data(inputs, draws, Values(draw, np.hstack(columns)), np.hstack(read), seen, np.hstack(bound), path, experiments, left_out, notes)


def emulator_of(data: Data) -> Emulator:
    basis = Basis(data.inputs, data.draws)
    values = imputed(basis, data.values, data.is_bound) if data.is_bound is not None else data.values
    return Emulator(basis, values).with_slopes(UNEVEN)


# What follows


@dataclass
class Spread:
    """A distribution in short; the interval has equal tails, of LEVEL."""

    mean: float
    standard_deviation: float
    lower: float
    upper: float


def spread(values: np.ndarray, weight: Optional[np.ndarray] = None) -> Spread:
    """@param weight sum 1"""
    weight = np.full(len(values), 1 / len(values)) if weight is None else weight
    mean = float(weight @ values)
    return Spread(mean, float(np.sqrt(weight @ (values - mean)**2)), *_quantiles(values, weight, (1 - LEVEL) / 2, (1 + LEVEL) / 2))


def _quantiles(values: np.ndarray, weight: np.ndarray, *shares: float) -> list[float]:
    order = np.argsort(values, kind="stable")
    return values[order[np.minimum(np.searchsorted(np.cumsum(weight[order]), shares), len(values) - 1)]].tolist()


def spread_of(distribution: Any) -> Spread:
    return Spread(float(distribution.mean()), float(distribution.std()), *map(float, distribution.ppf(np.array([(1 - LEVEL) / 2, (1 + LEVEL) / 2]))))


@dataclass
class Information:
    bits: float  # Kullback-Leibler divergence of the posterior from the prior
    inputs: list[Spread]


@dataclass
class Contribution:
    """Of a quantity to the posterior."""

    quantity: str
    alone: Information
    without: Optional[Information]  # from all others, if there are any


@dataclass
class Scale:
    """Of a discrepancy or of the scatter between specimens: standard deviation."""

    quantity: str
    unit: str
    kind: str
    posterior: Spread


@dataclass
class Prediction:
    """The mean of as many new experiments after calibration."""

    name: str
    unit: str
    predicted: Spread
    observed: float
    place: float  # share of the predictions below the observation; near a half, as they were fitted to it


@dataclass
class Contradiction:
    """The experiments' own scatter against what reading and meshes explain."""

    quantity: str
    unit: str
    n: int
    scatter: float  # root mean square over the places of the quantity
    explained: float
    ratio: float
    p_value: float  # of scatter as large if specimens did not differ otherwise


@dataclass
class Coverage:
    key: str
    level: float
    n_draws: int
    n_covered: int
    lower: float
    upper: float


class Calibration:
    """What `crackle calibrate` prints: `print(calibration)`. `document` is what it prints with --json, `tables` the posterior as an input has it."""

    def __init__(self, data: Data, terms: Terms, names: Sequence[str] = (), about: Optional[dict[str, Any]] = None) -> None:
        """@param names of the experiments that are used
        @param about the samples: "planned", "failed", "undecided", "missing"; "base", "has_points"
        Raises ResultsError with too few draws for an emulator."""
        self.data, self.terms, self.names = data, terms, list(names)
        self._about = {"planned": len(data.values.draw), "failed": [], "undecided": [], "missing": [], "base": "own", "has_points": False, **(about or {})}
        self._require_draws(0)
        self.emulator = emulator_of(data)
        self._require_draws(LEAST_DEGREES - (self.emulator.degrees_of_freedom - self.emulator.n + 1))
        self.evenness = self.emulator.evenness()
        self.likelihood = Likelihood(self.emulator, data.seen, terms)
        self.points = sample(self.likelihood, self.likelihood.n_variables, FULL, random_numbers(0))
        self._add_posterior()
        self._add_predictions()
        self.contradictions = _contradictions(data.seen, self.emulator, self.points.weight @ self.points.x[:, :len(data.inputs)])
        self.contributions = self._contributions()
        self._check()
        self.warnings = [*self._sample_warnings(), *self._check_warnings()]
        self.notes = [*data.notes, *self._remarks()]

    def _require_draws(self, lacking: float) -> None:
        n, n_inputs = len(self.data.draws), len(self.data.inputs)
        needed = max(LEAST_DRAWS_PER_INPUT * (n_inputs + 1), n + int(np.ceil(max(0.0, lacking))))
        if n < needed:
            raise ResultsError(f"{n} draws of the random inputs with all that is compared are too few for an emulator of {count(self.data.values.value.shape[1], 'number')} "
                               f"with {count(n_inputs, 'input')}; {needed} or more are needed")

    def _spreads(self, points: Points) -> list[Spread]:
        values = self.data.inputs.values(points.x[:, :len(self.data.inputs)])
        return [spread(column, points.weight) for column in values.T]

    def _add_posterior(self) -> None:
        inputs, points = self.data.inputs, self.points
        w = points.x[:, :len(inputs)]
        values = inputs.values(w)
        self.prior = [spread_of(one) for one in inputs.distributions]
        self.posterior = self._spreads(points)
        self.shares = [_shares(one, column, points.weight) for one, column in zip(inputs.distributions, values.T)]
        centred = np.stack([(column - one.mean) / (one.standard_deviation or 1) for column, one in zip(values.T, self.posterior)], axis=1)
        self.correlation = centred.T @ (centred * points.weight[:, None])
        np.fill_diagonal(self.correlation, 1)
        chosen, times = np.unique(points.resampled(500, random_numbers(1)), return_counts=True)
        self.draws = pd.DataFrame(values[chosen], columns=inputs.keys).assign(weight=times)
        self.scales = []
        n = len(self.data.seen.blocks)
        for k in range(self.likelihood.n_variables - len(inputs)):
            block = self.data.seen.blocks[k % n]
            kind = "discrepancy" if self.terms.discrepancy and k < n else "between_specimens"
            self.scales.append(Scale(block.name, block.unit, kind, spread(self.likelihood.scale(k, points.x[:, len(inputs) + k]), points.weight)))
        medians = [_quantiles(column, points.weight, 0.5)[0] for column in values.T]
        shares = [float(one.cdf(np.array([median]))[0]) for one, median in zip(inputs.distributions, medians)]
        self.edges = [{"key": key, "share_below": share} for key, share in zip(inputs.keys, shares) if max(share, 1 - share) >= EDGE]
        sampled = values[points.resampled(2000, random_numbers(2))]
        self.modes = [{"key": key, "modes": found} for key, column in zip(inputs.keys, sampled.T) if len(found := _modes(column)) > 1]

    def _add_predictions(self) -> None:
        seen, points = self.data.seen, self.points
        chosen = points.resampled(2000, random_numbers(3))
        mean, covariance = self.likelihood.expected(points.x[chosen])
        random = random_numbers(4)
        wide = np.sqrt(np.maximum(1e-3, random.chisquare(min(self.likelihood.degrees, 1e6), len(chosen)) / min(self.likelihood.degrees, 1e6)))
        means = mean + np.einsum("ijk,ik->ij", np.linalg.cholesky(covariance), random.standard_normal(mean.shape)) / wide[:, None]

        def predict(name: str, unit: str, weight: np.ndarray, constant: float = 0.0) -> Prediction:
            values, own = means @ weight + constant, float(np.where(weight == 0, 0, seen.mean) @ weight + constant)
            return Prediction(name, unit, spread(values), own, np.nan if np.isnan(own) else float(np.mean(values < own)))
        unit = np.eye(self.emulator.n)
        self.predictions = [predict(name, block.unit, unit[c]) for block, c, name in _named(seen.blocks) if not (self.data.path and block.first == 0)]
        self.path: list[Prediction] = []
        if (path := self.data.path) is None:
            return

        def offset(name: str, of_stations: np.ndarray) -> Prediction:
            weight = np.zeros(self.emulator.n)
            weight[:path.basis.shape[1]] = path.basis.T @ of_stations
            return predict(name, "m", weight, float(of_stations @ path.mean))
        stations = np.eye(path.mean.size)
        self.predictions += [offset("path, mean offset", stations.mean(axis=0)), offset("path, offset at its end", stations[-1])]
        self.path = [offset("", one) for one in stations]

    def _contributions(self) -> list[Contribution]:
        blocks = self.data.seen.blocks

        def of(chosen: list[Block], number: int) -> Information:
            columns = [c for block in chosen for c in range(block.first, block.first + block.count)]
            own = []
            for block in chosen:
                own.append(Block(block.name, block.unit, columns.index(block.first), block.count, block.shape))
            likelihood = Likelihood(self.emulator.refitted(self.emulator.values, columns), self.data.seen.only(columns, own), self.terms)
            points = sample(likelihood, likelihood.n_variables, PART, random_numbers(5, number))
            return Information(points.bits, self._spreads(points))
        if len(blocks) == 1:
            return [Contribution(blocks[0].name, Information(self.points.bits, self.posterior), None)]
        return [Contribution(block.name, of([block], 2 * k), of([other for other in blocks if other is not block], 2 * k + 1)) for k, block in enumerate(blocks)]

    def _check(self) -> None:
        data, seen = self.data, self.data.seen
        n = len(data.draws)
        draws = [i * n // min(n, MOST_LEFT_OUT) for i in range(min(n, MOST_LEFT_OUT))]
        first = np.searchsorted(self.emulator.values.draw, draws)
        if data.is_bound is not None:
            is_whole = ~data.is_bound[first].any(axis=1)
            draws, first = list(np.array(draws)[is_whole]), first[is_whole]
        below, squares = [], []
        for k, (draw, row) in enumerate(zip(draws, first)):
            others = self.emulator.refitted(self.emulator.values.without(draw))
            likelihood = Likelihood(others, observed(data.as_read[row], seen.error, seen.blocks))
            points = sample(likelihood, likelihood.n_variables, SMALL, random_numbers(6, k))
            below.append(points.weight @ (data.inputs.values(points.x) < data.draws[draw]))
            squares.append(likelihood.least_square(points))
        self.coverage = []
        for k, key in enumerate(data.inputs.keys if below else ()):
            for level in COVERAGE_LEVELS:
                n_covered = int(np.sum(np.abs(np.array(below)[:, k] - 0.5) <= level / 2))
                self.coverage.append(Coverage(key, level, len(draws), n_covered, *wilson(n_covered / len(draws), len(draws), 0.95)))
        # Without the terms that make up for a wrong model, and with as few points as for the draws.
        plain = Likelihood(self.emulator, seen)
        own = plain.least_square(sample(plain, plain.n_variables, SMALL, random_numbers(6, len(draws)))) if (~np.isnan(seen.mean)).any() else np.nan
        self.distance, self.least_p = float(np.sqrt(own)), 1 / (len(draws) + 1)
        self.distance_p = np.nan if np.isnan(own) else (int(np.sum(np.array(squares) >= own * (1 - 1e-6))) + 1) * self.least_p
        self.components = []
        for _, c, name in _named(seen.blocks):
            mesh, p = self.emulator.lack_of_fit(c)
            degree, predicted = self.emulator.chosen[c]
            self.components.append({"quantity": name, "degree": degree, "predicted": predicted, "mesh": mesh, "lack_of_fit_p_value": p,
                                    "even_scatter_p_value": float(self.evenness[c])})

    def _sample_warnings(self) -> list[str]:
        about, warnings = self._about, []
        if about["base"] == "shared" or about["has_points"]:
            warnings.append("the samples share their base of mother points: the scatter between bases is not in the mesh scatter, and the posterior is too narrow; "
                            'compute the ensemble with base = "own"')
        n_lacking = len(about["failed"]) + len(about["undecided"]) + len(self.data.left_out)
        if n_lacking:
            warnings.append(f"{n_lacking} of {len(self.data.values.draw) + n_lacking} samples failed, are undecided or lack a part of the observations, and are left out: the "
                            "posterior supposes that this has nothing to do with the inputs")
        return warnings

    def _check_warnings(self) -> list[str]:
        warnings = []
        for one in self.contradictions:
            if one.p_value <= SIGNIFICANT / len(self.contradictions) and not self.terms.between_specimens:
                warnings.append(f"the experiments contradict each other: in {_scatter(one)}; the posterior is too narrow, leave out --equal-specimens")
        for key, share in ((edge["key"], edge["share_below"]) for edge in self.edges):
            warnings.append(f"{key} lies at the {'upper' if share > 0.5 else 'lower'} edge of its prior ({percent(max(share, 1 - share))} of that on one side): widen it")
        for one in self.modes:
            unit = self._unit(one["key"])
            warnings.append(f"{one['key']} has {len(one['modes'])} modes, near " + " and ".join(f"{quantity(mode['at'], unit)} ({percent(mode['share'])})" for mode in one["modes"])
                            + ": its mean may be no likely value")
        confidence = 1 - 0.05 / max(1, len(self.coverage))  # one of several shares is easily too small by chance
        for one in self.coverage:
            if wilson(one.n_covered / one.n_draws, one.n_draws, confidence).upper < one.level:
                warnings.append(f"{100 * one.level:.0f} % intervals of {one.key} cover it in {one.n_covered} of {one.n_draws} left-out draws only: the posterior is too narrow")
        if self.points.effective_size < LEAST_EFFECTIVE_SIZE:
            warnings.append(f"the posterior stands on {self.points.effective_size:.0f} effective points only; its intervals are uncertain")
        if self.distance_p <= SIGNIFICANT:
            warnings.append(f"the observations lie farther from the model than those of left-out draws do (p = {self.distance_p:.2g}): no value of the inputs explains them"
                            + ("" if self.terms.discrepancy else "; --discrepancy allows for a wrong model"))
        if self.data.path and self.data.path.shape_p_value <= SIGNIFICANT:
            warnings.append(f"the paths have a shape that no sample's has (p = {self.data.path.shape_p_value:.2g})")
        for one in self.components:
            if one["lack_of_fit_p_value"] <= SIGNIFICANT / len(self.components):
                warnings.append(f"the emulator does not follow {one['quantity']} (p = {one['lack_of_fit_p_value']:.2g}); more draws would help")
        if all(one["degree"] == 0 for one in self.components):
            warnings.append("nothing observed depends on the inputs visibly: the posterior is the prior")
        return warnings

    def _remarks(self) -> list[str]:
        notes = [f"specimens differ by more than meshes and reading: in {_scatter(one)}; this is allowed for" for one in self.contradictions
                 if one.p_value <= SIGNIFICANT / len(self.contradictions) and self.terms.between_specimens]
        notes += [f"the scatter of {one['quantity']} between meshes depends on the inputs (p = {one['even_scatter_p_value']:.2g}): it is taken as an exponential function of them"
                  for one, slopes in zip(self.components, self.emulator.slopes) if slopes.any()]
        if self.data.is_bound is not None and (n := int(self.data.is_bound.any(axis=1).sum())):
            notes.append(f"{count(n, 'sample')} did not break: {'its load is a bound' if n == 1 else 'their loads are bounds'} from below")
        return notes

    def _unit(self, key: str) -> str:
        return next(one["unit"] for one in self.data.inputs.random if one["key"] == key)

    # As tables, text and JSON

    @property
    def inputs(self) -> pd.DataFrame:
        """A row for each input with its prior and posterior [SI]; "ratio" is that of the standard deviations, posterior over prior."""
        table = pd.json_normalize(self.document["inputs"], sep="_").set_index("key")
        table.attrs = {"draws": self.draws, "document": self.document}
        return table

    @property
    def ratios(self) -> list[float]:
        return [one.standard_deviation / prior.standard_deviation for one, prior in zip(self.posterior, self.prior)]

    def plot(self, axes: Optional["Axes"] = None, key: Optional[str] = None) -> "Axes":
        """The posterior of an input, the first by default, over its prior."""
        from .plots import _axes as new_axes
        axes = new_axes(axes)
        k = self.data.inputs.keys.index(key) if key else 0
        values = self.data.inputs.distributions[k].ppf(special.ndtr(random_numbers(7).standard_normal(4000)))
        edges = np.histogram_bin_edges(values, 40)
        axes.hist(values, edges, density=True, histtype="step", color="0.4", label="prior")
        axes.hist(self.draws.iloc[:, k], edges, weights=self.draws["weight"], density=True, alpha=0.6, label="posterior")
        unit = self._unit(self.data.inputs.keys[k])
        axes.set(xlabel=self.data.inputs.keys[k] + (f" [{unit}]" if unit else ""), yticks=[])
        axes.legend(fontsize="small")
        return axes

    @property
    def document(self) -> dict[str, Any]:
        data, about = self.data, self._about

        def information(one: Optional[Information]) -> Any:
            return one and {"bits": one.bits, "inputs": [vars(each) for each in one.inputs]}

        def prediction(one: Prediction) -> dict[str, Any]:
            return {**vars(one), "predicted": vars(one.predicted)}
        path = None
        if data.path:
            frame, stations = data.path.frame, data.path.stations
            path = {"place": frame.place[stations], "normal": frame.normal[stations], "observed": [one.observed for one in self.path],
                    **{name: [getattr(one.predicted, name) for one in self.path] for name in ("mean", "lower", "upper")}}
        return plain({
            "level": LEVEL, "experiments": self.names, "discrepancy": self.terms.discrepancy, "between_specimens": self.terms.between_specimens,
            "inputs": [{"key": random["key"], "unit": random["unit"], "distribution": random["kind"], "prior": vars(prior), "posterior": vars(posterior), "ratio": ratio}
                       for random, prior, posterior, ratio in zip(data.inputs.random, self.prior, self.posterior, self.ratios)],
            "correlation": self.correlation, "bits": self.points.bits, "scales": [{**vars(one), "posterior": vars(one.posterior)} for one in self.scales],
            "contributions": [{"quantity": one.quantity, "alone": information(one.alone), "without": information(one.without)} for one in self.contributions],
            "predictions": [prediction(one) for one in self.predictions], "path": path,
            "checks": {"coverage": [vars(one) for one in self.coverage], "effective_size": self.points.effective_size,
                       "distance": {"value": self.distance, "n_components": self.emulator.n, "p_value": self.distance_p, "least_p_value": self.least_p},
                       "shape_p_value": data.path.shape_p_value if data.path else np.nan, "emulator": self.components,
                       "contradictions": [vars(one) for one in self.contradictions], "edges": self.edges, "modes": self.modes},
            "draws": {"values": self.draws.iloc[:, :-1].to_numpy(), "weights": self.draws["weight"].to_numpy()},
            "warnings": self.warnings, "notes": self.notes,
            "samples": {"planned": about["planned"], "used": len(data.values.draw), "draws": len(data.draws), "failed": about["failed"], "undecided": about["undecided"],
                        "missing": about["missing"], "left_out": data.left_out}})

    @property
    def json(self) -> str:
        return json_text(self.document)

    def __str__(self) -> str:
        lines = [self._used()] + [f"warning: {one}\n" for one in self.warnings] + [f"note: {one}\n" for one in self.notes]
        level = f"{100 * LEVEL:.4g} %"
        rows = [["input", "prior", level, "posterior", level, "deviation, posterior over prior"]]
        for random, prior, posterior, ratio in zip(self.data.inputs.random, self.prior, self.posterior, self.ratios):
            rows.append([random["key"], *_mean_and_range(prior, random["unit"]), *_mean_and_range(posterior, random["unit"]), f"{ratio:.2f}"])
        lines += ["\n", aligned(rows, 2, True)]
        for one in self.scales:
            mean, ends = _mean_and_range(one.posterior, one.unit)
            lines.append(f"{'Discrepancy' if one.kind == 'discrepancy' else 'Scatter between specimens'} of {readable(one.quantity)}: {mean} ({ends})\n")
        rows = [["from", "bits", "deviations", "without: bits", "deviations"]]
        for each in self.contributions:
            rows.append([readable(each.quantity), *self._bits(each.alone), *self._bits(each.without)])
        lines += ["\n", aligned(rows, 2, True), f"All together {self.points.bits:.1f} bits{', those on the scales included' if self.scales else ''}. Deviations: of the inputs in their order, posterior over prior.\n"]
        rows = [["prediction", "observed", "mean", level, "below the observed"]]
        for one in self.predictions:
            rows.append([readable(one.name), quantity(one.observed, one.unit, 4, _size(one.predicted)), *_mean_and_range(one.predicted, one.unit), percent(one.place)])
        lines += ["\n", aligned(rows, 2, True), "The predictions were fitted to what was observed, so that half of them should lie below.\n", "\nChecks\n"]
        rows = [["coverage of", "interval", "covered", "95 % interval"]]
        rows += [[one.key, percent(one.level), f"{one.n_covered} of {one.n_draws}", f"{percent(one.lower)} to {percent(one.upper)}"] for one in self.coverage]
        lines += [aligned(rows, 2, True), "Each draw's results as one experiment, by an emulator without it and the plain model.\n"] if self.coverage else [
            "No draw has all its loads, as samples bore what was applied: the coverage is not known.\n"]
        rows = [["emulated", "degree", "predicted", "meshes", "lack of fit, p", "even scatter, p"]]
        rows += [[readable(one["quantity"]), str(one["degree"]), percent(one["predicted"]), percent(one["mesh"]), probability(one["lack_of_fit_p_value"]),
                  probability(one["even_scatter_p_value"])] for one in self.components]
        lines += [aligned(rows, 2, True), "Shares of the variance; that of the meshes is known with replicates only.\n"]
        lines += [f"In {_scatter(one)}.\n" for one in self.contradictions]
        if not np.isnan(self.distance):
            lines.append(f"Observations and model: {self.distance:.2f} standard deviations apart at least, in {count(self.emulator.n, 'number')}; {p_is(self.distance_p)} "
                         f"({self.least_p:.2g} at least), ranked among left-out draws. A small p says that no inputs explain them, a large one little.\n")
        if self.data.path:
            lines.append(f"Shape of the paths beyond their components: {p_is(self.data.path.shape_p_value)}.\n")
        return "".join(lines) + f"Effective size of the posterior: {self.points.effective_size:.0f} points.\n"

    def _bits(self, one: Optional[Information]) -> list[str]:
        if one is None:
            return ["-", "-"]
        return [f"{one.bits:.1f}", ", ".join(f"{each.standard_deviation / prior.standard_deviation:.2f}" for each, prior in zip(one.inputs, self.prior))]

    def _used(self) -> str:
        about = self._about
        parts = [named(numbers, what) for numbers, what in ((about["failed"], "failed"), (about["undecided"], "undecided"), (about["missing"], "missing"),
                                                            (self.data.left_out, "without all that is compared")) if numbers]
        return (f"{len(self.data.values.draw)} of {about['planned']} samples, {len(self.data.draws)} draws; {count(len(self.names), 'experiment')}"
                f"{'; left out: ' if parts else ''}{', '.join(parts)}\n")

    @property
    def tables(self) -> str:
        """The posterior as [[random]] tables: distributions of the prior's kind, or beta distributions between the same bounds, with the posterior's means and
        standard deviations; of discrete inputs the values with the posterior's shares."""
        keys = self.data.inputs.keys
        lost = "".join(f"#   {self.correlation[i, k]:+.2f} of {keys[i]} and {keys[k]}\n" for i in range(len(keys)) for k in range(i + 1, len(keys))
                       if abs(self.correlation[i, k]) >= LEAST_CORRELATION)
        text = ("# Posterior of the random inputs, from crackle calibrate: to be put in the place of the [[random]] tables\n"
                "# of an input. Means and standard deviations are the posterior's. Its shape and its correlations are lost")
        return text + (":\n" + lost if lost else f",\n# all below {LEAST_CORRELATION}.\n") + "".join(map(_table, self.data.inputs.random, self.posterior, self.shares))


def _named(blocks: Sequence[Block]) -> list[tuple[Block, int, str]]:
    return [(block, block.first + k, block.name if block.count == 1 else f"{block.name}[{k}]") for block in blocks for k in range(block.count)]


def _size(one: Spread) -> float:
    return float(np.nanmax(np.abs([one.mean, one.lower, one.upper])))


def _mean_and_range(one: Spread, unit: str) -> list[str]:
    size = _size(one)
    return [quantity(one.mean, unit, 4, size), f"{quantity(one.lower, unit, 4, size)} to {quantity(one.upper, unit, 4, size)}"]


def _scatter(one: Contradiction) -> str:
    return (f"{readable(one.quantity)} the {one.n} experiments scatter by {quantity(one.scatter, one.unit, 3)}, {one.ratio:.2g} times the "
            f"{quantity(one.explained, one.unit, 3)} that meshes and reading explain ({p_is(one.p_value)})")


def _contradictions(seen: Observed, emulator: Emulator, at: np.ndarray) -> list[Contradiction]:
    """F tests of the scatter of experiments about their mean, in each quantity that two or more have."""
    found = []
    wider = emulator.widening(at[None])[0]
    scatter = emulator.scatter * np.outer(wider, wider)
    for block in seen.blocks:
        rows = seen.values[:, block.columns]
        rows = rows[~np.isnan(rows).any(axis=1)]
        if len(rows) < 2:
            continue
        own = scatter[block.columns, block.columns]
        explained = own + seen.error[block.columns, block.columns] + np.diag(1e-8 * emulator.variance[block.columns])
        centred = rows - rows.mean(axis=0)
        degrees = block.count * (len(rows) - 1)
        square = float(np.einsum("ij,ij->", centred, np.linalg.solve(explained, centred.T).T)) / degrees
        share = np.trace(np.linalg.solve(explained, own)) / block.count
        p = float(stats.f.sf(square, degrees, max(1.0, emulator.degrees_of_freedom / max(share, 1e-3)**2)))
        trace = np.trace(block.shape)
        found.append(Contradiction(block.name, block.unit, len(rows), float(np.sqrt(np.sum(centred**2) / (len(rows) - 1) / trace)),
                                   float(np.sqrt(np.trace(explained) / trace)), float(np.sqrt(square)), p))
    return found


def _modes(values: np.ndarray) -> list[dict[str, float]]:
    """Where a kernel estimate of the density has maxima with less than half of it between them and a tenth of all on either side."""
    if np.ptp(values) <= 0:
        return []
    grid = np.linspace(values.min(), values.max(), 256)
    density = stats.gaussian_kde(values, lambda of: 0.6 * of.scotts_factor())(grid)
    peaks, found = signal.find_peaks(np.pad(density, 1), prominence=0)
    peaks = peaks[found["prominences"] > 0.5 * density[peaks - 1]] - 1
    ends = [values.min(), *(grid[a + int(np.argmin(density[a:b + 1]))] for a, b in zip(peaks, peaks[1:])), np.inf]
    shares = [float(np.mean((values >= a) & (values < b))) for a, b in zip(ends, ends[1:])]
    return [{"at": float(grid[peak]), "share": share} for peak, share in zip(peaks, shares) if share >= LEAST_MODE]


def _shares(prior: Any, values: np.ndarray, weight: np.ndarray) -> dict[float, float]:
    """The posterior's, by the values of a discrete input; an input takes positive ones only."""
    return {value: max(LEAST_WEIGHT, float(weight[values == value].sum())) for value in prior.values.tolist()} if isinstance(prior, Discrete) else {}


def _table(random: dict[str, Any], posterior: Spread, shares: dict[float, float]) -> str:
    """The posterior of an input as a [[random]] table. @param shares of its values, where it is discrete"""
    of, kind = random["parameters"], random["kind"]

    def shown(value: float, digits: int = 6) -> str:
        return f'"{quantity(value, random["unit"], digits)}"' if random["unit"] else f"{value:.{digits}g}"
    found: dict[str, Any] = {"mean": posterior.mean, "standard_deviation": posterior.standard_deviation, "lower": of["lower"], "upper": of["upper"]}
    if kind in ("uniform", "triangular") or (kind == "truncated" and None not in (of["lower"], of["upper"])):
        kind = "beta"
    elif kind == "empirical":
        kind = "beta"
        found |= {"lower": min(random["values"]), "upper": max(random["values"])}
    elif kind == "weibull":
        start = of["lower"] or 0.0
        shape = optimize.brentq(lambda k: (posterior.mean - start) / posterior.standard_deviation - 1 / np.sqrt(np.expm1(special.gammaln(1 + 2 / k) - 2 * special.gammaln(1 + 1 / k))), 0.2, 1000)
        found |= {"mean": None, "standard_deviation": None, "shape": shape, "scale": (posterior.mean - start) / special.gamma(1 + 1 / shape)}
    elif kind == "truncated":
        found |= _one_sided(posterior, of["lower"] if of["upper"] is None else of["upper"], 1 if of["upper"] is None else -1)
    names = ", ".join(f'"{key}"' for key in random["keys"])
    text = f"[[random]]\nkey = {f'[{names}]' if len(random['keys']) > 1 else names}\n" + ('together = "factor"\n' if random["by_factor"] else "")
    text += f'distribution = "{kind}"\n'
    if kind == "discrete":
        return text + f"values = [{', '.join(shown(value, 12) for value in shares)}]\nweights = [{', '.join(f'{share:.6g}' for share in shares.values())}]\n"
    for name, value in found.items():
        if value is not None:
            text += f"{name} = {value:.6g}\n" if name == "shape" else f"{name} = {shown(value)}\n"
    return text


def _one_sided(posterior: Spread, bound: float, side: int) -> dict[str, float]:
    """The normal distribution that has a mean and a standard deviation when it is cut off. @param side of the mean from the bound: 1 above, -1 below"""
    def deviation(a: float) -> float:
        hazard = np.exp(-a * a / 2) / np.sqrt(2 * np.pi) / special.ndtr(a)
        return np.sqrt(1 - hazard * (hazard + a))

    def excess(a: float) -> float:
        return (a + np.exp(-a * a / 2) / np.sqrt(2 * np.pi) / special.ndtr(a)) / deviation(a) - wanted
    wanted = side * (posterior.mean - bound) / posterior.standard_deviation
    a = optimize.brentq(excess, -10, max(10.0, 2 * wanted)) if wanted > 1.02 else -10.0
    own = posterior.standard_deviation / deviation(a)
    return {"mean": bound + side * a * own, "standard_deviation": own}


def calibrate(folder: str | Path, experiments: str | Path, discrepancy: bool = False, between_specimens: Optional[bool] = None,
              program: str | Path | None = None) -> Calibration:
    """The random inputs of an ensemble, given an experiments file.

    @param discrepancy: allow for a model that is off by an unknown amount in each quantity
    @param between_specimens: allow for specimens that differ by more than meshes and reading do; None: from two experiments on
    Raises crackle.ResultsError, also where there are no random inputs.
    """
    from .experiments import read_experiments
    given = read_experiments(Path(experiments))
    samples = observed_samples(Path(folder), needs_files(given), Path(program) if program else None)
    about = samples.document
    if not about["random"]:
        raise ResultsError("the ensemble has no random inputs; only those, [[random]] in its input, can be calibrated")
    check_places(Path(experiments), given, samples)
    inputs = Inputs(about["random"], about["correlation"])
    data = calibration_data(observe(given, samples), samples.samples, len(samples.samples), inputs,
                            [one.number // about["replicates"] for one in samples.samples])
    if len(given) > 1 and any(len(one.tip_times) for one in given):
        data.notes.append("tip_times is not used: only with a single experiment")
    n_contrasts = len(data.seen.contrasts)
    if between_specimens and not n_contrasts:
        raise ResultsError("--between-specimens needs two experiments with the same observations")
    terms = Terms(discrepancy, n_contrasts > 0 if between_specimens is None else between_specimens)
    return Calibration(data, terms, [given[i].name for i in data.experiments], {**about, "missing": samples.missing})
