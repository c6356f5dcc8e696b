# SPDX-License-Identifier: GPL-3.0-or-later
"""An ensemble's results in memory, in SI units; `reading` fills them."""
from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from functools import cached_property
from typing import Any, Optional

import numpy as np
from crackle.files import DONE, PENDING
from crackle.outcomes import Ends
from crackle.units import US, Unit, fitting

from .fields import CrackSurface, Places
from .mesh import Regions
from .plate import Plate
from .sample_files import SampleFiles

N_TIMED = 3  # samples whose durations tell the unit of times


@dataclass(frozen=True)
class Share:
    """Of the samples done, with its confidence interval."""

    share: float
    lower: float
    upper: float


@dataclass(frozen=True)
class Result:
    """What a number of each sample means, as the program says."""

    name: str
    label: str
    units: str  # that it is shown in
    factor: float  # from SI to these
    format: str
    categories: list[str]  # the words that its numbers stand for, from 0 on; empty for other numbers
    n_any: int  # samples in which a number of things is above 0
    any: Optional[Share]  # of these; None for other results
    quantiles: tuple[float, ...] = ()  # least, 25 %, median, 75 %, greatest over the samples [SI]; NaN where only a bound is known
    bounds: tuple[float, ...] = ()  # these bounds; empty without
    n_bounds: int = 0  # samples of which only a bound is known: they did not break, or were held
    about: str = "body"  # what it tells of: also "place", "path", "hole" or "computation"
    explained: bool = False  # one of those whose sensitivities a reader asks for first
    of_unbroken: str = "value"  # of samples that did not break: also "bound", "nothing"
    tells_the_end: bool = False  # likewise of those that were held


@dataclass
class Samples:
    """One row for each sample; NaN where there is no value. A result is an attribute: `samples.onset_force`."""

    status: np.ndarray
    error: list[str]
    results: tuple[Result, ...]  # in the order of tables; those that the files hold
    numbers: dict[str, np.ndarray]  # of each result, in SI units
    position: np.ndarray  # along the sections; samples x notches x sections [m]
    arrival: np.ndarray  # when the crack came there, since onset; likewise [s]; NaN where it is not known
    wall_time: np.ndarray  # that each sample took [s]

    def __getattr__(self, name: str) -> np.ndarray:
        try:
            return self.__dict__["numbers"][name]
        except KeyError:
            raise AttributeError(name) from None

    def __len__(self) -> int:
        return len(self.status)

    def result(self, name: str) -> Result:
        return next(result for result in self.results if result.name == name)

    @property
    def ends(self) -> Ends:
        return Ends.of(self.status, self.numbers)

    def is_open(self, result: Result) -> np.ndarray:
        """Which ended before a result was decided."""
        return self.ends.is_open(result.of_unbroken, result.tells_the_end)

    def count(self, status: int) -> int:
        return int(np.count_nonzero(self.status == status))


@dataclass(frozen=True)
class CrossSection:
    """A plane y = const or z = const, or over a line, at which crack paths are measured."""

    axis: int  # 1: y, 2: z, 0: a line
    position: float  # of the plane, along that axis [m]; 0 for a line
    name: str
    along: str  # the coordinate in which a crack's position at this section is given
    ends: Optional[np.ndarray] = None  # of a line: 2 x 2, y and z of its start and end [m]

    def places(self, positions: np.ndarray) -> np.ndarray:
        """y, z of positions on a line [m]."""
        start, end = self.ends
        along = end - start
        return start + np.asarray(positions)[..., None] * along / np.hypot(*along)


def along(sections: tuple[CrossSection, ...]) -> str:
    """The coordinate of positions at these sections, for labels: "position" where it is not the same at all."""
    names = {section.along for section in sections}
    return names.pop() if len(names) == 1 else "position"


@dataclass
class Paths:
    """Statistics of crack positions over all samples done, rows x sections."""

    z_mean: np.ndarray  # of the position [m]
    z_std: np.ndarray
    z_half_width: np.ndarray
    spread_mean: np.ndarray  # mean of the positions' spread through the thickness [m]
    reached: np.ndarray
    is_divided: np.ndarray  # where the row's groups are apart, and the mean of all is no crack's position
    running_mean: np.ndarray  # samples x rows x sections [m]
    running_half_width: np.ndarray  # likewise


@dataclass
class PathGroup:
    """Samples of a row of Ranks whose cracks take one of several paths."""

    row: int
    n: int  # its samples
    n_of: int  # of the row
    share: float
    lower: float  # of the share's interval
    upper: float
    reached: np.ndarray  # by section, as the following ones
    z_mean: np.ndarray
    z_std: np.ndarray
    z_half_width: np.ndarray

    @property
    def size(self) -> str:
        return (f"{self.n} of {self.n_of} samples, {100 * self.share:.0f} % ({100 * self.lower:.0f} to {100 * self.upper:.0f} %)")


@dataclass
class Ranks(Paths):
    """Of leading or following cracks in the frame of the leading one, as in /statistics/leader of ensemble.h5."""

    leading_notch: np.ndarray  # rows; the reference notch of the class of leading notches
    notch: np.ndarray  # rows; where the crack starts
    counted: np.ndarray  # rows x sections; samples that would count if their crack arrived
    groups: list[PathGroup]

    def groups_of(self, row: int) -> list[PathGroup]:
        return [group for group in self.groups if group.row == row]

    def by_group(self, row: int, name: str) -> list[np.ndarray]:
        """A statistic of the positions at each section, as `z_mean`: of the row's cracks or, where these are apart, of each group."""
        of_all, divided = getattr(self, name)[row], self.is_divided[row].astype(bool)
        return [np.where(divided, getattr(group, name), of_all) for group in self.groups_of(row)] or [of_all]

    def row_of(self, reference: int, notch: int) -> Optional[int]:
        """The row of a notch of the frame, in samples of one class of leading notches; None where it has none."""
        rows = np.flatnonzero((self.leading_notch == reference) & (self.notch == notch))
        return int(rows[0]) if rows.size else None


