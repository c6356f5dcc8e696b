# SPDX-License-Identifier: GPL-3.0-or-later
"""An ensemble's results in memory, in SI units; `reading` fills them from the files."""
from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable, Optional

import numpy as np

from .plate import Plate

PENDING, DONE, FAILED = 0, 1, 2


@dataclass(frozen=True)
class CrackSurface:
    """The opened dual facets of one sample, in order of breaking."""

    corner: np.ndarray  # facets x 4 x 3 [m]
    time: np.ndarray  # facets; since the onset of the last dynamic phase, negative before it [s]
    notch: np.ndarray  # facets; the notch that the facet's crack started at, or -1


@dataclass
class Samples:
    """One row for each sample; NaN where there is no value."""

    status: np.ndarray
    error: list[str]
    onset_force: np.ndarray  # [N]
    onset_time: np.ndarray  # [s]
    outcome: np.ndarray  # how the sample ended: index into tables.OUTCOME_NAMES
    pattern: np.ndarray
    bifurcations: np.ndarray
    crack_area: np.ndarray  # [m^2]
    crack_speed_max: np.ndarray  # [m/s]
    energy_error: np.ndarray
    z: np.ndarray  # samples x notches x sections [m]
    branches: np.ndarray  # samples x notches x sections

    def __len__(self) -> int:
        return len(self.status)

    def count(self, status: int) -> int:
        return int(np.count_nonzero(self.status == status))


@dataclass
class Statistics:
    """Over all samples done, as in /statistics of ensemble.h5."""

    z_mean: np.ndarray  # notches x sections [m]
    z_std: np.ndarray
    z_half_width: np.ndarray
    reached: np.ndarray
    running_mean: np.ndarray  # samples x notches x sections [m]
    pattern_share: np.ndarray
    pattern_half_width: np.ndarray


@dataclass
class Ensemble:
    folder: Path
    plate: Plate
    sections: np.ndarray  # y of the cross-sections [m]
    confidence: float
    samples: Samples
    statistics: Statistics
    provenance: dict[str, str]
    input_text: str
    load_crack: Callable[[int], Optional[CrackSurface]] = field(repr=False)

    @property
    def finished(self) -> bool:
        """No sample is pending."""
        return self.samples.count(PENDING) == 0

    @property
    def n_notches(self) -> int:
        return self.samples.z.shape[1]
