#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The courses of a small cantilever, as its files tell them: wherever it lies, whatever its edges are called, and when it arrests."""
from __future__ import annotations

import argparse
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools")]

import command_lines  # noqa: E402

PROGRAM = Path()
REST = """
[mesh]
base = "shared"
spacing = "1 mm"
notch_spacing = "0.5 mm"
growth = 0.2
[material]
youngs_modulus = "3300 MPa"
poisson_ratio = 0.3
density = "1180 kg/m^3"
[fracture]
strength = "35 MPa"
impulse = "1e-8 MPa^2 s"
[[boundary]]
on = "edge-0"
fix = ["x", "y", "z"]
"""
PULLED = """[[boundary]]
on = "edge-2"
force = ["0 N", "0.01 N", "0 N"]
rate = ["0 N/s", "0.1 N/s", "0 N/s"]
[time]
duration = "40 us"
"""
BENT_AND_BACK = """[[boundary]]
on = "edge-2"
displacement = ["free", "1.5 mm", "free"]
history = [["0 s", 0], ["10 s", 1], ["20 s", 0]]
[time]
duration = "10 us"
arrest = "9 us"
"""


def outline(y: float, z: float) -> str:
    """A strip of 4 x 40 mm with a slot of 1 mm in its side, and a section ahead of that; its lower left corner at (y, z) [mm]."""
    def point(dy: float, dz: float) -> str:
        return f'["{y + dy:g} mm", "{z + dz:g} mm"]'
    corners = ", ".join(point(*corner) for corner in ((0, 0), (4, 0), (4, 40), (0, 40)))
    return f"""[specimen]
thickness = "1 mm"
outline = [{corners}]
[[specimen.notch]]
from = {point(0, 10)}
to = {point(1, 10)}
height = "0.5 mm"
[[sections.line]]
from = {point(2.5, 2)}
to = {point(2.5, 20)}"""


BOX = """[specimen]
size = ["1 mm", "4 mm", "40 mm"]
[[specimen.notch]]
face = "y-min"
at = "10 mm"
depth = "1 mm"
height = "0.5 mm"
[sections]
y = ["2.5 mm"]"""


class Courses(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def sample(self, text: str) -> Path:
        source = self.folder / "input.toml"
        source.write_text("[ensemble]\nsamples = 1\nseed = 7\n" + text)
        out = self.folder / f"out-{len(list(self.folder.glob('out-*')))}"
        done = command_lines.crackle(PROGRAM, "sample", source, "--sample", 0, "-o", out)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return out / "samples" / "0000.h5"

    def test_it_does_not_matter_where_the_body_lies(self):
        """The same body is broken everywhere, though the last bits of its coordinates lead to other breaks."""
        for y, z in ((0, 0), (-4, -40), (1000, 1000)):
            with h5py.File(self.sample(outline(y, z) + REST + PULLED)) as root:
                phases, breaks = int(root["counts/dynamic_phases"][()]), len(root["breaks/tetrahedron"])
                print(f"corner at ({y}, {z}) mm: {phases} dynamic phases, {breaks} breaks")
                self.assertGreaterEqual(phases, 1)
                self.assertGreater(breaks, 5)

    def test_edges_of_a_box_are_its_faces(self):
        text = BOX + REST + PULLED
        by_edge, by_face = self.sample(text), self.sample(text.replace("edge-0", "z-min").replace("edge-2", "z-max"))
        with h5py.File(by_edge) as one, h5py.File(by_face) as other:
            for name in ("breaks/tetrahedron", "breaks/load_time", "history/load", "history/reaction"):
                np.testing.assert_array_equal(one[name][:], other[name][:], name)

    def test_what_broke_before_an_arrest_stays_broken(self):
        with h5py.File(self.sample(outline(0, 0) + REST + BENT_AND_BACK)) as root:
            self.assertEqual(int(root["summary/outcome"][()]), 1, "arrested")
            history = root["history"]
            self.assertEqual(len(root["breaks/tetrahedron"]), int(history["broken"][-1]))
            released = root["breaks/released_energy"][:].sum()
            self.assertAlmostEqual(released, float(history["released"][-1]), delta=1e-6 * released)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=Path, required=True)
    arguments, rest = parser.parse_known_args()
    PROGRAM = arguments.program.resolve()
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
