# SPDX-License-Identifier: GPL-3.0-or-later
"""An ensemble's results in memory, in SI units; `reading` fills them from the files."""
from __future__ import annotations

from dataclasses import dataclass, field, replace
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


@dataclass(frozen=True)
class CrackLine:
    """A crack as a line in the YZ plane: the mean of its surface over the thickness."""

    notch: int
    is_branch: bool
    points: np.ndarray  # n x 2: y, z [m]


@dataclass(frozen=True)
class Energy:
    """The energy account over the last dynamic phase [J], counted from the unloaded body."""

    time: np.ndarray  # since its onset [s]
    kinetic: np.ndarray
    strain: np.ndarray
    external: np.ndarray
    released: np.ndarray
    dissipated: np.ndarray


@dataclass(frozen=True)
class Frames:
    """A sample's fields at some times of the last dynamic phase, and what their stress follows from."""

    nodes: np.ndarray  # n x 3 [m]
    tetrahedra: np.ndarray  # m x 4
    time: np.ndarray  # frames; since onset [s]
    displacement: np.ndarray  # frames x n x 3 [m]
    velocity: np.ndarray  # frames x n x 3 [m/s]
    broken: list[np.ndarray]  # for each frame the tetrahedra broken by then
    cut: list[np.ndarray]  # the most loaded cut of each of them when it broke, index into stress.CUTS
    released: list[np.ndarray]  # the edges that each of them has let go of by then, as bits in the order of mesh.EDGES
    has_contact: bool  # whether they resist being closed again
    youngs_modulus: float  # [Pa]
    poisson_ratio: float


@dataclass
class Samples:
    """One row for each sample; NaN where there is no value."""

    status: np.ndarray
    error: list[str]
    onset_force: np.ndarray  # [N]
    onset_time: np.ndarray  # [s]
    outcome: np.ndarray  # how the sample ended: index into tables.OUTCOME_NAMES
    pattern: np.ndarray
    overlap: np.ndarray  # of the one crack with the other turned by 180 degrees, 0 to 1
    bifurcations: np.ndarray
    kinks: np.ndarray
    crack_area: np.ndarray  # [m^2]
    crack_speed_max: np.ndarray  # [m/s]
    crack_speed_ratio: np.ndarray  # over the Rayleigh speed
    effective_toughness: np.ndarray  # released energy over the traced crack area [J/m^2]
    energy_error: np.ndarray
    z: np.ndarray  # samples x notches x sections [m]
    z_spread: np.ndarray  # its standard deviation through the thickness
    branches: np.ndarray  # samples x notches x sections

    def __len__(self) -> int:
        return len(self.status)

    def first(self, n: int) -> "Samples":
        """The samples 0 to n - 1."""
        return Samples(**{name: getattr(self, name)[:n] for name in self.__dataclass_fields__})

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

    def first(self, n: int) -> "Statistics":
        """Without the running mean of the samples from n on, which an ensemble that stopped did not need."""
        return replace(self, running_mean=self.running_mean[:n])


@dataclass
class Ensemble:
    folder: Path
    plate: Plate
    sections: np.ndarray  # y of the cross-sections [m]
    confidence: float
    n_looks: int  # at which the ensemble could stop; the intervals of all hold together with the confidence
    n_planned: int  # samples that the input asks for; more than len(samples) when it stopped early
    samples: Samples
    statistics: Statistics
    provenance: dict[str, str]
    input_text: str
    stop_half_width: Optional[float]  # that the input's [ensemble.stop] asks for [m]
    load_crack: Callable[[int], Optional[CrackSurface]] = field(repr=False)
    load_lines: Callable[[int], list[CrackLine]] = field(repr=False)
    load_energy: Callable[[int], Optional[Energy]] = field(repr=False)
    load_frames: Callable[[int], Optional[Frames]] = field(repr=False)

    @property
    def finished(self) -> bool:
        """No sample is pending."""
        return self.samples.count(PENDING) == 0

    @property
    def done(self) -> np.ndarray:
        """Numbers of the samples that are done."""
        return np.flatnonzero(self.samples.status == DONE)

    @property
    def n_notches(self) -> int:
        return self.samples.z.shape[1]
