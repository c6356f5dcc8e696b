# SPDX-License-Identifier: GPL-3.0-or-later
"""The document of `crackle match` as a table."""
from __future__ import annotations

from typing import Any

import pandas as pd


def match_table(found: dict[str, Any]) -> pd.DataFrame:
    """See Ensemble.match."""
    rows = {(experiment["name"], name): {**by, "nearest": [one["sample"] for one in by["nearest"]],
                                         "distance": [one["distance"] for one in by["nearest"]]}
            for experiment in found["experiments"] for name, by in experiment["by"].items()}
    table = pd.DataFrame(list(rows.values()), index=pd.MultiIndex.from_tuples(rows, names=["experiment", "by"]) if rows else None)
    of_set = [{"by": name, **by} for name, by in found["set"]["by"].items()] if found["set"] else []
    together = pd.json_normalize(of_set, sep="_").set_index("by") if of_set else None
    table.attrs = {"set": together, "warnings": found["warnings"], "document": found}
    return table
