# SPDX-License-Identifier: GPL-3.0-or-later
"""The slotted plate in plane strain, on a grid of bilinear elements that shares nothing with the program: what a crack from
the slot's end needs by Leguillon's coupled criterion, and by a cohesive zone.

The crack runs straight ahead, from a given height of the slot's end.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import linalg


@dataclass(frozen=True)
class Plate:
    """A plate of unit thickness held at z = 0 and pulled at z = height, with a slot from y = 0 half-way up; in SI units."""

    width: float
    height: float
    depth: float  # of the slot
    slot_height: float
    youngs_modulus: float
    poisson_ratio: float
    element: float = 25e-6  # near the slot's end
    reach: float = 1.5e-3  # up to which cracks from the slot's end are followed


class Grid:
    """The plate's elements, and their answer to a unit force for each unit of thickness."""

    def __init__(self, plate: Plate):
        self.plate = plate
        end, middle, half = plate.depth, 0.5 * plate.height, 0.5 * plate.slot_height
        self.y = np.unique(np.concatenate([_graded(end, end, 0, plate.element),
                                           _graded(end, end + plate.reach, plate.width, plate.element)]).round(12))
        n_half = max(1, round(half / plate.element))
        upper = np.concatenate([half * np.arange(n_half + 1) / n_half,
                                _graded(half, half + plate.reach, middle, plate.element)])
        self.z = np.unique(np.concatenate([middle + upper, middle - upper]).round(12))
        j, i = np.meshgrid(np.arange(self.z.size - 1), np.arange(self.y.size - 1), indexing="ij")
        solid = ~((0.5 * (self.y[i] + self.y[i + 1]) < end)
                  & (np.abs(0.5 * (self.z[j] + self.z[j + 1]) - middle) < half))
        self.i, self.j = i[solid], j[solid]
        factor = plate.youngs_modulus / ((1 + plate.poisson_ratio) * (1 - 2 * plate.poisson_ratio))
        nu = plate.poisson_ratio
        self.stiffness = factor * np.array([[1 - nu, nu, 0], [nu, 1 - nu, 0], [0, 0, 0.5 - nu]])

    def line(self, at: float) -> int:
        """Of self.z, the one at a height over the slot's middle."""
        return int(np.argmin(np.abs(self.z - 0.5 * self.plate.height - at)))

    def crack_nodes(self, crack: float, line: int) -> tuple[np.ndarray, np.ndarray]:
        """Nodes of a crack's lower face, and of its upper one."""
        opened = np.flatnonzero((self.y >= self.plate.depth - 1e-9) & (self.y < self.plate.depth + crack - 1e-9))
        return line * self.y.size + opened, self.y.size * self.z.size + np.arange(opened.size)

    def freedoms(self, crack: float, line: int) -> np.ndarray:
        """Of each element's corners, counterclockwise; n x 8."""
        n_y = self.y.size
        first = self.j * n_y + self.i
        nodes = np.stack([first, first + 1, first + n_y + 1, first + n_y], axis=1)
        above = self.j == line
        for lower, upper in zip(*self.crack_nodes(crack, line)):
            for corner in (0, 1):
                nodes[above & (nodes[:, corner] == lower), corner] = upper
        return np.stack([2 * nodes, 2 * nodes + 1], axis=2).reshape(-1, 8)

    def strains(self, s: float, t: float) -> np.ndarray:
        """Strain (yy, zz, 2 yz) over the corners' displacements at a place of each element; n x 3 x 8."""
        dy, dz = np.diff(self.y)[self.i], np.diff(self.z)[self.j]
        matrix = np.zeros((dy.size, 3, 8))
        matrix[:, 0, 0::2] = matrix[:, 2, 1::2] = np.array([t - 0.5, 0.5 - t, 0.5 + t, -0.5 - t]) / dy[:, None]
        matrix[:, 1, 1::2] = matrix[:, 2, 0::2] = np.array([s - 0.5, -0.5 - s, 0.5 + s, 0.5 - s]) / dz[:, None]
        return matrix

    def stiffness_matrix(self, freedoms: np.ndarray) -> sparse.csc_matrix:
        quarter = 0.25 * np.diff(self.y)[self.i] * np.diff(self.z)[self.j]
        at = 0.5 / np.sqrt(3)
        element = 0
        for place in ((-at, -at), (at, -at), (at, at), (-at, at)):
            strain = self.strains(*place)
            element = element + np.einsum("n,nai,ab,nbj->nij", quarter, strain, self.stiffness, strain, optimize=True)
        row, column = np.repeat(freedoms, 8, axis=1).ravel(), np.tile(freedoms, (1, 8)).ravel()
        size = int(freedoms.max()) + 1
        return sparse.csc_matrix((element.ravel(), (row, column)), shape=(size, size))

    def pull(self, size: int) -> np.ndarray:
        force = np.zeros(size)
        top = (self.z.size - 1) * self.y.size + np.arange(self.y.size)
        share = 0.5 * np.diff(self.y) / self.plate.width
        np.add.at(force, 2 * top[:-1] + 1, share)
        np.add.at(force, 2 * top[1:] + 1, share)
        return force

    def solver(self, matrix: sparse.csc_matrix):
        """From forces to displacements."""
        held = np.zeros(matrix.shape[0], bool)
        held[:2 * self.y.size] = True
        free = np.flatnonzero(~held & (matrix.diagonal() > 0))  # nodes inside the slot carry nothing
        factors = linalg.splu(matrix[free][:, free].tocsc())

        def solve(force: np.ndarray) -> np.ndarray:
            moved = np.zeros(force.size)
            moved[free] = factors.solve(force[free])
            return moved
        return solve

    def compliance_and_stress(self, crack: float, line: int) -> tuple[float, np.ndarray]:
        """Work of the force over half its square [m^2/N], and the stress zz at the elements' centres [1/m]."""
        freedoms = self.freedoms(crack, line)
        matrix = self.stiffness_matrix(freedoms)
        force = self.pull(matrix.shape[0])
        moved = self.solver(matrix)(force)
        stress = np.einsum("b,nbi,ni->n", self.stiffness[1], self.strains(0, 0), moved[freedoms], optimize=True)
        return float(force @ moved), stress


