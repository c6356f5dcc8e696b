# SPDX-License-Identifier: GPL-3.0-or-later
"""Leguillon's coupled criterion for the plate with a slot: a crack of finite length starts at the load at which, along all of
it, the stress is at least the strength, and at which it sets free at least the toughness for each unit of its area
(D. Leguillon, Strength or toughness? A criterion for crack onset at a notch, Eur. J. Mech. A 21, 2002).

Stress and energy come from plane-strain bilinear elements on a grid, which share nothing with the program.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import linalg


@dataclass(frozen=True)
class Plate:
    """A plate of unit thickness held at z = 0 and pulled at z = height, with a slot from y = 0 half-way up. All in SI units."""

    width: float
    height: float
    depth: float  # of the slot
    slot_height: float
    youngs_modulus: float
    poisson_ratio: float
    element: float = 25e-6  # near the slot's end
    reach: float = 1.5e-3  # up to which cracks from the slot's end are followed


def _graded(fine_from: float, fine_to: float, end: float, element: float) -> np.ndarray:
    """Lines from fine_from to fine_to, an element apart, then ever farther apart to the end."""
    n = max(1, round((fine_to - fine_from) / element))
    lines = list(np.linspace(fine_from, fine_to, n + 1))
    steps = [element]
    while sum(steps) < abs(end - fine_to):
        steps.append(1.15 * steps[-1])
    steps = np.array(steps) * (end - fine_to) / sum(steps)
    return np.array([*lines, *(fine_to + np.cumsum(steps))])


def _plane_strain(young: float, nu: float) -> np.ndarray:
    factor = young / ((1 + nu) * (1 - 2 * nu))
    return factor * np.array([[1 - nu, nu, 0], [nu, 1 - nu, 0], [0, 0, 0.5 - nu]])


class _Grid:
    def __init__(self, plate: Plate):
        self.plate = plate
        end = plate.depth
        ahead = _graded(end, end + plate.reach, plate.width, plate.element)
        behind = _graded(end, end, 0, plate.element)
        self.y = np.unique(np.concatenate([behind, ahead]).round(12))
        middle, half = 0.5 * plate.height, 0.5 * plate.slot_height
        n_half = max(1, round(half / plate.element))
        inside = half * np.arange(n_half + 1) / n_half
        upper = np.concatenate([inside, _graded(half, half + plate.reach, middle, plate.element)])
        self.z = np.unique(np.concatenate([middle + upper, middle - upper]).round(12))
        j, i = np.meshgrid(np.arange(self.z.size - 1), np.arange(self.y.size - 1), indexing="ij")
        centre_y, centre_z = 0.5 * (self.y[i] + self.y[i + 1]), 0.5 * (self.z[j] + self.z[j + 1])
        solid = ~((centre_y < end) & (np.abs(centre_z - middle) < half))
        self.i, self.j = i[solid], j[solid]

    def corners(self, crack: float, line: int) -> np.ndarray:
        """Nodes of each element, counterclockwise; those of the crack's upper face have numbers of their own.

        @param line along which the crack runs from the slot's end, of self.z
        """
        n_y = self.y.size
        nodes = np.stack([self.j * n_y + self.i, self.j * n_y + self.i + 1, (self.j + 1) * n_y + self.i + 1,
                          (self.j + 1) * n_y + self.i], axis=1)
        tip = self.plate.depth + crack
        opened = np.flatnonzero((self.y >= self.plate.depth - 1e-9) & (self.y < tip - 1e-9))
        copies = {line * n_y + int(at): n_y * self.z.size + k for k, at in enumerate(opened)}
        above = self.j == line
        for node, copy in copies.items():
            for corner in (0, 1):
                nodes[above & (nodes[:, corner] == node), corner] = copy
        return nodes

    def line(self, z: float) -> int:
        return int(np.argmin(np.abs(self.z - z)))


def _strain_matrices(grid: _Grid) -> list[np.ndarray]:
    """Strain (yy, zz, 2 yz) over corner displacements at the four Gauss points and at the centre; n x 3 x 8 each."""
    dy, dz = np.diff(grid.y)[grid.i], np.diff(grid.z)[grid.j]
    at = 0.5 / np.sqrt(3)
    found = []
    for s, t in ((-at, -at), (at, -at), (at, at), (-at, at), (0, 0)):
        slope_y = np.array([-(0.5 - t), 0.5 - t, 0.5 + t, -(0.5 + t)])
        slope_z = np.array([-(0.5 - s), -(0.5 + s), 0.5 + s, 0.5 - s])
        matrix = np.zeros((dy.size, 3, 8))
        matrix[:, 0, 0::2] = slope_y / dy[:, None]
        matrix[:, 1, 1::2] = slope_z / dz[:, None]
        matrix[:, 2, 0::2] = slope_z / dz[:, None]
        matrix[:, 2, 1::2] = slope_y / dy[:, None]
        found.append(matrix)
    return found


def _solve(grid: _Grid, crack: float, line: int) -> tuple[float, np.ndarray]:
    """Compliance under a unit force for each unit of thickness [m^2/N], and the stress zz at the elements' centres [1/m]."""
    plate = grid.plate
    stiffness = _plane_strain(plate.youngs_modulus, plate.poisson_ratio)
    nodes = grid.corners(crack, line)
    *gauss, centre = _strain_matrices(grid)
    quarter = 0.25 * np.diff(grid.y)[grid.i] * np.diff(grid.z)[grid.j]
    element = sum(np.einsum("n,nai,ab,nbj->nij", quarter, b, stiffness, b, optimize=True) for b in gauss)
    freedom = np.stack([2 * nodes, 2 * nodes + 1], axis=2).reshape(-1, 8)
    size = int(freedom.max()) + 1
    row, column = np.repeat(freedom, 8, axis=1).ravel(), np.tile(freedom, (1, 8)).ravel()
    matrix = sparse.csc_matrix((element.ravel(), (row, column)), shape=(size, size))
    force = np.zeros(size)
    top = (grid.z.size - 1) * grid.y.size + np.arange(grid.y.size)
    share = np.diff(grid.y) / plate.width
    force[2 * top[:-1] + 1] += 0.5 * share
    force[2 * top[1:] + 1] += 0.5 * share
    held = np.zeros(size, bool)
    held[:2 * grid.y.size] = True
    free = np.flatnonzero(~held & (matrix.diagonal() > 0))  # nodes inside the slot carry nothing
    moved = np.zeros(size)
    moved[free] = linalg.spsolve(matrix[free][:, free], force[free])
    stress = np.einsum("b,nbi,ni->n", stiffness[1], centre, moved[freedom], optimize=True)
    return float(force @ moved), stress


