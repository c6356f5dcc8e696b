# SPDX-License-Identifier: GPL-3.0-or-later
"""The body, as the program's files and `crackle stats --json` describe it: a plate in the YZ plane, or the edges of a solid."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Mapping

import numpy as np
from crackle.units import MM, Unit, fitting


@dataclass(frozen=True)
class Plate:
    """The members of /specimen [m]; of a plate x is the thickness, y the width, z the length."""

    size: np.ndarray
    outline: np.ndarray  # n x 2 (y, z): corners of polygons
    outline_first: np.ndarray  # of each polygon, and one past the last of all
    notch_tip: np.ndarray  # notches x 2 (y, z)
    notch_slot: np.ndarray  # notches x 2 (y, z) x 2 (least, greatest)
    notch_axis: np.ndarray  # along which the crack advances: 1 y, 2 z; 0 in any direction
    notch_direction: np.ndarray  # in which it does: 1 or -1; 0 in any
    notch_name: np.ndarray = field(default_factory=lambda: np.empty(0, object))  # older files have none
    pre_crack: np.ndarray = field(default_factory=lambda: np.empty((0, 2)))  # corners of borders of pre-cracks
    pre_crack_first: np.ndarray = field(default_factory=lambda: np.zeros(1, int))  # as outline_first
    edge: np.ndarray = field(default_factory=lambda: np.empty((0, 2, 3)))  # of a body that is no plate: n x 2 ends x 3

    @classmethod
    def of(cls, members: Mapping[str, Any]) -> "Plate":
        """From the group /specimen of a file, or the member "specimen" of the JSON document."""
        shapes = {"notch_tip": (-1, 2), "notch_slot": (-1, 2, 2)}  # also of none
        return cls(**{name: np.asarray(members[name]).reshape(shapes.get(name, np.shape(members[name])))
                      for name in cls.__dataclass_fields__ if name in members})

    def name_of(self, notch: int) -> str:
        """For people: "notch 0", "hole 1" or "free surface"."""
        if not len(self.notch_name):
            return f"notch {notch}"
        name = self.notch_name[notch]
        return (name.decode() if isinstance(name, bytes) else name).replace("-", " ")

    @property
    def is_solid(self) -> bool:
        """A body of any shape, whose cracks are not followed in a plane."""
        return not self.outline.size

    @property
    def lengths(self) -> Unit:
        """In which people see the body's sizes and positions."""
        return fitting(self.size, MM, least=1, most=1e4)

    @property
    def polygons(self) -> list[np.ndarray]:
        return np.split(self.outline, self.outline_first[1:-1])

    @property
    def pre_cracks(self) -> list[np.ndarray]:
        """Their borders, the first corner again at the end."""
        borders = np.split(self.pre_crack, self.pre_crack_first[1:-1]) if len(self.pre_crack) else []
        return [np.vstack([border, border[:1]]) for border in borders]

    def ends(self, axis: int) -> tuple[float, float]:
        """Least and greatest y (axis 1) or z (2) of the body."""
        values = self.edge[..., axis] if self.is_solid else self.outline[:, axis - 1]
        return float(values.min()), float(values.max())

    @property
    def slot_ends(self) -> list[float]:
        """Lowest and highest z of all slots, lowest of a slot first."""
        return self.notch_slot[:, 1].ravel().tolist()
