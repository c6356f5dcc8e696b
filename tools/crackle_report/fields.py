# SPDX-License-Identifier: GPL-3.0-or-later
"""What a sample's file holds, in SI units; `sample_files` fills them."""
from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from typing import Optional

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation, Slerp


@dataclass(frozen=True)
class CrackSurface:
    """The opened dual facets of one sample, in order of breaking."""

    corner: np.ndarray  # facets x 4 x 3 [m]
    time: np.ndarray  # facets; since the onset of the last dynamic phase, negative before it [s]
    notch: np.ndarray  # facets; the notch that the facet's crack started at, or -1
    tetrahedron: np.ndarray  # facets; the one that the facet lies in
    phase_end: float  # of the last dynamic phase, since its onset [s]

    @property
    def last_opening(self) -> float:
        """When the last facet opened in the last dynamic phase, since its onset [s]: slow loading may open others minutes later."""
        return float(self.time[self.time <= (1 + 1e-9) * self.phase_end].max(initial=0.0))


@dataclass(frozen=True)
class Places:
    """Where a sample broke."""

    first: np.ndarray  # x, y, z: middle of the tetrahedron that broke first [m]
    first_time: float  # of that break, of the loads' programs [s]
    largest: np.ndarray  # x, y, z: middle of the largest crack [m]; NaN where none has opened
    largest_area: float  # [m^2]
    largest_start: float  # when it began, since the onset of the last dynamic phase [s]; negative before it


@dataclass(frozen=True)
class CrackLine:
    """A crack as a line in the YZ plane: the mean of its surface over the thickness."""

    notch: int
    is_branch: bool
    points: np.ndarray  # n x 2: y, z [m]


@dataclass(frozen=True)
class BranchingPoints:
    """Where one crack becomes two branches, of one sample."""

    position: np.ndarray  # n x 2: y, z where the gap between the branches begins [m]
    x: np.ndarray  # middle of the range through the thickness [m]
    time: np.ndarray  # when the later branch opened, since onset [s]
    length: np.ndarray  # of the secondary branch [m]
    angle: np.ndarray  # between the branches [rad]
    share: np.ndarray  # of the thickness that the secondary branch spans
    notch: np.ndarray
    in_projection: np.ndarray  # 0 or 1
    in_space: np.ndarray  # 0 or 1


@dataclass(frozen=True)
class FragmentHistory:
    """The number of a sample's fragments over the last dynamic phase."""

    time: np.ndarray  # since its onset [s]
    number: np.ndarray  # without dust


@dataclass(frozen=True)
class Tool:
    """A rigid tool over the last dynamic phase."""

    shape: str  # as in the input
    axis: np.ndarray  # x, y, z, of any length; 0 of a sphere or box
    radius: float  # [m]
    size: np.ndarray  # edges of a box, or the length of a cylinder that has one [m]
    time: np.ndarray  # since the onset [s]
    position: np.ndarray  # n x 3 [m]
    at: np.ndarray = field(default_factory=lambda: np.zeros(3))  # at the start of the sample [m]
    rounding: float = 0.0  # of edges [m]
    orientation: Optional[np.ndarray] = None  # n x 4, quaternions w, x, y, z from the start of the sample

    def moved(self, points: np.ndarray, time: float) -> np.ndarray:
        """Where points of the tool at the start of the sample are (n x 3) [m]."""
        place = np.array([np.interp(time, self.time, self.position[:, axis]) for axis in range(3)])
        return place + self._turned(points - self.at, time)

    def _turned(self, ways: np.ndarray, time: float) -> np.ndarray:
        if self.orientation is None:
            return ways
        turns = Rotation.from_quat(np.roll(self.orientation, -1, axis=1))
        after = min(int(np.searchsorted(self.time, time)), len(self.time) - 1)
        before = max(after - 1, 0)
        if not self.time[before] < time < self.time[after]:
            return turns[after].apply(ways)
        return Slerp(self.time[[before, after]], turns[[before, after]])(time).apply(ways)

    def outline(self, time: float) -> np.ndarray:
        """Corners of its projection along x, y and z [m]; a line of a plane, none of one across x."""
        place = self.moved(self.at, time)[1:]
        along = self.axis[1:]
        is_across = np.hypot(*along) > 1e-6 * np.linalg.norm(self.axis) if self.axis.any() else False
        if self.shape == "box" or (self.shape == "cylinder" and self.size.size):
            seen = place + self._turned(self._ends(), time)[:, 1:]
            return seen[ConvexHull(seen).vertices]
        if self.shape == "plane" or is_across:
            if not is_across:
                return np.empty((0, 2))
            along = along / np.hypot(*along)
            beside = np.array([-along[1], along[0]])
            if self.shape == "plane":
                return place + np.array([(-1.0,), (1.0,)]) * beside  # a metre to each side
            return place + np.array([a * along + b * self.radius * beside for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
        turn = np.linspace(0, 2 * np.pi, 73)[:-1]
        return place + self.radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)

    def _ends(self) -> np.ndarray:
        """From the middle at the start, the corners of a box or the rims of a cylinder (n x 3) [m]."""
        if self.shape == "box":
            return np.array(list(itertools.product((-0.5, 0.5), repeat=3))) * self.size
        first, second, along = axes_around(self.axis)
        turn = np.linspace(0, 2 * np.pi, 73)[:-1, None]
        rim = self.radius * (np.cos(turn) * first + np.sin(turn) * second)
        return np.concatenate([rim + end * self.size[0] / 2 * along for end in (-1, 1)])


def axes_around(axis: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit vectors across an axis, and along it; right-handed."""
    along = axis / np.linalg.norm(axis)
    first = np.cross(along, np.eye(3)[np.argmin(np.abs(along))])
    first /= np.linalg.norm(first)
    return first, np.cross(along, first), along


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
class History:
    """Moments of a whole sample: equilibria of quasi-static loading and outputs of its dynamic phases."""

    time: np.ndarray  # of the loads' programs [s]
    phase: np.ndarray  # number of the dynamic phase; 0 in quasi-static loading
    phase_time: np.ndarray  # since the start of the dynamic phase [s]
    governing_load: np.ndarray  # of the testing machine, along its drive [N]
    governing_displacement: np.ndarray  # likewise [m]
    crack_area: np.ndarray  # moments x crack starts [m^2]
    crack_length: np.ndarray  # likewise [m]
    tip_speed: np.ndarray  # likewise [m/s]; NaN where no tip runs
    tip_speed_ratio: np.ndarray  # likewise; to the Rayleigh speed where it runs
    energy_release_rate: np.ndarray  # likewise [J/m^2]
    rayleigh_speed: float  # mean where cracks ran [m/s]

    @property
    def in_last_phase(self) -> np.ndarray:
        """Which moments are of the last dynamic phase."""
        return (self.phase == self.phase.max(initial=0)) & (self.phase > 0)


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
    released: list[np.ndarray]  # the edges that each of them has released by then, as bits in the order of mesh.EDGES
    remaining: list[np.ndarray]  # the share of its stiffness that each of them still has, while it is released over some time
    stiffness: list[np.ndarray]  # m for each frame, the share that softening has left; 1 without softening
    has_contact: bool  # whether broken tetrahedra resist being closed again
    youngs_modulus: np.ndarray  # m [Pa]
    poisson_ratio: np.ndarray  # m
    material: np.ndarray  # m, numbers; 0 if there is one
    fragment: np.ndarray  # n, the fragment of each node at the end; -1: dust; of no node where it is not known
    initial_strain: np.ndarray  # m x 6, at which each tetrahedron is free of stress, in the order of stress.element_stress
