#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of the photo-elastic pictures against exact solutions."""
from __future__ import annotations

import sys
import time
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "cli")]

from box_mesh import box_mesh  # noqa: E402
from crackle_report.photoelasticity import Grid, Optics, make_fringes  # noqa: E402
from crackle_report.stress import element_stress  # noqa: E402
from effort import repetitions  # noqa: E402

YOUNG, POISSON = 3300e6, 0.38
OPTICS = Optics()


def in_plane(stress_yy, stress_zz, stress_yz) -> np.ndarray:
    """Stress m x 6 of a plane state in the YZ plane."""
    none = np.zeros_like(stress_yy)
    return np.stack([none, stress_yy, stress_zz, stress_yz, none, none], axis=1)


class ExactStates(unittest.TestCase):
    def test_stress_follows_hookes_law(self):
        nodes, tetrahedra = box_mesh((3e-3, 4e-3, 5e-3), (2, 2, 3), 0.2)
        gradient = np.array([[1, 2, -3], [5, -4, 7], [11, 13, 6]]) * 1e-4  # du_i / dx_j
        stress = element_stress(nodes, tetrahedra, nodes @ gradient.T, YOUNG, POISSON)
        shear = YOUNG / (2 * (1 + POISSON))
        # Engineering shear strains yz, xz, xy; normal strains with a common part from their sum of 3e-4.
        for k, expected in zip((3, 4, 5), shear * np.array([20e-4, 8e-4, 7e-4])):
            np.testing.assert_allclose(stress[:, k], expected, rtol=1e-9)
        pressure = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON)) * 3e-4
        for k, strain in zip((0, 1, 2), (1e-4, -4e-4, 6e-4)):
            np.testing.assert_allclose(stress[:, k], pressure + 2 * shear * strain, rtol=1e-9)

    def test_a_strip_in_uniform_tension(self):
        size = (5e-3, 10e-3, 20e-3)
        tension = 12e6
        expected = OPTICS.order_per_stress_length * tension * size[0]
        for disturbance in (0.0, 0.25):
            nodes, tetrahedra = box_mesh(size, (4, 8, 15), disturbance)
            displacement = nodes * tension / YOUNG * (-POISSON, -POISSON, 1)
            stress = element_stress(nodes, tetrahedra, displacement, YOUNG, POISSON)
            np.testing.assert_allclose(stress[:, 2], tension, rtol=1e-9)
            np.testing.assert_allclose(stress[:, [0, 1, 3, 4, 5]], 0, atol=1e-9 * tension)
            picture = make_fringes(nodes, tetrahedra, stress, Grid.over((0, size[1]), (0, size[2]), 0.1e-3))
            error = np.abs(picture.order / expected - 1).max()
            field_error = np.abs(picture.dark_field_product - np.sin(np.pi * expected) ** 2).max()
            print(f"tension, nodes moved by {disturbance}: N = {expected:.4f}, largest error {error:.1e}, "
                  f"of the product's intensity {field_error:.1e}")
            self.assertEqual(picture.order.shape, (200, 100))
            self.assertLess(error, 1e-9)
            self.assertLess(field_error, 1e-8)
            np.testing.assert_allclose(picture.intensity(product=False), np.sin(np.pi * expected) ** 2, atol=1e-8)
            np.testing.assert_allclose(picture.intensity(light_field=True), np.cos(np.pi * expected) ** 2, atol=1e-8)
            np.testing.assert_array_equal(picture.intensity(reverse=True), picture.intensity(light_field=True))

    def test_a_beam_in_pure_bending(self):
        # Saint-Venant's exact solution: stress along z only, proportional to the distance from the axis.
        size = (5e-3, 20e-3, 40e-3)
        curvature = 0.4  # [1/m]
        grid = Grid.over((0, size[1]), (0.25 * size[2], 0.75 * size[2]), 0.2e-3)
        expected = OPTICS.order_per_stress_length * YOUNG * curvature * np.abs(grid.y - size[1] / 2) * size[0]
        errors = []
        for n in (1, 2, 4):
            nodes, tetrahedra = box_mesh(size, (2 * n, 8 * n, 16 * n), 0.2)
            x, y, z = (nodes - np.array(size) / 2).T
            displacement = curvature * np.stack(
                [-POISSON * x * y, -(z ** 2 + POISSON * (y ** 2 - x ** 2)) / 2, y * z], axis=1)
            stress = element_stress(nodes, tetrahedra, displacement, YOUNG, POISSON)
            order = make_fringes(nodes, tetrahedra, stress, grid).order
            # Stress is constant in a tetrahedron: rays see steps, their mean over the length does not.
            errors.append(np.abs(order.mean(axis=0) - expected).max() / expected.max())
        print(f"bending, up to N = {expected.max():.2f}: largest errors {', '.join(f'{e:.2e}' for e in errors)} of it")
        self.assertLess(errors[2], 0.02)
        self.assertLess(errors[2], 0.4 * errors[0])

    def test_a_disk_under_diametral_load(self):
        # The exact plane stress (Frocht, 1948) of a disk of diameter D, loaded by P along z.
        diameter, force, thickness = 40e-3, 800.0, 5e-3
        radius = diameter / 2

        def exact(y, z):
            above, below = radius - z, radius + z
            r1, r2 = (y ** 2 + above ** 2) ** 2, (y ** 2 + below ** 2) ** 2
            scale = -2 * force / (np.pi * thickness)
            return (scale * (above * y ** 2 / r1 + below * y ** 2 / r2 - 1 / diameter),
                    scale * (above ** 3 / r1 + below ** 3 / r2 - 1 / diameter),
                    -scale * (above ** 2 * y / r1 - below ** 2 * y / r2))

        grid = Grid.over((-radius, radius), (-radius, radius), diameter / 201)

        def make_picture(n_cells):
            nodes, tetrahedra = box_mesh((thickness, diameter, diameter), (1, n_cells, n_cells))
            nodes = nodes - (0, radius, radius)
            centroid = nodes[tetrahedra].mean(axis=1)[:, 1:]
            inside = np.hypot(*centroid.T) < radius
            return make_fringes(nodes, tetrahedra[inside], in_plane(*exact(*centroid[inside].T)), grid)

        coarse, picture = make_picture(80), make_picture(160)
        centre = OPTICS.order_per_stress_length * 8 * force / (np.pi * diameter)
        print(f"disk: N at the centre {picture.order[100, 100]:.4f}, exact {centre:.4f}")
        self.assertAlmostEqual(picture.order[100, 100], centre, delta=5e-3 * centre)
        # Along the diameter across the load; the exact order falls from the centre to 0 at the rim.
        across = centre * (diameter ** 4 - 4 * diameter ** 2 * grid.y ** 2) / (diameter ** 2 + 4 * grid.y ** 2) ** 2
        inner = np.abs(grid.y) < 0.9 * radius
        self.assertLess(np.abs(picture.order[100] - across)[inner].max(), 0.03 * centre)
        # Fringes to count from rim to rim across: every whole order below the centre's, on both sides.
        dark = picture.dark_field[100][np.abs(grid.y) < 0.97 * radius]
        minima = np.count_nonzero((dark[1:-1] < dark[:-2]) & (dark[1:-1] <= dark[2:]) & (dark[1:-1] < 0.1))
        self.assertEqual(minima, 2 * int(centre))
        # Away from the loads both forms show the exact field: principal directions do not turn along a ray.
        y, z = np.meshgrid(grid.y, grid.z)
        away = (np.hypot(y, z) < 0.95 * radius) & (np.abs(z) < 0.6 * radius)
        yy, zz, yz = exact(y, z)
        field = np.sin(np.pi * OPTICS.order_per_stress_length * thickness * np.hypot(yy - zz, 2 * yz)) ** 2
        for name in ("dark_field", "dark_field_product"):
            errors = [np.abs(getattr(found, name) - field)[away].mean() for found in (coarse, picture)]
            print(f"disk, {name}: mean error of the intensity {errors[0]:.4f}, at half the spacing {errors[1]:.4f}")
            self.assertLess(errors[1], 0.03)
            self.assertLess(errors[1], 0.6 * errors[0])
        self.assertTrue(np.isnan(picture.order[5, 5]))
        self.assertTrue(np.isnan(picture.dark_field_product[5, 5]))


