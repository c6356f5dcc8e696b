# SPDX-License-Identifier: GPL-3.0-or-later
"""Photo-elastic pictures: what light that crosses a stressed plate along x shows of its stress.

The retardation grows along a ray by C / wavelength times the difference of the secondary principal stresses
(those of the stress across the ray). With constant stress in each tetrahedron its contribution is exact: its
stress times the chord that the ray cuts out of it. Two ways to add the contributions up:

- integrated: fringe order N = C / wavelength sqrt[(int (s_yy - s_zz) dx)^2 + (int 2 s_yz dx)^2], right where
  the principal directions turn little along the ray (Aben, 1979);
- product: each chord is a linear retarder, and the Jones matrices of all retarders on the ray are multiplied
  in order, which holds for any stress.

Both are given as seen in a circular polariscope, whose pictures have no isoclinics.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Iterator, Sequence

import numpy as np
from crackle.files import ResultsError

from .mesh import gradients

STRESS_OPTIC = 5.5e-11  # C [1/Pa], a typical epoxy resin
STIFFEST_RESIN = 10e9  # Young's modulus [Pa] above which a material is not taken for one
NO_FRINGES = ("the stress-optic coefficient of the material is not known, and epoxy's is not assumed above 10 GPa; "
              "crackle-report --stress-optic gives it (soda-lime glass has some 2.7e-12 1/Pa)")
WAVELENGTH = 546e-9  # [m], the green line of mercury

# Candidates (pixel, tetrahedron) that are worked on at the same time: bounds the memory to some 500 MB.
CANDIDATES_AT_ONCE = 2_000_000


@dataclass(frozen=True)
class Optics:
    stress_optic: float | np.ndarray = STRESS_OPTIC  # of all tetrahedra, or of each
    wavelength: float = WAVELENGTH

    @property
    def order_per_stress_length(self) -> float | np.ndarray:
        """Fringe order for each Pa of stress difference and m of ray."""
        return self.stress_optic / self.wavelength


def coefficients(given: Sequence[float], material: np.ndarray, youngs_modulus: np.ndarray) -> np.ndarray:
    """Stress-optic coefficient of each tetrahedron [1/Pa]: those given for all, or for each material; without any, epoxy's, and 0
    in materials that are no resin.

    @param material numbers, of each tetrahedron
    @raise ResultsError: there is another number of materials
    """
    numbers = np.unique(material)
    if not given:
        of_material = {k: STRESS_OPTIC * (np.median(youngs_modulus[material == k]) <= STIFFEST_RESIN) for k in numbers}
        return np.vectorize(of_material.get, otypes=[float])(material)
    if len(given) not in (1, numbers.max() + 1):
        raise ResultsError(f"{len(given)} stress-optic coefficients are given for a body of {numbers.max() + 1} materials")
    return np.resize(given, numbers.max() + 1)[material]


@dataclass(frozen=True)
class Grid:
    """Regular pixels in the YZ plane: pixel [k, j] has its centre at (y[j], z[k])."""

    y: np.ndarray
    z: np.ndarray

    @classmethod
    def over(cls, y_range: tuple[float, float], z_range: tuple[float, float], pixel: float) -> "Grid":
        """Pixels of about the given size that fill a rectangle [m]."""
        n_y, n_z = (max(1, round((high - low) / pixel)) for low, high in (y_range, z_range))
        return cls(*(low + (np.arange(n) + 0.5) * (high - low) / n
                     for (low, high), n in ((y_range, n_y), (z_range, n_z))))

    @property
    def shape(self) -> tuple[int, int]:
        return self.z.size, self.y.size

    @property
    def pixel(self) -> float:
        """Its height [m], in pictures of two rows or more."""
        return float(self.z[1] - self.z[0])


@dataclass(frozen=True)
class Fringes:
    """A picture; NaN where the ray meets no tetrahedron."""

    order: np.ndarray  # fringe order N by the integrated form
    dark_field: np.ndarray  # intensity between 0 and 1, integrated form: sin^2(pi N)
    dark_field_product: np.ndarray  # the same by the product of the Jones matrices

    def intensity(self, light_field: bool = False, product: bool = True, reverse: bool = False) -> np.ndarray:
        """Intensity between 0 and 1, of dark or light field, with colours reversed or not."""
        dark = self.dark_field_product if product else self.dark_field
        return dark if light_field == reverse else 1 - dark


def make_fringes(nodes: np.ndarray, tetrahedra: np.ndarray, stress: np.ndarray, grid: Grid,
                 optics: Optics = Optics()) -> Fringes:
    """The picture of a body of tetrahedra.

    nodes: n x 3 [m]; tetrahedra: m x 4; stress: m x 6 in the form of stress.element_stress [Pa].
    """
    return make_series(nodes, tetrahedra, [stress], grid, optics)[0]


def make_series(nodes: np.ndarray, tetrahedra: np.ndarray, stresses: Sequence[np.ndarray], grid: Grid,
                optics: Optics = Optics()) -> list[Fringes]:
    """As make_fringes, for several states of stress of one body: its chords are cut once."""
    # Two components of the retardation for each m of ray, in fringes: the traceless stress across the ray.
    rates = [optics.order_per_stress_length * np.stack([stress[:, 1] - stress[:, 2], 2 * stress[:, 3]])
             for stress in stresses]
    orders, products = (np.full((len(rates), *grid.shape), np.nan) for _ in range(2))
    for rows, chords in _bands(nodes, tetrahedra, grid):
        for i, rate in enumerate(rates):
            orders[i, rows] = _integrate(chords, rate).reshape(-1, grid.y.size)
            products[i, rows] = _multiply(chords, rate).reshape(-1, grid.y.size)
    return [Fringes(order, np.sin(np.pi * order) ** 2, product) for order, product in zip(orders, products)]


@dataclass(frozen=True)
class _Chords:
    """What the rays of a band of pixel rows cut out of tetrahedra, ray by ray in the order in which they meet them."""

    count: np.ndarray  # on each ray
    pixel: np.ndarray  # of each chord; counts within the band
    tetrahedron: np.ndarray
    length: np.ndarray  # [m]


def _integrate(chords: _Chords, rate: np.ndarray) -> np.ndarray:
    """Fringe order of each ray of a band by the integrated form."""
    total = [np.bincount(chords.pixel, r[chords.tetrahedron] * chords.length, chords.count.size) for r in rate]
    return np.where(chords.count > 0, np.hypot(*total), np.nan)


def _multiply(chords: _Chords, rate: np.ndarray) -> np.ndarray:
    """Dark field of each ray of a band by the product of the Jones matrices."""
    # A retarder's matrix, cos p + i sin p (c s3 + s s1) with Pauli's matrices, as a quaternion. The k-th
    # retarders of all rays are multiplied at once.
    along, across = np.pi * rate[:, chords.tetrahedron] * chords.length
    angle = np.hypot(along, across)
    sine = np.sinc(angle / np.pi)
    factor = np.stack([np.cos(angle), sine * along, sine * across])
    start = np.cumsum(chords.count) - chords.count
    rays = np.flatnonzero(chords.count)
    state = np.zeros((4, chords.count.size))  # components of 1, i s3, i s1, i s2
    state[0] = 1
    for k in range(int(chords.count.max(initial=0))):
        rays = rays[chords.count[rays] > k]
        w, a, b = factor[:, start[rays] + k]
        s, p, q, r = state[:, rays]
        state[:, rays] = (w * s - a * p - b * q, w * p + a * s - b * r, w * q + b * s + a * r,
                          w * r + b * p - a * q)
    # Of circular light, what the matrix takes out of its own sense passes the crossed analyser.
    return np.where(chords.count > 0, state[1] ** 2 + state[2] ** 2, np.nan)


def _bands(nodes: np.ndarray, tetrahedra: np.ndarray, grid: Grid) -> Iterator[tuple[slice, _Chords]]:
    """The chords of all rays, in bands of pixel rows."""
    faces = _faces(nodes, tetrahedra)
    corner = nodes[tetrahedra]
    first, last = (_pixel_range(corner[:, :, axis], centres) for axis, centres in ((1, grid.y), (2, grid.z)))
    # Candidates in each pixel row, to make the bands about as large as can be worked on at once.
    n_across = np.maximum(first[1] - first[0], 0)
    steps = np.zeros(grid.z.size + 1)
    np.add.at(steps, last[0], n_across)
    np.add.at(steps, last[1], -n_across)
    work = np.cumsum(np.cumsum(steps[:-1]))
    band = (work / CANDIDATES_AT_ONCE).astype(int)
    edges = np.r_[0, np.flatnonzero(np.diff(band)) + 1, grid.z.size]
    for low, high in zip(edges[:-1], edges[1:]):
        bottom, top = np.maximum(last[0], low), np.minimum(last[1], high)
        inside = np.flatnonzero((top > bottom) & (n_across > 0))
        yield slice(low, high), _cut(faces, inside, first[0], n_across, bottom, top, low, high - low, grid)


def _pixel_range(coordinate: np.ndarray, centres: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pixels whose centre may lie within each tetrahedron's extent: first, and one behind the last."""
    return (np.searchsorted(centres, coordinate.min(axis=1) - _offset(centres), "left"),
            np.searchsorted(centres, coordinate.max(axis=1), "right"))


