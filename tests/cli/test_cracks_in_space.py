#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Growth of pre-cracks in space: an inclined disk beside the kink of Erdogan and Sih, a half ellipse beside Newman and Raju."""
import argparse
import math
import pathlib
import sys
import tempfile
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / name) for name in ("tools", "jobs/verification", "jobs/gallery")]

import command_lines  # noqa: E402
import crackle  # noqa: E402
from plates import largest_hoop_stress  # noqa: E402

OPTIONS = None
MODULUS, POISSON, TOUGHNESS = 32e9, 0.2, 10
PULLED = """[ensemble]
samples = {samples}
seed = 1
[specimen]
size = [{size}]
[[specimen.crack]]
center = [{centre}]
semi_axes = [{axes}]
normal = {normal}
[mesh]
spacing = "{spacing} mm"
growth = {growth}
[[mesh.region]]
x = [{x}]
y = [{y}]
z = [{z}]
spacing = "{fine} mm"
[material]
youngs_modulus = "32 GPa"
poisson_ratio = 0.2
density = "2450 kg/m^3"
[fracture]
toughness = "10 J/m^2"
[[boundary]]
on = "z-min"
traction = ["0 MPa", "0 MPa", "-1 MPa"]
rate = ["0 MPa/s", "0 MPa/s", "-1 MPa/s"]
[[boundary]]
on = "z-max"
traction = ["0 MPa", "0 MPa", "1 MPa"]
rate = ["0 MPa/s", "0 MPa/s", "1 MPa/s"]
{held}[time]
duration = "{duration} us"
integrator = "verlet"
[[sections.plane]]
point = [{centre}]
normal = [1, 0, 0]
"""
MIDDLE = 12  # of the block's width and height [mm]


def lengths(*values):
    return ", ".join(f'"{value} mm"' for value in values)


def held(*conditions):
    """Lines that are held against rigid motion, where the body bears no load."""
    return "".join(f'[[boundary]]\non = "{face}"\nregion = {{ {axis} = [{lengths(at, at)}] }}\nfix = {fix}\n' for face, axis, at, fix in conditions)


def newman_raju(a, c, thickness, half_width, angle):
    """K over the stress at a place of the front of a half ellipse of this depth a and half length c (1981)."""
    shape, depth = a / c, a / thickness
    m = (1.13 - 0.09 * shape, -0.54 + 0.89 / (0.2 + shape), 0.5 - 1 / (0.65 + shape) + 14 * (1 - shape) ** 24)
    of_angle = ((shape * np.cos(angle)) ** 2 + np.sin(angle) ** 2) ** 0.25
    at_surface = 1 + (0.1 + 0.35 * depth**2) * (1 - np.sin(angle)) ** 2
    width = 1 / np.sqrt(np.cos(np.pi * c / (2 * half_width) * np.sqrt(depth)))
    return np.sqrt(np.pi * a / (1 + 1.464 * shape**1.65)) * (m[0] + m[1] * depth**2 + m[2] * depth**4) * of_angle * at_surface * width


def kinks(sample, radius, near, far, width):
    """Angles [degrees] by which the crack turns from a disk's plane at its two ends in the plane x = const through its middle, towards the
    plane across the load: the axis along which the facets at these distances from the end lie. Later ones are branches."""
    surface = sample.crack_surface
    place, area, time = surface.corners.values.mean(axis=1) - MIDDLE * 1e-3, surface.area.values, surface.time.values
    for side in (1, -1):
        out, across = side * np.array((0, 1, -1)) / math.sqrt(2), side * np.array((0, 1, 1)) / math.sqrt(2)
        ahead = np.stack([(place - radius * out) @ out, (place - radius * out) @ across])
        distance, beside = np.hypot(*ahead), np.abs(place[:, 0]) < width
        leaves = time[beside & (distance > far) & (distance < 2 * far) & (ahead[0] > -far)].min(initial=math.inf)
        here = beside & (distance > near) & (distance < far) & (time <= leaves)
        if np.count_nonzero(here) < 5 or distance[here].max() < 0.9 * far:
            continue
        centre = np.average(ahead[:, here], axis=1, weights=area[here])
        spread = ahead[:, here] - centre[:, None]
        axis = np.linalg.eigh(area[here] * spread @ spread.T)[1][:, -1]
        axis *= np.sign(axis @ centre)
        yield math.degrees(math.atan2(axis[1], axis[0]))


