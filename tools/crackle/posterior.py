# SPDX-License-Identifier: GPL-3.0-or-later
"""The likelihood of experiments given the inputs, and points of the posterior.

Not emcee's: its chains give no evidence, which the bits of information need, and hardly change between two modes.
"""
from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Callable, Sequence

import numpy as np
from scipy import linalg, optimize, special

from .emulator import Emulator

LEAST_DEVIATION = 1e-4  # that results without scatter have, as a share of that over all samples
MOST_DEGREES = 1e8  # of freedom: as good as infinitely many
NO_SQUARE = 1e-3  # a squared distance up to this is none
SUPPORT = 3.0  # deviations of the inputs' normal variables within which draws lie
T_DEGREES, N_CLUSTERS, N_FIT_STEPS = 6, 3, 5
LEAST_WEIGHT = 1e-2  # a fit leaves points out that weigh less than this share of the mean
PRIOR_SHARE, WIDE_SHARE, WIDE_FACTOR = 0.05, 0.15, 2.0  # of proposals that keep weights bounded
SIZE_PER_VARIABLE = 20.0  # effective size that a fit needs


@dataclass
class Block:
    """Neighbouring components that describe one quantity."""

    name: str
    unit: str
    first: int
    count: int
    shape: np.ndarray  # covariance of a smooth deviation: of the model from the experiments, or of a specimen from others

    @property
    def columns(self) -> slice:
        return slice(self.first, self.first + self.count)


@dataclass
class Observed:
    """Experiments as components."""

    mean: np.ndarray  # of the experiments that have the component; NaN of none
    share: np.ndarray  # covariances of means over those of single experiments
    error: np.ndarray  # covariance of reading or measuring, of a single experiment
    blocks: list[Block]
    contrasts: np.ndarray  # orthonormal ones of the experiments that have all components, one a row
    values: np.ndarray  # experiments x components; NaN: not observed
    bounds: list[tuple[int, float]] = field(default_factory=list)  # component and value below which a specimen did not break

    def only(self, columns: Sequence[int], blocks: list[Block]) -> "Observed":
        c = list(columns)
        return Observed(self.mean[c], self.share[np.ix_(c, c)], self.error[np.ix_(c, c)], blocks, self.contrasts[:, c], self.values[:, c],
                        [(c.index(at), value) for at, value in self.bounds if at in c])


def observed(values: np.ndarray, error: np.ndarray, blocks: list[Block], bounds: Sequence[tuple[int, float]] = ()) -> Observed:
    """@param values of the experiments; NaN where not observed"""
    values = np.atleast_2d(values)
    has = (~np.isnan(values)).astype(float)
    count = has.sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean, share = np.nansum(values, axis=0) / count, np.nan_to_num(has.T @ has / np.outer(count, count))
    whole = values[has.all(axis=1)]
    # Helmert's: each experiment against the mean of those before.
    contrasts = [np.sqrt(k / (k + 1)) * (whole[k] - whole[:k].mean(axis=0)) for k in range(1, len(whole))]
    return Observed(mean, share, error, blocks, np.array(contrasts).reshape(-1, values.shape[1]), values, list(bounds))


@dataclass(frozen=True)
class Terms:
    """Of the covariance that can be left out or added, each for every quantity."""

    discrepancy: bool = False
    between_specimens: bool = False  # beyond mesh scatter and reading
    emulator_error: bool = True  # else mean and scatter count as known, for tests