class Rays(unittest.TestCase):
    def layers(self, n_layers: int):
        nodes, tetrahedra = box_mesh((5e-3, 1e-3, 1e-3), (n_layers, 2, 2))
        x = nodes[tetrahedra].mean(axis=1)[:, 0] / 5e-3
        return nodes, tetrahedra, np.floor(x * n_layers).astype(int)

    def test_principal_directions_that_turn_along_the_ray(self):
        # Uniform difference of principal stresses whose directions turn by `twist` over the thickness: exact
        # for circular light, (D / T)^2 sin^2(T / 2) with T^2 = D^2 + (2 twist)^2 (Aben, 1979).
        grid = Grid.over((0, 1e-3), (0, 1e-3), 0.3e-3)
        order = 0.7
        difference = order / (OPTICS.order_per_stress_length * 5e-3)
        for twist in (0.3, 1.2, 3.0):
            errors = []
            for n_layers in (40, 160):
                nodes, tetrahedra, layer = self.layers(n_layers)
                angle = 2 * twist * (layer + 0.5) / n_layers
                stress = in_plane(difference / 2 * np.cos(angle), -difference / 2 * np.cos(angle),
                                  difference / 2 * np.sin(angle))
                picture = make_fringes(nodes, tetrahedra, stress, grid)
                retardation = 2 * np.pi * order
                total = np.hypot(retardation, 2 * twist)
                exact = (retardation / total * np.sin(total / 2)) ** 2
                errors.append(np.abs(picture.dark_field_product - exact).max())
                # The integrated form sees the sum of the turning vectors.
                integrated = order * abs(np.sin(twist) / twist)
                np.testing.assert_allclose(picture.order, integrated, rtol=2e-3)
            print(f"twist {twist}: dark field {exact:.4f}, errors {errors[0]:.1e}, {errors[1]:.1e}; "
                  f"integrated {np.sin(np.pi * integrated) ** 2:.4f}")
            self.assertLess(errors[1], 1e-4)
            self.assertLess(errors[1], 0.1 * errors[0])

    def test_the_order_of_the_layers_matters_to_the_product(self):
        # Three plates of a quarter, at 0, 45 and 0 degrees: as (0, 0, 45) they make another picture.
        nodes, tetrahedra, layer = self.layers(3)
        difference = 0.25 / (OPTICS.order_per_stress_length * 5e-3 / 3)
        grid = Grid.over((0, 1e-3), (0, 1e-3), 0.5e-3)
        found = []
        for turned in (1, 2):
            along = np.where(layer == turned, 0.0, difference / 2)
            stress = in_plane(along, -along, np.where(layer == turned, difference / 2, 0.0))
            picture = make_fringes(nodes, tetrahedra, stress, grid)
            np.testing.assert_allclose(picture.order, 0.25 * np.sqrt(5), rtol=1e-9)
            found.append(picture.dark_field_product)
        # Quaternions (1 + k)(1 + i)(1 + k) and (1 + i)(1 + k)(1 + k) over sqrt(8).
        np.testing.assert_allclose(found[0], 1.0, atol=1e-9)
        np.testing.assert_allclose(found[1], 0.5, atol=1e-9)

    def test_chords_fill_the_body(self):
        # With one unit of stress everywhere the order is the thickness, at any cut of the grid into bands.
        nodes, tetrahedra = box_mesh((5e-3, 6e-3, 7e-3), (6, 7, 8), 0.2)
        stress = in_plane(np.full(len(tetrahedra), 1 / OPTICS.order_per_stress_length), np.zeros(len(tetrahedra)),
                          np.zeros(len(tetrahedra)))
        order = make_fringes(nodes, tetrahedra, stress, Grid.over((-1e-3, 7e-3), (0, 7e-3), 0.05e-3)).order
        self.assertLess(np.abs(order[:, 20:140] - 5e-3).max(), 1e-11)
        self.assertTrue(np.isnan(order[:, :20]).all() and np.isnan(order[:, 140:]).all())

    def test_a_full_picture_takes_seconds(self):
        nodes, tetrahedra = box_mesh((5e-3, 24.5e-3, 140e-3), repetitions((5, 20, 62), (10, 40, 125)), 0.2)
        stress = np.random.Generator(np.random.PCG64(1)).normal(0, 1e6, (len(tetrahedra), 6))
        grid = Grid.over((0, 24.5e-3), (0, 140e-3), repetitions(0.3e-3, 0.1e-3))
        start = time.process_time()
        picture = make_fringes(nodes, tetrahedra, stress, grid)
        seconds = time.process_time() - start
        print(f"{len(tetrahedra)} tetrahedra on {grid.shape[1]} x {grid.shape[0]} pixels: {seconds:.1f} s")
        self.assertFalse(np.isnan(picture.order).any())
        self.assertLess(seconds, 60)


if __name__ == "__main__":
    unittest.main(verbosity=2)
