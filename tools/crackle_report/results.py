# SPDX-License-Identifier: GPL-3.0-or-later
"""An ensemble's results in memory, in SI units; `reading` fills them from the files."""
from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Callable, Optional, TypeVar

import numpy as np

from .plate import Plate

if TYPE_CHECKING:
    from .ranks import LeaderFrame

PENDING, DONE, FAILED = 0, 1, 2
PathsKind = TypeVar("PathsKind", bound="Paths")


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
class Forks:
    """Where one crack becomes two, of one sample."""

    position: np.ndarray  # n x 2: y, z where the gap between the arms begins [m]
    x: np.ndarray  # middle of the range through the thickness [m]
    time: np.ndarray  # when the later arm opened, since onset [s]
    length: np.ndarray  # of the arm that leaves [m]
    angle: np.ndarray  # between the arms [rad]
    share: np.ndarray  # of the thickness that the arm which leaves spans
    notch: np.ndarray
    in_projection: np.ndarray  # 0 or 1
    in_space: np.ndarray  # 0 or 1


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


@dataclass(frozen=True)
class Result:
    """What a number of each sample means, as the result files say."""

    name: str  # of its dataset
    label: str
    units: str  # that it is shown in
    factor: float  # from SI to these
    format: str
    categories: dict[int, str]  # the words that its numbers stand for; empty for other numbers


@dataclass
class Samples:
    """One row for each sample; NaN where there is no value. A result is an attribute: `samples.onset_force`."""

    status: np.ndarray
    error: list[str]
    results: tuple[Result, ...]  # in the order of tables
    numbers: dict[str, np.ndarray]  # of each result, in SI units
    position: np.ndarray  # along the sections; samples x notches x sections [m]
    z_spread: np.ndarray  # its standard deviation through the thickness
    branches: np.ndarray  # samples x notches x sections

    def __getattr__(self, name: str) -> np.ndarray:
        try:
            return self.__dict__["numbers"][name]
        except KeyError:
            raise AttributeError(name) from None

    def __len__(self) -> int:
        return len(self.status)

    def first(self, n: int) -> "Samples":
        """The samples 0 to n - 1."""
        return Samples(self.status[:n], self.error[:n], self.results,
                       {name: values[:n] for name, values in self.numbers.items()},
                       self.position[:n], self.z_spread[:n], self.branches[:n])

    def count(self, status: int) -> int:
        return int(np.count_nonzero(self.status == status))


@dataclass(frozen=True)
class CrossSection:
    """A plane y = const or z = const at which crack paths are measured."""

    axis: int  # 1: y, 2: z
    position: float  # of the plane, along that axis [m]

    @property
    def name(self) -> str:
        return f"{'y' if self.axis == 1 else 'z'} = {self.position * 1e3:g} mm"

    @property
    def along(self) -> str:
        """The coordinate in which a crack's position at this section is given."""
        return "z" if self.axis == 1 else "y"


def along(sections: tuple[CrossSection, ...]) -> str:
    """The coordinate of positions at these sections, for labels: "position" where it is not the same at all."""
    names = {section.along for section in sections}
    return names.pop() if len(names) == 1 else "position"


@dataclass
class Paths:
    """Statistics of crack positions over all samples done."""

    z_mean: np.ndarray  # of the position, rows x sections [m]
    z_std: np.ndarray
    z_half_width: np.ndarray
    reached: np.ndarray
    running_mean: np.ndarray  # samples x rows x sections [m]

    def first(self: "PathsKind", n: int) -> "PathsKind":
        """Without the running mean of the samples from n on, which an ensemble that stopped did not need."""
        return replace(self, running_mean=self.running_mean[:n])


@dataclass
class Ranks(Paths):
    """Of leading or following cracks in the frame of the leading one, as in /statistics/leader of ensemble.h5."""

    leading_notch: np.ndarray  # rows; the reference notch of the class of leading notches
    notch: np.ndarray  # rows; where the crack starts
    counted: np.ndarray  # rows x sections; samples that would count if their crack arrived


@dataclass
class Statistics(Paths):
    """As in /statistics of ensemble.h5: rows are notches, their cracks leading and following ones together."""

    pattern_share: np.ndarray
    pattern_half_width: np.ndarray

@dataclass
class Ensemble:
    folder: Path
    plate: Plate
    sections: tuple[CrossSection, ...]
    confidence: float
    n_looks: int  # at which the ensemble could stop; the intervals of all hold together with the confidence
    n_planned: int  # samples that the input asks for; more than len(samples) when it stopped early
    samples: Samples
    statistics: Statistics
    frame: "LeaderFrame"
    leading: np.ndarray  # of each sample the notch whose crack leads; -1 where none does or it is not known
    leading_is_derived: bool  # from the crossings, since the files do not hold it
    ranks: dict[str, Ranks]  # by their groups in /statistics
    interval_scope: str  # what the confidence intervals leave out
    provenance: dict[str, str]
    input_text: str
    stop_half_width: Optional[float]  # that the input's [ensemble.stop] asks for [m]
    load_crack: Callable[[int], Optional[CrackSurface]] = field(repr=False)
    load_lines: Callable[[int], list[CrackLine]] = field(repr=False)
    load_forks: Callable[[int], Optional[Forks]] = field(repr=False)
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

    def breaking_load(self) -> tuple[str, np.ndarray]:
        """Name and values [N] of the load that tells when the samples that are done broke: the onset, or where none
        has one, as when dynamics started from rest, the first break."""
        force = self.samples.onset_force[self.done]
        if "first_break_load" in self.samples.numbers and not np.isfinite(force).any():
            return "load at the first break", self.samples.first_break_load[self.done]
        return "onset force", force

    def rank_name(self, group: str, row: int) -> str:
        """The cracks of a row of /statistics/`group`, for people."""
        ranks = self.ranks[group]
        names = {"leader": "leading", "leader/one_crack": "leading, of samples with one crack",
                 "leader/two_cracks": "leading, of samples with two", "follower": "following"}
        of_class = f" where notch {ranks.leading_notch[row]} leads" if len(set(ranks.leading_notch)) > 1 else ""
        several = not group.startswith("leader") and self.n_notches > 2
        return names[group] + (f", of notch {ranks.notch[row]}" if several else "") + of_class

    @property
    def n_notches(self) -> int:
        return self.samples.position.shape[1]
