# SPDX-License-Identifier: GPL-3.0-or-later
"""How samples ended: which broke, and of which a load is known only as a bound; as src/analysis/result_list.h has it."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping

import numpy as np

from .files import DONE

UNBROKEN, UNDECIDED = 0, 4  # outcomes


@dataclass(frozen=True)
class Ends:
    """A value for each sample."""

    is_done: np.ndarray
    is_unbroken: np.ndarray
    is_held: np.ndarray  # arrested at its largest load, as the loading ended

    @classmethod
    def of(cls, status: np.ndarray, numbers: Mapping[str, Any]) -> "Ends":
        """@param numbers of each result; "held" is missing in files of older versions"""
        is_done = np.asarray(status) == DONE
        return cls(is_done, is_done & (np.asarray(numbers["outcome"]) == UNBROKEN), is_done & (np.asarray(numbers.get("held", 0)) == 1))

    def is_open(self, of_unbroken: str, tells_the_end: bool) -> np.ndarray:
        """Which ended before a result was decided. @param of_unbroken, tells_the_end of the result, as `crackle stats --json` says"""
        return (self.is_unbroken | (self.is_held & tells_the_end)) & (of_unbroken != "value")

    def is_bound(self, of_unbroken: str, tells_the_end: bool) -> np.ndarray:
        """Whose result lies above the peak load."""
        return self.is_open(of_unbroken, tells_the_end) & (of_unbroken == "bound")