@dataclass
class Statistics(Paths):
    """As in /statistics of ensemble.h5: rows are notches, their cracks leading and following ones together."""

    pattern_share: np.ndarray
    pattern_lower: np.ndarray
    pattern_upper: np.ndarray

    def pattern(self, number: int) -> Share:
        return Share(*(float(values[number]) for values in (self.pattern_share, self.pattern_lower, self.pattern_upper)))


@dataclass(frozen=True)
class Symmetry:
    """How samples that one notch leads are seen, as if the reference notch of its class led."""

    reference: int
    reflects_y: bool
    reflects_z: bool
    notch: list[int]  # of the sample, for each notch of the frame

    def mapped(self, points: np.ndarray, plate: Plate) -> np.ndarray:
        """Points y, z of a sample in the frame."""
        return np.where([self.reflects_y, self.reflects_z], [sum(plate.ends(1)), sum(plate.ends(2))] - points, points)


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
    precision: dict[str, Any]  # how well the mean path is known, see jobs/results.md
    symmetries: list[Symmetry]  # by the leading notch
    ranks: dict[str, Ranks]  # by their groups in /statistics
    interval_scope: str  # what the confidence intervals leave out
    notes: list[str]  # what else is to be known of these results
    provenance: dict[str, str]
    input_text: str
    files: SampleFiles
    inputs: list[dict[str, Any]]  # the random ones: key, units, distribution, values of each sample [SI]
    sensitivities: Optional[dict[str, Any]]  # what the results owe to these; None without
    warnings: list[str]  # of the program
    headline: str  # name of the load that says what the samples held
    materials: list[str]  # names
    fragments: Optional[dict[str, Any]] = None  # the program's `fragments`, with their `statistics`; None of older files
    unreadable: list[str] = field(default_factory=list)  # pictures of experiments, each with its reason

    @cached_property
    def times(self) -> Unit:
        """In which people see times since the onset: fits the durations of the first samples' last dynamic phases."""
        accounts = [self.files.energy(int(i)) for i in self.done[:N_TIMED]]
        return fitting([account.time[-1] for account in accounts if account is not None and account.time.size], US, least=0.5)

    @property
    def finished(self) -> bool:
        """No sample is pending."""
        return self.samples.count(PENDING) == 0

    @property
    def leading(self) -> np.ndarray:
        """Of each sample the notch whose crack leads; -1 where none does or it is not known."""
        return np.where(self.samples.status == DONE, self.samples.leading_notch, -1)

    @property
    def done(self) -> np.ndarray:
        """Numbers of the samples that are done."""
        return np.flatnonzero(self.samples.status == DONE)

    @property
    def shown(self) -> list[int]:
        """Those whose files, if there are any, can be read."""
        return [int(i) for i in self.done if i not in self.files.damage]

    @cached_property
    def places(self) -> dict[int, Places]:
        """Where the samples that are done broke, by number."""
        found = {int(i): self.files.places(int(i)) for i in self.done}
        return {i: place for i, place in found.items() if place is not None}

    @property
    def load(self) -> Result:
        """The load that says what the samples held."""
        return self.samples.result(self.headline)

    @cached_property
    def loads(self) -> np.ndarray:
        """Its values [N], of each sample; NaN of those of which a bound is known at most."""
        table = self.samples
        return np.where((table.status == DONE) & ~table.is_open(self.load), table.numbers[self.headline], np.nan)

    def shown_z(self, crack: CrackSurface) -> np.ndarray:
        """z of the facets that a panel has to show [m]: of cracks that start at notches and holes, or lead. What breaks elsewhere, as
        at supports, would stretch it."""
        starts = [start for start in range(self.n_notches) if self.plate.name_of(start) != "free surface" or start in self.leading]
        chosen = np.isin(crack.notch, starts)
        return crack.corner[chosen if chosen.any() else slice(None), :, 2]

    @property
    def tinted(self) -> str:
        """A sentence on the parts of other materials in pictures; empty where there are none."""
        return f" Tinted: {', '.join(self.materials[1:])}." if len(self.materials) > 1 else ""

    @cached_property
    def regions(self) -> Optional[Regions]:
        """The parts of other materials for pictures of all samples: those of the first."""
        return self.files.regions(int(self.shown[0])) if len(self.shown) else None

    def rows_shown(self, group: str) -> list[int]:
        """Rows of /statistics/`group` to draw or print. On a plate cracks may start in many places: those where some did."""
        ranks = self.ranks[group]
        rows = range(len(ranks.notch))
        if (self.plate.notch_axis != 0).all():
            return list(rows)
        return [row for row in rows
                if (ranks.counted if group.startswith("leader") else ranks.reached)[row].any()]

    def rank_name(self, group: str, row: int) -> str:
        """The cracks of a row of /statistics/`group`, for people."""
        ranks = self.ranks[group]
        names = {"leader": "leading", "leader/one_crack": "leading, of samples with one crack",
                 "leader/two_cracks": "leading, of samples with two cracks", "follower": "following"}
        of_class = f" where {self.plate.name_of(ranks.leading_notch[row])} leads" if len(set(ranks.leading_notch)) > 1 else ""
        several = not group.startswith("leader") and self.n_notches > 2
        return names[group] + (f", of {self.plate.name_of(ranks.notch[row])}" if several else "") + of_class

    @property
    def n_notches(self) -> int:
        return self.samples.position.shape[1]
