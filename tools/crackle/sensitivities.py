# SPDX-License-Identifier: GPL-3.0-or-later
"""Effects of the random inputs and of the mesh on results: as `crackle stats` computes them and, of correlated inputs, Shapley effects."""
from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, Iterator, Optional, Sequence

import numpy as np
import pandas as pd
from scipy import linalg

from .comparison import Rows
from .emulator import MOST_BOUNDS, Basis, Emulator, Inputs, Values, imputed
from .files import ResultsError
from .posterior import random_numbers
from .program import observed_of, statistics_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

N_OUTER, N_INNER = 4000, 4  # points, and of each so many values of the inputs that vary
MOST_ORDERS = 720  # of the inputs: all of up to six, else so many at random
N_BOOTSTRAP = 200


class Sensitivities:
    """`table` has a row for each result, share and input: Sobol' indices "first" and "total" and the "rank_correlation", each with its interval. Where inputs are
    correlated there are no indices but, of results and shares, "shapley" effects, which add up to what the expansion explains. `results` has a row for each result: shares of the variance that are of the "mesh", "predicted" by the expansion, or neither ("lack_of_fit")."""

    def __init__(self, document: dict[str, Any]) -> None:
        if "sensitivities" not in document:
            raise ResultsError("the ensemble has no random inputs")
        self.document = document["sensitivities"]
        keys = [one["key"] for one in document["inputs"]]
        sections = document["crack_path"]["section_name"]
        rows, effects = [], []
        for one in self.document["results"]:
            where = f"start {one['notch']}, {sections[one['section']]}" if "notch" in one else one["share_of"]
            index = {"result": one["result"], "of": where}
            mesh = {"mesh" + end: one["mesh"][name] for name, end in (("value", ""), ("lower", "_lower"), ("upper", "_upper"))}
            rows.append({**index, **mesh, **{name: one[name] for name in ("predicted", "lack_of_fit", "degree", "n_values", "n_draws", "n_bounds")}})
            for key, effect in zip(keys, one["inputs"]):
                effects.append({**index, "input": key, **{name + end: effect[name][value] for name in ("first", "total", "rank_correlation")
                                                          for value, end in (("value", ""), ("lower", "_lower"), ("upper", "_upper"))}})
        self.results = pd.DataFrame(rows).set_index(["result", "of"]) if rows else pd.DataFrame()
        self.table = pd.DataFrame(effects).set_index(["result", "of", "input"]).astype(float) if effects else pd.DataFrame()

    @property
    def _main(self) -> str:
        return "shapley" if "shapley" in self.table else "total"

    def __str__(self) -> str:
        if self.table.empty:
            return "too few draws for sensitivity indices\n"
        of_all = self.results[["mesh", "predicted"]].astype(float)
        of_all.columns = pd.MultiIndex.from_product([of_all.columns, [""]])  # as those of the inputs
        return self.table[[self._main, "rank_correlation"]].unstack("input").join(of_all).round(2).to_string() + "\n"

    def plot(self, axes: Optional["Axes"] = None) -> "Axes":
        """Total indices of each result, by input."""
        from .plots import _axes
        axes = _axes(axes)
        totals = self.table[self._main].unstack("input").dropna(how="all").iloc[::-1]
        for k, key in enumerate(totals):
            axes.barh([i + 0.8 * (0.5 - (k + 0.5) / totals.shape[1]) for i in range(len(totals))], totals[key], 0.8 / totals.shape[1], label=key)
        axes.set_yticks(range(len(totals)), [f"{result.replace('_', ' ')}{': ' + of if of else ''}" for result, of in totals.index])
        axes.set(xlabel="Shapley effect" if self._main == "shapley" else "total Sobol' index", xlim=(0, 1))
        axes.legend(fontsize="small")
        return axes


def sensitivities(folder: Path, program: str | Path | None = None) -> Sensitivities:
    """Raises ResultsError, also where there are no random inputs."""
    document = statistics_of(folder, program)
    found, about = Sensitivities(document), observed_of(folder, program)
    if about["correlation"] is not None and len(found.table):
        effects = dict(_effects(Rows(str(folder), document), document, Inputs(about["random"], about["correlation"])))
        columns = {"shapley": 0, "shapley_lower": 1, "shapley_upper": 2}
        keys = [one["key"] for one in document["inputs"]]
        for name, column in columns.items():
            found.table[name] = [effects[result, of][column, keys.index(key)] if (result, of) in effects else np.nan for result, of, key in found.table.index]
    return found