class Likelihood:
    """Synthetic likelihood (Wood 2010, Nature 466, 1102): the mean of the experiments has a t distribution about the emulator (Sellentin and Heavens 2016,
    MNRAS 456, L132), whose covariance is the mesh scatter and the error of reading over the number of experiments, and the error of the emulator.
    Discrepancy (Kennedy and O'Hagan 2001, J. R. Stat. Soc. B 63, 425) and scatter between specimens have half-Cauchy scales a priori, relative to the
    scatter of a sample as read (Gelman 2006, Bayesian Anal. 1, 515). A specimen that did not break has the probability of what lies above its load.

    Variables: the standard normal ones of the inputs, then those of the scales of the discrepancy and of the specimens' scatter, by quantity.
    """

    def __init__(self, emulator: Emulator, seen: Observed, terms: Terms = Terms()) -> None:
        self.emulator, self.seen, self.terms = emulator, seen, terms
        self.n_inputs = len(emulator.basis.inputs)
        self.n_variables = self.n_inputs + len(seen.blocks) * (terms.discrepancy + terms.between_specimens)
        self._least = LEAST_DEVIATION**2 * emulator.variance
        scatter, shared = emulator.scatter, emulator.shared_scatter
        single = scatter + seen.error
        self.prior_scale = [np.sqrt((np.trace(single[b.columns, b.columns]) + self._least[b.columns].sum()) / np.trace(b.shape)) for b in seen.blocks]
        self.degrees = MOST_DEGREES
        self._has = ~np.isnan(seen.mean)
        if not terms.emulator_error:
            shared = np.zeros_like(shared)
        else:
            # The covariance is estimated; where much of it is known, the distribution is nearer to a normal one.
            n = emulator.n
            degrees = emulator.degrees_of_freedom - n + 1
            scatter, shared = (emulator.degrees_of_freedom / degrees * one for one in (scatter, shared))
            share = np.where(seen.share > 0, seen.share, np.eye(n))
            estimated = share * scatter + emulator.mean_leverage * shared
            known = np.trace(np.linalg.solve(estimated + share * seen.error + np.diag(self._least), estimated)) / n
            self.degrees = min(MOST_DEGREES, degrees / max(known**2, degrees / MOST_DEGREES))
        self._scatter, self._shared = scatter, shared

    def scale(self, number: int, variable: np.ndarray) -> np.ndarray:
        """Of the discrepancy or the specimens' scatter in a quantity. @param number among the variables after the inputs"""
        upper = np.maximum(special.ndtr(-variable), 1e-15)
        return self.prior_scale[number % len(self.seen.blocks)] / np.tan(np.pi / 2 * upper)

    def _shapes(self, x: np.ndarray, first: int) -> np.ndarray:
        found = np.zeros((len(x), self.emulator.n, self.emulator.n))
        for k, block in enumerate(self.seen.blocks):
            found[:, block.columns, block.columns] = self.scale(first + k, x[:, self.n_inputs + first + k])[:, None, None]**2 * block.shape
        return found

    def _parts(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Mean, covariance of a single experiment and what all have in common."""
        w = x[:, :self.n_inputs]
        mean, leverage = self.emulator.predict(w)
        single = np.broadcast_to(self._scatter, (len(x), *self._scatter.shape))
        if self.emulator.slopes.any():
            wider = self.emulator.widening(w)
            single = single * wider[:, :, None] * wider[:, None, :]
        single = single + self.seen.error
        # The bases are nested: two means have the terms of the lower degree in common.
        common = np.minimum(leverage[:, :, None], leverage[:, None, :]) * self._shared
        if self.terms.discrepancy:
            common = common + self._shapes(x, 0)
        if self.terms.between_specimens:
            single = single + self._shapes(x, len(self.seen.blocks) if self.terms.discrepancy else 0)
        return mean, single, common

    def expected(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distribution of the mean of the experiments, of components that none has for a single one."""
        mean, single, common = self._parts(x)
        share = np.where(np.outer(self._has, self._has), self.seen.share, np.eye(self.emulator.n))
        return mean, common + share * single + np.diag(self._least)

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Its logarithm: one for each point."""
        mean, single, common = self._parts(x)
        found = np.zeros(len(x))
        has = self._has
        if has.any():
            covariance = (common + self.seen.share * single + np.diag(self._least))[:, has][:, :, has]
            found += self._density((self.seen.mean - mean)[:, has], covariance)
        if self.terms.between_specimens and len(self.seen.contrasts):
            own = single + np.diag(self._least)
            factor = np.linalg.cholesky(own)
            for row in self.seen.contrasts:
                found += self._of_factor(np.broadcast_to(row, mean.shape), factor)
        for c, bound in self.seen.bounds:
            deviation = np.sqrt(single[:, c, c] + common[:, c, c] + self._least[c])
            found += np.log(np.maximum(1e-300, special.stdtr(self.degrees, (mean[:, c] - bound) / deviation)))
        return found

    def squares(self, w: np.ndarray) -> np.ndarray:
        """Squared distances of the observations from what is expected, in standard deviations."""
        mean, covariance = self.expected(np.hstack([w, np.full((len(w), self.n_variables - self.n_inputs), -3.0)]))
        has = self._has
        apart = (self.seen.mean - mean)[:, has]
        return np.einsum("ij,ij->i", apart, np.linalg.solve(covariance[:, has][:, :, has], apart[..., None])[..., 0])

    def least_square(self, points: "Points") -> float:
        """The least of them within SUPPORT. @param points of the posterior, near which a search begins"""
        start = np.clip(points.x[:, :self.n_inputs], -SUPPORT, SUPPORT)
        values = self.squares(start)
        first, least, step = start[np.argmin(values)], float(values.min()), 1e-4
        if least > NO_SQUARE:
            def with_gradient(w: np.ndarray) -> tuple[float, np.ndarray]:
                values = self.squares(np.vstack([w, w + step * np.eye(w.size)]))
                return float(values[0]), (values[1:] - values[0]) / step
            found = optimize.minimize(with_gradient, first, jac=True, method="L-BFGS-B", bounds=[(-SUPPORT, SUPPORT)] * first.size,
                                      options={"maxiter": 30, "ftol": 1e-5})
            least = min(least, float(found.fun))
        return least if least > NO_SQUARE else 0.0

    def _density(self, apart: np.ndarray, covariance: np.ndarray) -> np.ndarray:
        return self._of_factor(apart, np.linalg.cholesky(covariance))

    def _of_factor(self, apart: np.ndarray, factor: np.ndarray) -> np.ndarray:
        n = apart.shape[1]
        square = np.sum(np.linalg.solve(factor, apart[..., None])[..., 0]**2, axis=1)
        log_determinant = 2 * np.sum(np.log(np.diagonal(factor, axis1=1, axis2=2)), axis=1)
        return (special.gammaln((self.degrees + n) / 2) - special.gammaln(self.degrees / 2) - n / 2 * np.log(self.degrees * np.pi) - log_determinant / 2
                - (self.degrees + n) / 2 * np.log1p(square / self.degrees))


@dataclass(frozen=True)
class Effort:
    population: int = 2000
    wanted_size: float = 4000  # effective size at which sampling ends
    most_populations: int = 20


FULL, PART, SMALL = Effort(), Effort(1000, 1000, 10), Effort(500, 500, 8)


@dataclass
class Points:
    """Weighted ones of a posterior, independent standard normal a priori."""

    x: np.ndarray
    weight: np.ndarray  # sum 1
    bits: float  # Kullback-Leibler divergence of the posterior from the prior

    @property
    def effective_size(self) -> float:
        return float(1 / np.sum(self.weight**2))

    def resampled(self, n: int, random: np.random.Generator) -> np.ndarray:
        """Indices of points with equal weights, each as often as it is drawn, ascending (systematic resampling)."""
        return np.minimum(np.searchsorted(np.cumsum(self.weight), (random.random() + np.arange(n)) / n), len(self.weight) - 1)


def random_numbers(purpose: int, number: int = 0) -> np.random.Generator:
    """The same in each call."""
    return np.random.Generator(np.random.Philox(key=[purpose, number]))


def sample(likelihood: Callable[[np.ndarray], np.ndarray], n_variables: int, effort: Effort, random: np.random.Generator) -> Points:
    """Adaptive importance sampling: populations from a mixture of t distributions that is fitted to all earlier points, weighted as if all came from the
    mixture of all proposals (Cappé et al. 2004, J. Comput. Graph. Stat. 13, 907; Cornuet et al. 2012, Scand. J. Stat. 39, 798). While weights are too
    uneven for a fit, it is to a power of the likelihood."""
    proposals = [_Mixture(np.zeros(1), np.zeros((1, n_variables)), np.eye(n_variables)[None])]
    x = np.empty((0, n_variables))
    logs, of_proposals = np.empty(0), np.empty(0)
    log_size = np.log(effort.population)

    def weights(power: float) -> tuple[np.ndarray, float]:
        log_weight = -np.sum(x**2, axis=1) / 2 - n_variables / 2 * np.log(2 * np.pi) + power * logs - of_proposals
        most = log_weight.max()
        weight = np.exp(log_weight - most)
        return weight / weight.sum(), most + float(np.log(weight.sum()))

    for k in range(effort.most_populations):
        if k > 0:
            power = _power_for(lambda power: 1 / np.sum(weights(power)[0]**2), SIZE_PER_VARIABLE * n_variables)
            weight = weights(power)[0]
            if power == 1 and 1 / np.sum(weight**2) >= effort.wanted_size:
                break
            proposals.append(_fitted(x, weight))
            of_proposals = np.logaddexp(of_proposals, log_size + proposals[-1].log_density(x))
        new = proposals[-1].draw(effort.population, random)
        x, logs = np.vstack([x, new]), np.append(logs, likelihood(new))
        of_proposals = np.append(of_proposals, special.logsumexp([log_size + one.log_density(new) for one in proposals], axis=0))
    weight, evidence = weights(1.0)
    return Points(x, weight, float(weight @ np.where(weight > 0, logs, 0) - evidence) / np.log(2))


def _power_for(size: Callable[[float], float], wanted: float) -> float:
    """The largest power for which the weights have this effective size."""
    if size(1.0) >= wanted:
        return 1.0
    lower, upper = 0.0, 1.0
    for _ in range(25):
        middle = (lower + upper) / 2
        lower, upper = (middle, upper) if size(middle) >= wanted else (lower, middle)
    return lower


@dataclass
class _Mixture:
    """Of multivariate t distributions."""

    log_weight: np.ndarray
    mean: np.ndarray
    factor: np.ndarray  # lower triangles; factor factor^T is the covariance of the normal part

    def log_densities(self, x: np.ndarray) -> np.ndarray:
        """Of each component with its weight: components x points."""
        n = x.shape[1]
        constant = special.gammaln((T_DEGREES + n) / 2) - special.gammaln(T_DEGREES / 2) - n / 2 * np.log(T_DEGREES * np.pi)
        rows = []
        for log_weight, mean, factor in zip(self.log_weight, self.mean, self.factor):
            square = np.sum(linalg.solve_triangular(factor, (x - mean).T, lower=True, check_finite=False)**2, axis=0)
            rows.append(log_weight + constant - np.sum(np.log(np.diag(factor))) - (T_DEGREES + n) / 2 * np.log1p(square / T_DEGREES))
        return np.array(rows)

    def log_density(self, x: np.ndarray) -> np.ndarray:
        return special.logsumexp(self.log_densities(x), axis=0)

    def draw(self, n: int, random: np.random.Generator) -> np.ndarray:
        share = np.exp(self.log_weight)
        which = random.choice(share.size, n, p=share / share.sum())
        width = np.sqrt(T_DEGREES / random.chisquare(T_DEGREES, n))
        return self.mean[which] + width[:, None] * np.einsum("ijk,ik->ij", self.factor[which], random.standard_normal((n, self.mean.shape[1])))


def _fitted(x: np.ndarray, weight: np.ndarray) -> _Mixture:
    """A mixture like weighted points, by expectation maximization."""
    kept = weight * len(x) >= LEAST_WEIGHT
    x, weight = x[kept], weight[kept] / weight[kept].sum()
    n = x.shape[1]

    def moments(of: np.ndarray, least: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        total = max(of.sum(), 1e-300)
        mean = of @ x / total
        return float(np.log(total)), mean, (x - mean).T @ ((x - mean) * (of / total)[:, None]) + least
    _, middle, covariance = moments(weight, 1e-10 * np.eye(n))
    # At first clusters of equal weight along the widest direction.
    order = np.argsort(x @ np.linalg.eigh(covariance)[1][:, -1], kind="stable")
    share = np.zeros((N_CLUSTERS, len(x)))
    share[np.minimum(N_CLUSTERS - 1, (N_CLUSTERS * (np.cumsum(weight[order]) - weight[order])).astype(int)), order] = 1
    for _ in range(N_FIT_STEPS):
        parts = [moments(weight * one, 0.02 * covariance) for one in share]
        mixture = _Mixture(np.array([part[0] for part in parts]), np.array([part[1] for part in parts]), np.linalg.cholesky(np.array([part[2] for part in parts])))
        densities = mixture.log_densities(x)
        share = np.exp(densities - special.logsumexp(densities, axis=0))
    return replace(mixture, log_weight=np.append(mixture.log_weight + np.log(1 - PRIOR_SHARE - WIDE_SHARE), np.log([WIDE_SHARE, PRIOR_SHARE])),
                   mean=np.vstack([mixture.mean, middle, np.zeros(n)]),
                   factor=np.concatenate([mixture.factor, [np.sqrt(WIDE_FACTOR) * np.linalg.cholesky(covariance), np.eye(n)]]))