def _graded(fine_from: float, fine_to: float, end: float, element: float) -> np.ndarray:
    """Lines an element apart, then ever farther apart to the end."""
    n = max(1, round((fine_to - fine_from) / element))
    steps = [element]
    while sum(steps) < abs(end - fine_to):
        steps.append(1.15 * steps[-1])
    scaled = np.array(steps) * (end - fine_to) / sum(steps)
    return np.array([*np.linspace(fine_from, fine_to, n + 1), *(fine_to + np.cumsum(scaled))])


def energy_release(plate: Plate, at: float, lengths: np.ndarray) -> np.ndarray:
    """What a crack of each length sets free for each unit of its area, under a unit force for each unit of thickness [m/N].

    @param at the crack's height over the slot's middle [m]; half the slot's height is the corner
    @param lengths multiples of the element [m]
    """
    grid = Grid(plate)
    intact, _ = grid.compliance_and_stress(0, grid.line(at))
    return np.array([0.5 * (grid.compliance_and_stress(length, grid.line(at))[0] - intact) / length for length in lengths])


def coupled_load(plate: Plate, at: float, strength: float, toughness: float) -> float:
    """Load for each unit of thickness at which the stress is at least the strength all along a crack that sets free at least
    the toughness for each unit of its area [N/m] (D. Leguillon, Strength or toughness? A criterion for crack onset at a
    notch, European Journal of Mechanics A 21, 2002).
    """
    lengths = plate.element * np.unique(np.geomspace(2, 0.8 * plate.reach / plate.element, 12).round())
    grid = Grid(plate)
    line = grid.line(at)
    _, stress = grid.compliance_and_stress(0, line)
    ahead = grid.y[grid.i] >= plate.depth - 1e-9
    below, above = (stress[ahead & (grid.j == j)] for j in (line - 1, line))
    distance = (0.5 * (grid.y[1:] + grid.y[:-1]) - plate.depth)[-above.size:]
    by_stress = strength / np.interp(lengths, distance, 0.5 * (below + above))
    by_energy = np.sqrt(toughness / energy_release(plate, at, lengths))
    fine = np.log(np.geomspace(lengths[0], lengths[-1], 2000))
    return float(np.exp(np.maximum(*(np.interp(fine, np.log(lengths), np.log(load)) for load in (by_stress, by_energy)))).min())


def cohesive_load(plate: Plate, at: float, strength: float, toughness: float) -> float:
    """Largest load for each unit of thickness [N/m] while a cohesive zone grows whose stress falls linearly with the opening
    (A. Hillerborg, M. Modeer, P.-E. Petersson, Cement and Concrete Research 6, 1976). Its faces do not slide.
    """
    grid = Grid(plate)
    line = grid.line(at)
    matrix = grid.stiffness_matrix(grid.freedoms(plate.reach, line))
    lower, upper = grid.crack_nodes(plate.reach, line)
    y = np.concatenate([2 * lower, 2 * upper])
    other = np.concatenate([2 * upper, 2 * lower])
    tie = np.full(y.size, 1e3 * plate.youngs_modulus)
    matrix = matrix + sparse.csc_matrix((np.concatenate([tie, -tie]), (np.tile(y, 2), np.concatenate([y, other]))),
                                        shape=matrix.shape)
    solve = grid.solver(matrix)

    def opening(force: np.ndarray) -> np.ndarray:
        moved = solve(force)
        return moved[2 * upper + 1] - moved[2 * lower + 1]
    by_load = opening(grid.pull(matrix.shape[0]))
    n = lower.size
    by_traction = np.zeros((n, n))
    for k in range(n):
        pair = np.zeros(matrix.shape[0])
        pair[2 * upper[k] + 1], pair[2 * lower[k] + 1] = 1, -1
        by_traction[:, k] = opening(pair)
    places = grid.y[lower % grid.y.size]
    force_at_strength = strength * np.gradient(places)
    force_at_strength[0] /= 2
    return max(_load_at_front(k, by_load, by_traction, force_at_strength, 2 * toughness / strength)
               for k in range(1, int(0.8 * n)))


def _load_at_front(k: int, by_load: np.ndarray, by_traction: np.ndarray, force_at_strength: np.ndarray, critical: float) -> float:
    """Load at which node k reaches the strength when those before it have softened.

    @param critical opening without stress
    """
    n = by_load.size
    is_open = np.zeros(k, bool)
    while True:
        # Unknown: the forces that close the line, the openings of the first k nodes, the load.
        matrix, right = np.zeros((n + k + 1, n + k + 1)), np.zeros(n + k + 1)
        matrix[:n, :n] = by_traction
        matrix[:k, n:n + k] = np.eye(k)
        matrix[:n, -1] = -by_load
        matrix[n:n + k, :k] = np.eye(k)
        holding = np.where(is_open, 0, force_at_strength[:k])
        matrix[n:n + k, n:n + k] = np.diag(holding / critical)
        right[n:n + k] = holding
        matrix[-1, k], right[-1] = 1, force_at_strength[k]
        solution = np.linalg.solve(matrix, right)
        found = is_open | (solution[n:n + k] > critical)
        if (found == is_open).all():
            return float(solution[-1])
        is_open = found
