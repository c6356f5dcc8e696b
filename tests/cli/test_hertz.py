#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A sphere pressed into a block, beside Hertz (1881), as jobs/verification/verify hertz has it on finer meshes."""
import argparse
import pathlib
import sys
import tempfile
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / name) for name in ("tools", "jobs/verification", "jobs/gallery")]

import solids  # noqa: E402

PROGRAM = pathlib.Path()


class Sphere(unittest.TestCase):
    def test_the_force_is_hertzs(self):
        with tempfile.TemporaryDirectory() as folder:
            ratios = solids.pressed_over_hertz(0.16, pathlib.Path(folder), PROGRAM)
        print("force over Hertz's at the same approach", np.round(ratios, 3))
        np.testing.assert_allclose(ratios, 1, atol=0.05)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", required=True, type=pathlib.Path)
    OPTIONS, remaining = parser.parse_known_args()
    PROGRAM = OPTIONS.program
    unittest.main(argv=[sys.argv[0], *remaining])
