# SPDX-License-Identifier: GPL-3.0-or-later
"""The stress of a sample's tetrahedra, by the program's rules: see src/mechanics/residual_stiffness.h."""
from __future__ import annotations

import numpy as np

from .mesh import EDGES, field_gradient, gradients
from .fields import Frames

ALL_EDGES = (1 << len(EDGES)) - 1
# The corners on one side of each of the seven cuts.
CUTS = ((0,), (1,), (2,), (3,), (0, 1), (0, 2), (0, 3))
# The edges that each cut crosses, as bits in the order of EDGES.
CROSSED_EDGES = np.array([sum(1 << k for k, (a, b) in enumerate(EDGES) if (a in cut) != (b in cut)) for cut in CUTS],
                         np.uint8)


def element_stress(nodes: np.ndarray, tetrahedra: np.ndarray, displacement: np.ndarray, youngs_modulus: np.ndarray,
                   poisson_ratio: np.ndarray) -> np.ndarray:
    """Stress of intact linear tetrahedra, m x 6 in the order xx, yy, zz, yz, xz, xy [Pa]."""
    strain = _strain(nodes[tetrahedra], displacement[tetrahedra])
    return _components(_elastic_stress(strain, youngs_modulus, poisson_ratio))


def frame_stress(frames: Frames, k: int) -> np.ndarray:
    """The stress at frame k in the form of element_stress; of softened and broken tetrahedra what they still carry."""
    young, poisson = frames.youngs_modulus, frames.poisson_ratio
    broken, released = frames.broken[k], frames.released[k]
    elastic = _strain(frames.nodes[frames.tetrahedra], frames.displacement[k][frames.tetrahedra]) - _tensor(frames.initial_strain)
    stress = _components(_elastic_stress(elastic, young, poisson))
    stress *= frames.stiffness[k][:, None]
    corner, strain = frames.nodes[frames.tetrahedra[broken]], elastic[broken]
    carried = np.zeros_like(strain)
    partial = released != ALL_EDGES
    carried[partial] = _edge_stress(corner[partial], strain[partial], released[partial], young[broken][partial],
                                   poisson[broken][partial])
    if frames.has_contact:
        is_apart = _longest(frames.displacement[k][frames.tetrahedra[broken]]) > _longest(corner)
        carried += np.where(is_apart[:, None, None], 0, _contact_stress(corner, strain, frames.cut[k], young[broken]))
    share = frames.remaining[k][:, None]
    stress[broken] = share * stress[broken] + (1 - share) * _components(carried)
    return stress


def frame_stresses(frames: Frames) -> list[np.ndarray]:
    """frame_stress at each of a sample's frames."""
    return [frame_stress(frames, k) for k in range(len(frames.time))]


def _components(tensor: np.ndarray) -> np.ndarray:
    return tensor[:, (0, 1, 2, 1, 0, 0), (0, 1, 2, 2, 2, 1)]


def _tensor(components: np.ndarray) -> np.ndarray:
    return components[:, ((0, 5, 4), (5, 1, 3), (4, 3, 2))]


def _strain(corner: np.ndarray, displacement: np.ndarray) -> np.ndarray:
    """m x 3 x 3, from positions and displacements of the corners, m x 4 x 3."""
    gradient = field_gradient(corner, displacement)
    return (gradient + gradient.transpose(0, 2, 1)) / 2


def _elastic_stress(strain: np.ndarray, youngs_modulus: np.ndarray, poisson_ratio: np.ndarray) -> np.ndarray:
    """Of strains m x ... x 3 x 3, with m moduli and ratios."""
    youngs_modulus, poisson_ratio = (np.reshape(value, (-1, *[1] * (strain.ndim - 1))) for value in (youngs_modulus, poisson_ratio))
    shear = youngs_modulus / (2 * (1 + poisson_ratio))
    first = youngs_modulus * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))
    trace = np.trace(strain, axis1=-2, axis2=-1)[..., None, None]
    return 2 * shear * strain + first * trace * np.eye(3)


def _edge_stress(corner: np.ndarray, strain: np.ndarray, released: np.ndarray, youngs_modulus: np.ndarray,
                 poisson_ratio: np.ndarray) -> np.ndarray:
    """What tetrahedra carry by the edges that are not released, m x 3 x 3."""
    first, second = np.array(EDGES).T
    gradient = gradients(corner)
    # The strains in which only one edge is stretched, and the intact stiffness between them.
    product = gradient[:, first, :, None] * gradient[:, second, None, :]
    stretch = -(product + product.swapaxes(2, 3)) / 2
    stiffness = np.einsum("mpij,mqij->mpq", _elastic_stress(stretch, youngs_modulus, poisson_ratio), stretch)
    # One released edge after the other takes the value that makes its force vanish.
    for edge in range(len(EDGES)):
        loose = np.flatnonzero(released >> edge & 1)
        k = stiffness[loose]
        k -= k[:, :, edge, None] * k[:, edge, None, :] / k[:, edge, edge, None, None]
        k[:, edge] = k[:, :, edge] = 0
        stiffness[loose] = k
    direction = corner[:, second] - corner[:, first]
    elongation = np.einsum("mpi,mij,mpj->mp", direction, strain, direction)
    return np.einsum("mpq,mq,mpi,mpj->mij", stiffness, elongation, direction, direction, optimize=True)


def _longest(corner: np.ndarray) -> np.ndarray:
    """The largest distance between two corners of each tetrahedron."""
    first, second = np.array(EDGES).T
    return np.linalg.norm(corner[:, second] - corner[:, first], axis=2).max(axis=1)


def _contact_stress(corner: np.ndarray, strain: np.ndarray, cut: np.ndarray, youngs_modulus: np.ndarray) -> np.ndarray:
    """What broken tetrahedra carry while their cut is pressed together, without friction, m x 3 x 3."""
    side = np.array([[corner in cut for corner in range(4)] for cut in CUTS], float)
    normal = np.einsum("ma,mai->mi", side[cut], gradients(corner))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    closing = np.minimum(np.einsum("mi,mij,mj->m", normal, strain, normal), 0)
    return (youngs_modulus * closing)[:, None, None] * normal[:, :, None] * normal[:, None, :]