@dataclass(frozen=True)
class Start:
    """Where a crack may start: what each unit of load for each unit of thickness does to it, over its length."""

    length: np.ndarray  # [m]
    stress: np.ndarray  # at that distance ahead of the slot [1/m]
    energy: np.ndarray  # set free for each unit of its area [m/N]


def start(plate: Plate, at: float, lengths: np.ndarray) -> Start:
    """A crack that runs straight ahead from the slot's end.

    @param at its height over the slot's middle [m]; half the slot's height is the corner
    @param lengths multiples of the element [m]
    """
    grid = _Grid(plate)
    line = grid.line(0.5 * plate.height + at)
    intact, stress = _solve(grid, 0, line)
    # Mean of the elements below and above the line.
    below, above = (stress[(grid.j == j) & (grid.y[grid.i] >= plate.depth - 1e-9)] for j in (line - 1, line))
    centres = (0.5 * (grid.y[1:] + grid.y[:-1]) - plate.depth)[-above.size:]
    energy = [0.5 * (_solve(grid, length, line)[0] - intact) / length for length in lengths]
    return Start(lengths, np.interp(lengths, centres, 0.5 * (below + above)), np.array(energy))


def load(where: Start, strength: float, toughness: float) -> tuple[float, float]:
    """Load for each unit of thickness [N/m] at which the crack starts, and its length [m]."""
    by_stress, by_energy = strength / where.stress, np.sqrt(toughness / where.energy)
    fine = np.geomspace(where.length[0], where.length[-1], 2000)
    needed = np.maximum(np.exp(np.interp(np.log(fine), np.log(where.length), np.log(by_stress))),
                        np.exp(np.interp(np.log(fine), np.log(where.length), np.log(by_energy))))
    best = int(needed.argmin())
    return float(needed[best]), float(fine[best])
