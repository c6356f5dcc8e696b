# SPDX-License-Identifier: GPL-3.0-or-later
"""The results of an ensemble as functions of its random inputs."""
from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any, Iterator, Sequence

import numpy as np
from numpy.polynomial.hermite_e import hermevander
from numpy.polynomial.legendre import legvander
from scipy import linalg, special, stats

MOST_DEVIATIONS = 7.5  # of a standard normal variable that tables of inputs reach to
MOST_DEGREES, MOST_TERMS = 12, 200
DRAWS_PER_TERM = 2  # a fit with fewer follows the scatter
MOST_BOUNDS = 0.5  # share of values that may be bounds
HERMITE = ("normal", "lognormal", "weibull")  # whose polynomials are those of the corresponding normal variable
NODES = np.linspace(-MOST_DEVIATIONS, MOST_DEVIATIONS, 2049)


def distribution(random: dict[str, Any]) -> Any:
    """A `[[random]]` input as `crackle stats --json` describes it, frozen as scipy has it [SI]."""
    of = random["parameters"]
    kind, lower, upper, deviation = random["kind"], of["lower"], of["upper"], of["standard_deviation"]
    mean = of["own"] if of["mean"] is None else of["mean"]
    start = 0.0 if lower is None else lower
    if kind == "normal":
        return stats.norm(mean, deviation)
    if kind == "lognormal":
        variance = np.log1p((deviation / (mean - start))**2)
        return stats.lognorm(np.sqrt(variance), start, (mean - start) * np.exp(-variance / 2))
    if kind == "uniform":
        return stats.uniform(lower, upper - lower)
    if kind == "triangular":
        centre = (lower + upper) / 2 if of["mean"] is None else of["mean"]
        mode = 3 * centre - lower - upper if of["mode"] is None else of["mode"]
        return stats.triang((np.clip(mode, lower, upper) - lower) / (upper - lower), lower, upper - lower)
    if kind == "weibull":
        return stats.weibull_min(of["shape"], start, of["scale"])
    if kind == "beta":
        share = (mean - lower) / (upper - lower)
        total = share * (1 - share) / (deviation / (upper - lower))**2 - 1
        return stats.beta(share * total, (1 - share) * total, lower, upper - lower)
    if kind == "truncated":
        ends = [none if end is None else (end - mean) / deviation for end, none in ((lower, -np.inf), (upper, np.inf))]
        return stats.truncnorm(*ends, mean, deviation)
    values = np.array(random["values"], float)
    if kind == "empirical":
        return _Empirical(values)
    return Discrete(values, np.array(random["weights"] or np.ones(values.size), float))


class _Empirical:
    """Linear between values in order."""

    def __init__(self, values: np.ndarray) -> None:
        self.values, self._share = np.sort(values), np.linspace(0, 1, values.size)

    def ppf(self, p: np.ndarray) -> np.ndarray:
        return np.interp(p, self._share, self.values)

    def cdf(self, x: np.ndarray) -> np.ndarray:
        return np.interp(x, self.values, self._share)

    def mean(self) -> float:
        return float(np.mean((self.values[:-1] + self.values[1:]) / 2))

    def std(self) -> float:
        a, b = self.values[:-1] - self.mean(), self.values[1:] - self.mean()
        return float(np.sqrt(np.mean((a * a + a * b + b * b) / 3)))


class Discrete:
    """Some values with weights."""

    def __init__(self, values: np.ndarray, weights: np.ndarray) -> None:
        self.values, which = np.unique(values, return_inverse=True)
        self._of = stats.rv_discrete(values=(self.values, np.bincount(which, weights) / weights.sum()))
        self.ppf, self.mean, self.std = self._of.ppf, self._of.mean, self._of.std

    def cdf(self, x: np.ndarray) -> np.ndarray:
        """In the middle of each value's step."""
        return self._of.cdf(x) - self._of.pmf(x) / 2