def _effects(rows: Rows, document: dict[str, Any], inputs: Inputs) -> Iterator[tuple[tuple[str, str], np.ndarray]]:
    """Of each result and share that has sensitivities, but positions: effects with intervals, 3 x inputs."""
    drawn = np.array([one["values"] for one in document["inputs"]], float).T
    infos = {info["name"]: info for info in document["results"]}
    variances: dict[int, VarianceParts] = {}
    for one in document["sensitivities"]["results"]:
        if "notch" in one or one["result"] not in infos:
            continue
        info = infos[one["result"]]
        values, is_bound = rows.observed(info)
        if one["share_of"]:
            values = np.where(np.isnan(values), np.nan, values == info["categories"].index(one["share_of"]) if one["share_of"] in info["categories"] else values > 0)
        has = np.flatnonzero(rows.is_done & ~np.isnan(values) & ~np.isnan(drawn).any(axis=1))
        if is_bound[has].mean() > MOST_BOUNDS:
            continue
        _, first, draw = np.unique(rows.draw[has], return_index=True, return_inverse=True)
        basis = Basis(inputs, drawn[has][first])
        emulator = Emulator(basis, imputed(basis, Values(draw, values[has, None]), is_bound[has, None]))
        if emulator.n_terms[0] > 1:
            if len(basis.degrees) not in variances:
                variances[len(basis.degrees)] = VarianceParts(basis)
            yield (one["result"], one["share_of"]), shapley_effects(emulator, variances[len(basis.degrees)])


class VarianceParts:
    """Of a function with coefficients c of a basis: its variance due to some inputs, E[Var(f | all others)] = c^T M c, by samples of them given the others."""

    def __init__(self, basis: Basis) -> None:
        self.n = len(basis.inputs)
        self._basis, self._factor = basis, basis.inputs.factor
        self._z = random_numbers(8).standard_normal((N_OUTER, self.n)) @ self._factor.T
        orders = list(itertools.permutations(range(self.n))) if math.factorial(self.n) <= MOST_ORDERS else \
            [random_numbers(9, k).permutation(self.n) for k in range(MOST_ORDERS)]
        known: dict[frozenset, np.ndarray] = {}
        terms = len(basis.degrees)
        self.parts = np.zeros((self.n, terms, terms))  # Shapley's, by the mean over the orders in which inputs come to vary
        for order in orders:
            before = np.zeros((terms, terms))
            for k, own in enumerate(order):
                varying = frozenset(order[:k + 1])
                if varying not in known:
                    known[varying] = self._due_to(sorted(varying))
                self.parts[own] += (known[varying] - before) / len(orders)
                before = known[varying]

    def _due_to(self, varying: Sequence[int]) -> np.ndarray:
        fixed = [k for k in range(self.n) if k not in varying]
        correlation = self._factor @ self._factor.T
        slope = linalg.solve(correlation[np.ix_(fixed, fixed)], correlation[np.ix_(fixed, varying)]) if fixed else np.zeros((0, self.n))
        rest = np.linalg.cholesky(correlation[np.ix_(varying, varying)] - correlation[np.ix_(varying, fixed)] @ slope)
        z = np.repeat(self._z[:, None], N_INNER, axis=1)
        z[:, :, varying] = z[:, :, fixed] @ slope + random_numbers(10).standard_normal((N_OUTER, N_INNER, len(varying))) @ rest.T
        terms = self._basis.terms(linalg.solve_triangular(self._factor, z.reshape(-1, self.n).T, lower=True).T).reshape(N_OUTER, N_INNER, -1)
        apart = (terms - terms.mean(axis=1, keepdims=True)).reshape(N_OUTER * N_INNER, -1)
        return apart.T @ apart / (N_OUTER * (N_INNER - 1))


def shapley_effects(emulator: Emulator, variance: VarianceParts) -> np.ndarray:
    """Shares of the variance of an emulator's only component (Song, Nelson and Staum 2016, SIAM/ASA J. Uncertain. Quantif. 4, 1060), without the bias by scatter, and
    95 % intervals by bootstrap samples of the draws: 3 x inputs."""
    n, draw, value = int(emulator.n_terms[0]), emulator.values.draw, emulator.values.value[:, 0]
    parts, table = variance.parts[:, :n, :n], emulator.basis.table[draw, :n]

    def shares(rows: np.ndarray) -> np.ndarray:
        inverse = linalg.pinv(table[rows].T @ table[rows])
        coefficient = inverse @ table[rows].T @ value[rows]
        scatter = np.sum((value[rows] - table[rows] @ coefficient)**2) / max(1, len(rows) - n)
        explained = np.maximum(0, np.einsum("kij,i,j->k", parts, coefficient, coefficient) - scatter * np.einsum("kij,ij->k", parts, inverse))
        return explained / (explained.sum() + scatter)
    own, random, members = shares(np.arange(len(value))), random_numbers(11), [np.flatnonzero(draw == k) for k in range(draw.max() + 1)]
    tried = np.array([shares(np.concatenate([members[k] for k in random.integers(len(members), size=len(members))])) for _ in range(N_BOOTSTRAP)])
    return np.clip([own, *(own + np.quantile(tried, (0.025, 0.975), axis=0) - tried.mean(axis=0))], 0, 1)
