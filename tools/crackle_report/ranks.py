# SPDX-License-Identifier: GPL-3.0-or-later
"""Leading and following cracks, in the frame of the leading one.

The same definitions as the program's, see include/crackle/analysis/leader_frame.h and crack_path.h.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

import numpy as np

from .plate import Notch, Plate
from .results import DONE, CrossSection, Ranks, Samples
from .statistics import path_statistics

TOLERANCE = 1e-12  # of coordinates, in the plate's largest size
ROUNDING = 1e-9  # of shares of a ligament
PATTERNS = {"leader/one_crack": 1, "leader/two_cracks": 2}
GROUPS = ("leader", *PATTERNS, "follower")  # of /statistics
OPPOSITE = {"y-min": "y-max", "y-max": "y-min", "z-min": "z-max", "z-max": "z-min"}


@dataclass(frozen=True)
class Turn:
    """How a sample is seen as if another notch led."""

    reflects_y: bool
    reflects_z: bool
    notch: tuple[int, ...]  # of the sample, for each notch of the frame

    def reflects(self, axis: int) -> bool:
        """axis: 1 y, 2 z."""
        return self.reflects_y if axis == 1 else self.reflects_z


class LeaderFrame:
    """Which notches a symmetry of the plate maps on each other, and how."""

    def __init__(self, plate: Plate, sections: tuple[CrossSection, ...]) -> None:
        self.plate = plate
        self.sections = sections
        self._near = TOLERANCE * max(plate.size)
        images = [[self._image(notch, in_y, in_z) for notch in plate.notches]
                  for in_z in (False, True) for in_y in (False, True)]
        turns = [(in_y, in_z) for in_z in (False, True) for in_y in (False, True)]
        symmetries = [(turn, image) for turn, image in zip(turns, images) if -1 not in image]
        self.reference, self.turns = [], []
        for leading in range(len(plate.notches)):
            (in_y, in_z), image = min(symmetries, key=lambda entry: entry[1][leading])
            self.reference.append(image[leading])
            self.turns.append(Turn(in_y, in_z, tuple(image.index(notch) for notch in range(len(image)))))
        self._mirror = [self._image_of_section(section) for section in sections]

    def _image(self, notch: Notch, in_y: bool, in_z: bool) -> int:
        """The notch that a reflection maps `notch` on, or -1."""
        _, width, length = self.plate.size
        along_z = notch.face.startswith("y")
        face = OPPOSITE[notch.face] if (in_y if along_z else in_z) else notch.face
        at = (length if along_z else width) - notch.at if (in_z if along_z else in_y) else notch.at
        for number, other in enumerate(self.plate.notches):
            apart = max(abs(other.at - at), abs(other.depth - notch.depth), abs(other.height - notch.height))
            if other.face == face and apart <= self._near:
                return number
        return -1

    def _image_of_section(self, section: CrossSection) -> int:
        """The number of the section that a reflection across this one's axis maps it on, or -1."""
        for number, other in enumerate(self.sections):
            if other.axis == section.axis and \
                    abs(self.plate.size[section.axis] - section.position - other.position) <= self._near:
                return number
        return -1

    def _sources(self, turn: Turn) -> np.ndarray:
        """Of each section the one of the turned sample that lies there, or -1."""
        return np.array([self._mirror[k] if turn.reflects(section.axis) else k
                         for k, section in enumerate(self.sections)], int)

    def rows(self, group: str) -> tuple[np.ndarray, np.ndarray]:
        """Reference notch and notch of the rows of /statistics/`group`."""
        pairs = [(leading, notch) for leading in sorted(set(self.reference)) for notch in range(len(self.reference))
                 if (notch == leading) == group.startswith("leader")]
        return np.array([pair[0] for pair in pairs], int), np.array([pair[1] for pair in pairs], int)

    def ranked(self, values: np.ndarray, leading: np.ndarray, group: str,
               are_positions: bool = False) -> tuple[np.ndarray, np.ndarray]:
        """Values of samples x notches x sections as samples x rows x sections of a group, and where a sample counts.

        are_positions: they are coordinates along the sections, which a reflection in these changes.
        """
        of_class, of_notch = self.rows(group)
        along = [3 - section.axis for section in self.sections]
        extent = np.array([self.plate.size[axis] for axis in along])
        shape = (len(values), len(of_notch), values.shape[2])
        result, counts = np.full(shape, np.nan), np.zeros(shape, bool)
        for i, leader in enumerate(leading):
            if leader < 0:
                continue
            turn = self.turns[leader]
            source = self._sources(turn)
            is_reflected = np.array([turn.reflects(axis) for axis in along], bool) & are_positions
            for row in np.flatnonzero(of_class == self.reference[leader]):
                found = np.where(source >= 0, values[i, turn.notch[of_notch[row]], source], np.nan)
                result[i, row] = np.where(is_reflected, extent - found, found)
                counts[i, row] = source >= 0
        return result, counts

    def turned(self, points: np.ndarray, leading: int) -> np.ndarray:
        """Points y, z of a sample in the frame."""
        turn = self.turns[leading]
        size = np.array(self.plate.size[1:])
        return np.where([turn.reflects_y, turn.reflects_z], size - points, points)

    def row_of(self, group: str, leading: int, notch: int) -> Optional[int]:
        """The row of /statistics/`group` that the crack of `notch` counts in; None for one of another rank."""
        of_class, of_notch = self.rows(group)
        image = self.turns[leading].notch.index(notch)
        rows = np.flatnonzero((of_class == self.reference[leading]) & (of_notch == image))
        return int(rows[0]) if rows.size else None


def make_ranks(frame: LeaderFrame, samples: Samples, leading: np.ndarray, confidence: float,
               n_looks: int) -> dict[str, Ranks]:
    """The statistics by rank, by the names of their groups."""
    found = {}
    for group in GROUPS:
        shown = np.where(samples.status == DONE, leading, -1)
        if group in PATTERNS:
            shown = np.where(samples.pattern == PATTERNS[group], shown, -1)
        position, counts = frame.ranked(samples.position, shown, group, are_positions=True)
        of_class, of_notch = frame.rows(group)
        found[group] = Ranks(**path_statistics(position, confidence, n_looks), leading_notch=of_class, notch=of_notch,
                             counted=counts.sum(axis=0))
    return found


def leading_from_crossings(plate: Plate, sections: tuple[CrossSection, ...], position: np.ndarray) -> int:
    """The notch whose crack arrives at a section at least as far across its ligament as the next section at which any
    other notch's is missing; -1 where that is open. position: notches x sections.
    """
    arrived, missing = [], []
    for number, notch in enumerate(plate.notches):
        axis = 1 if notch.face.startswith("y") else 2
        tip, extent = plate.tip(number)[axis - 1], plate.size[axis]
        chosen = [k for k, section in enumerate(sections) if section.axis == axis]
        at = np.array([sections[k].position for k in chosen])
        share = (at - tip if notch.face.endswith("min") else tip - at) / (extent - notch.depth)
        arrived.append(max([0.0, *share[np.isfinite(position[number, chosen])]]))
        missing.append(min([1.0, *share[share > arrived[-1]]]))
    for number, own in enumerate(arrived):
        if own > 0 and all(own >= other - ROUNDING for k, other in enumerate(missing) if k != number):
            return number
    return -1


def derived_leading(plate: Plate, sections: tuple[CrossSection, ...], samples: Samples) -> np.ndarray:
    """The leading notch of each sample of a file that does not hold it."""
    return np.array([leading_from_crossings(plate, sections, position) if pattern != 0 else -1
                     for position, pattern in zip(samples.position, samples.pattern)], int)