class Inputs:
    """Random inputs as functions of independent standard normal variables `w`; correlated ones by a Gaussian copula."""

    def __init__(self, random: Sequence[dict[str, Any]], correlation: Sequence[Sequence[float]] | None = None) -> None:
        self.random = list(random)
        self.distributions = [distribution(one) for one in random]
        self.factor = np.linalg.cholesky(np.array(correlation, float)) if correlation is not None else np.eye(len(self.random))
        # Quantiles of given values may all be the same one.
        self._ends = [one.values[[0, -1]] if isinstance(one, (_Empirical, Discrete)) else one.ppf(special.ndtr(np.array([-3.5, 3.5])))
                      for one in self.distributions]
        self._tables = [None if isinstance(one, Discrete) else one.ppf(special.ndtr(NODES)) for one in self.distributions]

    def __len__(self) -> int:
        return len(self.random)

    @property
    def keys(self) -> list[str]:
        return [one["key"] for one in self.random]

    def values(self, w: np.ndarray) -> np.ndarray:
        """Points x inputs [SI]."""
        return self._of_normal(w @ self.factor.T)

    def _of_normal(self, z: np.ndarray) -> np.ndarray:
        return np.stack([one.ppf(special.ndtr(z[:, k])) if table is None else np.interp(z[:, k], NODES, table)
                         for k, (one, table) in enumerate(zip(self.distributions, self._tables))], axis=1)

    def variables(self, values: np.ndarray) -> np.ndarray:
        """The `w` of values."""
        normal = np.stack([special.ndtri(np.clip(one.cdf(values[:, k]), 1e-15, 1 - 1e-15)) for k, one in enumerate(self.distributions)], axis=1)
        return linalg.solve_triangular(self.factor, normal.T, lower=True).T

    def polynomials(self, w: np.ndarray, degree: int, values: np.ndarray | None = None) -> np.ndarray:
        """Of each input: inputs x points x degrees. Their span is all that matters. @param values at `w`, where they are known"""
        z = w @ self.factor.T
        values = self._of_normal(z) if values is None and not all(one["kind"] in HERMITE for one in self.random) else values
        tables = []
        for k, (random, ends) in enumerate(zip(self.random, self._ends)):
            if random["kind"] in HERMITE:
                tables.append(hermevander(z[:, k], degree) / np.sqrt(special.factorial(np.arange(degree + 1))))
            else:
                tables.append(legvander((2 * values[:, k] - ends.sum()) / np.ptp(ends), degree))
        return np.array(tables)


class Basis:
    """Products of polynomials of the inputs up to a total degree, as many as a least-squares fit to the draws supports."""

    def __init__(self, inputs: Inputs, draws: np.ndarray) -> None:
        """@param draws of the inputs [SI]: draws x inputs"""
        self.inputs = inputs
        most = [one.values.size - 1 if isinstance(one, Discrete) else MOST_DEGREES for one in inputs.distributions]
        self.degrees: list[tuple[int, ...]] = []
        self.n_terms: list[int] = []  # by highest total degree
        for degree in range(MOST_DEGREES + 1):
            terms = [term for term in _compositions(len(inputs), degree) if all(one <= limit for one, limit in zip(term, most))]
            n = len(self.degrees) + len(terms)
            if degree > 0 and (n > MOST_TERMS or n * DRAWS_PER_TERM > len(draws)):
                break
            self.degrees += terms
            self.n_terms.append(n)
        self.variables = inputs.variables(draws)
        self.table = self.terms(self.variables, values=draws)

    def terms(self, w: np.ndarray, n: int | None = None, values: np.ndarray | None = None) -> np.ndarray:
        """The first n: points x terms. @param values at `w`, where they are known"""
        degrees = np.array(self.degrees[:n])
        tables = self.inputs.polynomials(w, int(degrees.max(initial=0)), values)
        return np.prod([table[:, degrees[:, k]] for k, table in enumerate(tables)], axis=0)


def _compositions(n: int, degree: int) -> Iterator[tuple[int, ...]]:
    """All distributions of a degree over inputs."""
    for bars in itertools.combinations(range(degree + n - 1), n - 1):
        ends = (-1, *bars, degree + n - 1)
        yield tuple(b - a - 1 for a, b in zip(ends, ends[1:]))