class CracksInSpace(unittest.TestCase):
    def samples(self, **values):
        folder = tempfile.TemporaryDirectory(prefix="crackle-space-")
        self.addCleanup(folder.cleanup)
        job, out = (pathlib.Path(folder.name) / name for name in ("job.toml", "out"))
        job.write_text(PULLED.format(**values))
        result = command_lines.crackle(OPTIONS.program, "run", job, "-o", out)
        self.assertEqual(result.returncode, 0, result.stderr)
        return crackle.open(out)

    def test_a_disk_at_45_degrees_kinks_as_erdogan_and_sih_say(self):
        radius = 3.0
        ensemble = self.samples(
            samples=4, size=lengths(24, 24, 24), centre=lengths(MIDDLE, MIDDLE, MIDDLE), axes=lengths(radius, radius), normal=[0, 1, 1],
            spacing=3, growth=0.3, x=lengths(8, 16), y=lengths(7.5, 16.5), z=lengths(8.5, 15.5), fine=0.6, duration=20,
            held=held(("y-min", "z", MIDDLE, ["z"]), ("y-min", "x", MIDDLE, ["x", "y"]), ("y-max", "x", MIDDLE, ["x"])))
        found = [angle for sample in ensemble for angle in kinks(sample, radius * 1e-3, 0.3e-3, 2.4e-3, 1.2e-3)]
        # K_I is that of the disk across the load, times cos^2 of 45 degrees; K_II at the ends: Kassir and Sih, 1966.
        exact = -largest_hoop_stress(2 / math.pi, 4 / (math.pi * (2 - POISSON)))
        print(f"inclined disk: kinks by {np.mean(found):.1f} +- {np.std(found, ddof=1) / math.sqrt(len(found)):.1f} degrees, {len(found)} ends; "
              f"Erdogan and Sih: {exact:.1f}, across the load: 45")
        self.assertGreater(len(found), 4)
        self.assertAlmostEqual(np.mean(found), exact, delta=12)

    def test_a_half_ellipse_runs_near_newmans_and_rajus_load(self):
        """The front starts at its weakest place, so that it runs a little below."""
        depth, half_length, thickness = 1.8, 3.0, 6.0
        ensemble = self.samples(
            samples=3, size=lengths(thickness, 24, 24), centre=lengths(0, MIDDLE, MIDDLE), axes=lengths(depth, half_length), normal=[0, 0, 1],
            spacing=2, growth=0.2, x=lengths(0, 3), y=lengths(8, 16), z=lengths(11, 13), fine=0.4, duration=4,
            held=held(("y-min", "z", MIDDLE, ["y", "z"]), ("x-max", "z", 0, ["x"]), ("x-max", "z", 24, ["x"]), ("y-min", "z", 0, ["y"])))
        largest = max(newman_raju(depth * 1e-3, half_length * 1e-3, thickness * 1e-3, 12e-3, np.linspace(0, np.pi / 2, 91)))
        toughness = math.sqrt(MODULUS * TOUGHNESS / (1 - POISSON**2))
        ratio = ensemble.samples.onset_force.to_numpy() / (thickness * 24e-6) * largest / toughness
        print(f"half ellipse: runs at {np.mean(ratio):.2f} of Newman and Raju's load, {min(ratio):.2f} to {max(ratio):.2f}")
        self.assertTrue(0.75 < min(ratio) and max(ratio) < 1.05, ratio)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", required=True)
    OPTIONS, remaining = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0], *remaining])