def _offset(centres: np.ndarray) -> float:
    """Rays pass this far beside the pixels' centres, so that none runs within a face of a regular mesh."""
    return 1e-6 * (centres[-1] - centres[0] if centres.size > 1 else 1e-3) / centres.size


@dataclass(frozen=True)
class _Faces:
    """Each face's plane as x = p + q y + r z; the ray enters through the first n_entered of the four."""

    plane: np.ndarray  # m x 4 x 3
    n_entered: np.ndarray


def _faces(nodes: np.ndarray, tetrahedra: np.ndarray) -> _Faces:
    corner = nodes[tetrahedra].astype(float)
    centre = corner.mean(axis=1)
    gradient = gradients(corner)
    # A face along the rays limits them by leaning a little: in or out everywhere but on itself.
    slope = gradient[:, :, 0]
    least = 1e-12 * np.abs(slope).max(axis=1, keepdims=True)
    slope = np.where(np.abs(slope) < least, np.where(slope < 0, -least, least), slope)
    # On a face 1/4 + gradient . (point - centre) = 0.
    across = gradient[:, :, 1:]
    at_origin = 0.25 - (across * centre[:, None, 1:]).sum(axis=2)
    plane = -np.concatenate([at_origin[:, :, None], across], axis=2) / slope[:, :, None]
    plane[:, :, 0] += centre[:, :1]
    order = np.argsort(slope < 0, axis=1, kind="stable")
    return _Faces(np.take_along_axis(plane, order[:, :, None], axis=1), (slope > 0).sum(axis=1))


