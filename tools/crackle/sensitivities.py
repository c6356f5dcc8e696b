# SPDX-License-Identifier: GPL-3.0-or-later
"""Effects of the random inputs and of the mesh on results, as `crackle stats` computes them."""
from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Optional

import pandas as pd

from .files import ResultsError
from .program import statistics_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Sensitivities:
    """`table` has a row for each result, share and input: Sobol' indices "first" and "total" and the "rank_correlation", each with its interval; NaN where inputs
    are correlated. `results` has a row for each result: shares of the variance that are of the "mesh", "predicted" by the expansion, or neither ("lack_of_fit")."""

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

    def __str__(self) -> str:
        if self.table.empty:
            return "too few draws for sensitivity indices\n"
        return self.table[["total", "rank_correlation"]].unstack("input").round(2).join(self.results[["mesh", "predicted"]].astype(float).round(2)).to_string() + "\n"

    def plot(self, axes: Optional["Axes"] = None) -> "Axes":
        """Total indices of each result, by input."""
        from .plots import _axes
        axes = _axes(axes)
        totals = self.table["total"].unstack("input").dropna(how="all").iloc[::-1]
        for k, key in enumerate(totals):
            axes.barh([i + 0.8 * (0.5 - (k + 0.5) / totals.shape[1]) for i in range(len(totals))], totals[key], 0.8 / totals.shape[1], label=key)
        axes.set_yticks(range(len(totals)), [f"{result.replace('_', ' ')}{': ' + of if of else ''}" for result, of in totals.index])
        axes.set(xlabel="total Sobol' index", xlim=(0, 1))
        axes.legend(fontsize="small")
        return axes


def sensitivities(folder: Path, program: str | Path | None = None) -> Sensitivities:
    """Raises ResultsError, also where there are no random inputs."""
    return Sensitivities(statistics_of(folder, program))