def choose_degree(basis: Basis, draw: np.ndarray, values: np.ndarray) -> tuple[int, float]:
    """The degree whose expansion best predicts draws left out, and the share of the variance that it predicts."""
    variation = np.sum((values - values.mean())**2)
    q = np.linalg.qr(basis.table[draw])[0]
    n_draws = np.unique(draw).size
    starts = np.flatnonzero(np.diff(draw, prepend=-1))
    best = (0, -np.inf)
    for degree, n in enumerate(basis.n_terms):
        if degree > 0 and n * DRAWS_PER_TERM > n_draws:
            break
        span = q[:, :n]
        residual = values - span @ (span.T @ values)
        if n_draws == len(values):
            error = np.sum((residual / np.maximum(1e-300, 1 - np.sum(span**2, axis=1)))**2)
        else:
            error = 0.0
            for own, of_draw in zip(np.split(residual, starts[1:]), np.split(span, starts[1:])):
                error += np.sum(np.linalg.lstsq(np.eye(len(own)) - of_draw @ of_draw.T, own, rcond=None)[0]**2)
        predicted = 1 - error / variation
        if predicted > best[1]:
            best = (degree, float(predicted))
    return best if best[1] > 0 else (0, best[1])  # what predicts nothing explains nothing


@dataclass
class Values:
    """Of several components in the samples. Row i belongs to draw `draw[i]` of a basis, in ascending order."""

    draw: np.ndarray
    value: np.ndarray  # samples x components

    def without(self, draw: int) -> "Values":
        return Values(self.draw[self.draw != draw], self.value[self.draw != draw])

    @property
    def n_draws(self) -> int:
        return np.unique(self.draw).size


