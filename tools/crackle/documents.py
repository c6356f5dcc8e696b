# SPDX-License-Identifier: GPL-3.0-or-later
"""The document of `crackle calibrate` as tables."""
from __future__ import annotations

from typing import Any

import pandas as pd


def calibration_table(found: dict[str, Any]) -> pd.DataFrame:
    """See Ensemble.calibrate."""
    table = pd.json_normalize(found["inputs"], sep="_").set_index("key")
    draws = pd.DataFrame(found["draws"]["values"], columns=table.index).assign(weight=found["draws"]["weights"])
    table.attrs = {"draws": draws, "document": found}
    return table