def _cut(faces: _Faces, inside: np.ndarray, left: np.ndarray, n_across: np.ndarray, bottom: np.ndarray,
         top: np.ndarray, first_row: int, n_rows: int, grid: Grid) -> _Chords:
    """The chords of the tetrahedra `inside` with the pixels of their bounding rectangles."""
    parts = []
    for n_entered in range(1, 4):
        chosen = inside[faces.n_entered[inside] == n_entered]
        n_columns = n_across[chosen]
        n_pixels = (top - bottom)[chosen] * n_columns
        which = np.repeat(np.arange(chosen.size), n_pixels)
        within = np.arange(which.size) - np.repeat(np.cumsum(n_pixels) - n_pixels, n_pixels)
        row, column = np.divmod(within, n_columns[which])
        row += bottom[chosen][which]
        column += left[chosen][which]
        y = grid.y[column] + _offset(grid.y)
        z = grid.z[row] + np.sqrt(0.5) * _offset(grid.z)
        plane = faces.plane[chosen].transpose(1, 2, 0)  # 4 x 3 x chosen
        x = [p[which] + q[which] * y + r[which] * z for p, q, r in plane]
        entry = np.maximum.reduce(x[:n_entered])
        length = np.minimum.reduce(x[n_entered:]) - entry
        cut = length > 0
        pixel = (row[cut] - first_row) * grid.y.size + column[cut]
        parts.append((pixel, entry[cut], chosen[which[cut]], length[cut]))
    pixel, entry, tetrahedron, length = (np.concatenate(column) for column in zip(*parts))
    order = np.lexsort((entry, pixel))
    count = np.bincount(pixel, minlength=n_rows * grid.y.size)
    return _Chords(count, pixel[order], tetrahedron[order], length[order])