class Emulator:
    """The mean of each component by a polynomial chaos expansion (least squares, degree by cross-validation), and the scatter of all components about
    it, whose size may change with the inputs."""

    def __init__(self, basis: Basis, values: Values, chosen: Sequence[tuple[int, float]] | None = None, slopes: np.ndarray | None = None) -> None:
        self.basis, self.values = basis, values
        n, self.n = values.value.shape
        self.chosen = list(chosen) if chosen is not None else [choose_degree(basis, values.draw, column) for column in values.value.T]
        self.n_terms = np.array([basis.n_terms[degree] for degree, _ in self.chosen])
        most = self.n_terms.max(initial=1)
        q, self._triangle = np.linalg.qr(basis.table[values.draw, :most])
        self._coefficient = q.T @ values.value
        self._coefficient[np.arange(most)[:, None] >= self.n_terms] = 0
        self.residual = values.value - q @ self._coefficient
        self._leverage = np.cumsum(q**2, axis=1)[:, self.n_terms - 1]
        self.slopes = slopes if slopes is not None else np.zeros((self.n, len(basis.inputs)))
        even = self.residual / self.widening(basis.variables[values.draw])
        self.scatter = _covariance(even, 1 / np.sqrt(n - self.n_terms))
        # Of the mean: samples of a draw share the error of the expansion.
        sums = np.array([self.residual[values.draw == one].sum(axis=0) for one in np.unique(values.draw)]) if values.n_draws < n else self.residual
        self.shared_scatter = _covariance(sums, 1 / np.sqrt(n * (1 - self.n_terms / values.n_draws)))
        self.variance = np.var(values.value, axis=0, ddof=1)
        self.degrees_of_freedom = values.n_draws - float(most)
        self.mean_leverage = most / n

    def refitted(self, values: Values, columns: Sequence[int] | None = None) -> "Emulator":
        """With the degrees of this one, for some of its components."""
        chosen = list(range(self.n)) if columns is None else list(columns)
        return Emulator(self.basis, Values(values.draw, values.value[:, chosen]), [self.chosen[c] for c in chosen], self.slopes[chosen])

    def predict(self, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Means and leverages: points x components."""
        most = self._triangle.shape[1]
        q = linalg.solve_triangular(self._triangle.T, self.basis.terms(w, most).T, lower=True, check_finite=False).T
        return q @ self._coefficient, np.cumsum(q**2, axis=1)[:, self.n_terms - 1]

    def widening(self, w: np.ndarray) -> np.ndarray:
        """The scatter's deviation there, of that in the middle: points x components."""
        return np.exp(np.clip(w, -2.5, 2.5) @ self.slopes.T / 2)

    def _squares(self) -> tuple[np.ndarray, np.ndarray]:
        """Those of the scatter of meshes, and ones with their inputs' variables beside them: of samples or, with replicates, of draws."""
        w, draw = self.basis.variables, self.values.draw
        if self.values.n_draws == len(draw):
            return self.residual**2 / np.maximum(1e-12, 1 - self._leverage), np.column_stack([np.ones(len(draw)), w[draw]])
        number = np.bincount(draw, minlength=len(w)).astype(float)
        means = np.stack([np.bincount(draw, column, minlength=len(w)) / np.maximum(1, number) for column in self.values.value.T], axis=1)
        apart = (self.values.value - means[draw])**2
        several = number > 1
        square = np.stack([np.bincount(draw, column, minlength=len(w)) for column in apart.T], axis=1)[several] / (number[several, None] - 1)
        return square, np.column_stack([np.ones(int(several.sum())), w[several]])

    def evenness(self) -> np.ndarray:
        """p, for each component, of squares that follow the inputs as much if the scatter is the same everywhere: Koenker's test (1981, J. Econometrics 17,
        107)."""
        square, inside = self._squares()
        total = np.sum((square - square.mean(axis=0))**2, axis=0)
        rest = np.sum((square - inside @ np.linalg.lstsq(inside, square, rcond=None)[0])**2, axis=0)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(total > 0, stats.chi2.sf(len(square) * (1 - rest / total), inside.shape[1] - 1), 1.0)

    def with_slopes(self, level: float) -> "Emulator":
        """With the scatter as an exponential function of the inputs (Harvey 1976, Econometrica 44, 461) where a test at this level, for all components
        together, finds it uneven."""
        uneven = self.evenness() <= level / self.n
        if not uneven.any():
            return self
        square, inside = self._squares()
        logs = np.log(np.maximum(square, 1e-12 * self.scatter.diagonal()))
        slopes = np.where(uneven, np.linalg.lstsq(inside, logs, rcond=None)[0][1:], 0).T
        return Emulator(self.basis, self.values, self.chosen, slopes)

    def lack_of_fit(self, c: int) -> tuple[float, float]:
        """Share of the variance that is scatter of the meshes, and p (F-test) of residuals of draws no larger than meshes explain; NaN without
        replicates."""
        draw, column = self.values.draw, self.values.value[:, c]
        n, n_draws = len(column), self.values.n_draws
        means = np.bincount(draw, column)[draw] / np.bincount(draw)[draw]
        within, degrees_within, degrees = np.sum((column - means)**2), n - n_draws, n_draws - int(self.n_terms[c])
        if degrees_within < 1 or degrees < 1 or within <= 0:
            return np.nan, np.nan
        between = max(0.0, float(np.sum(self.residual[:, c]**2) - within)) / degrees
        mean_within = within / degrees_within
        return float(mean_within / self.variance[c]), float(stats.f.sf(between / mean_within, degrees, degrees_within))


def _covariance(rows: np.ndarray, weight: np.ndarray) -> np.ndarray:
    return weight[:, None] * (rows.T @ rows) * weight


def imputed(basis: Basis, values: Values, is_bound: np.ndarray) -> Values:
    """Values of which some are lower bounds, with draws from their distribution above the bound: the fit is that of a censored normal distribution by
    expectation and maximization."""
    if not is_bound.any():
        return values
    random = np.random.Generator(np.random.Philox(key=2))
    found = values.value.copy()
    for c in np.flatnonzero(is_bound.any(axis=0)):
        bound, column = is_bound[:, c], values.value[:, c].copy()
        more = 0.0
        for _ in range(50):
            one = Emulator(basis, Values(values.draw, column[:, None]))
            mean = column - one.residual[:, 0]
            n = len(column) - int(one.n_terms[0])
            deviation = np.sqrt(one.scatter[0, 0] + more / n)
            a = (values.value[bound, c] - mean[bound]) / deviation
            hazard = np.exp(stats.norm.logpdf(a) - stats.norm.logsf(a))
            before = column[bound]
            column[bound] = mean[bound] + deviation * hazard
            more = float(np.sum(deviation**2 * (1 - hazard * (hazard - a))))
            if np.max(np.abs(column[bound] - before)) < 1e-4 * deviation:
                break
        p = special.ndtr(-a) * random.random(a.size)
        found[bound, c] = mean[bound] - deviation * special.ndtri(np.maximum(p, 1e-300))
    return Values(values.draw, found)
