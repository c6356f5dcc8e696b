#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of the report on bodies of several materials: fringes and regions."""
from __future__ import annotations

import argparse
import os
import sys
import unittest
from pathlib import Path

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgb

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "cli")]

from crackle.files import ResultsError  # noqa: E402
from crackle_report import reading, style  # noqa: E402
from crackle_report.figures import crack_paths, crossings, growth, surface  # noqa: E402
from crackle_report.options import Options  # noqa: E402
from crackle_report.photoelasticity import coefficients  # noqa: E402
from synthetic_ensemble import changed, write_ensemble  # noqa: E402
from test_report import Ensembles  # noqa: E402


class Materials(Ensembles):
    def test_epoxy_is_assumed_of_soft_materials_only(self):
        material, moduli = np.array([0, 0, 1]), np.array([3.3e9, 3.1e9, 70e9])
        np.testing.assert_array_equal(coefficients((), material, moduli), [5.5e-11, 5.5e-11, 0])
        np.testing.assert_array_equal(coefficients((2e-12,), material, moduli), [2e-12] * 3)
        np.testing.assert_array_equal(coefficients((5e-11, 3e-12), material, moduli), [5e-11, 5e-11, 3e-12])
        with self.assertRaisesRegex(ResultsError, "3 stress-optic coefficients are given for a body of 2 materials"):
            coefficients((1e-11,) * 3, material, moduli)
        write_ensemble(self.folder, 1)
        ensemble = reading.read_ensemble(self.folder)
        self.assertIn("stress-optic coefficient 3e-11 1/Pa.", growth.section(ensemble, Options(stress_optic=(3e-11,), animation=False)).text)
        with changed(self.folder / "samples" / "0000.h5") as root:
            root["frames"].attrs["youngs_modulus"] = 70e9
        section = growth.section(ensemble, Options(animation=False))
        self.assertEqual(section.title, "Crack growth")
        self.assertIn("epoxy's is not assumed above 10 GPa", section.text)
        self.assertFalse(any(axes.get_images() for axes in section.pictures[0].figure.axes))

    def test_parts_of_other_materials_are_drawn_everywhere(self):
        pictures = {"crack_paths": crack_paths.typical, "crossings": crossings.section, "growth": growth.section}
        write_ensemble(self.folder, 1)
        with changed(self.folder / "samples" / "0000.h5") as root:
            middle = root["mesh/nodes"][...][root["mesh/tetrahedra"][...]].mean(axis=1)
            root["mesh/material"] = (middle[:, 1] > 12.25e-3).astype("u1")
            root["mesh/youngs_modulus"] = np.where(middle[:, 1] > 12.25e-3, 70e9, 3.3e9)
            root["mesh/poisson_ratio"] = np.full(len(middle), 0.3)
            root["specimen/size"] = [5e-3, 24.5e-3, 140e-3]
        ensemble = reading.read_ensemble(self.folder)
        for name, draw in pictures.items():
            section = draw(ensemble, Options(animation=False))
            panels = [axes for picture in section.pictures for axes in picture.figure.axes if axes.get_aspect() == 1]
            self.assertTrue(panels, name)
            for axes in panels:
                borders = [np.concatenate(lines.get_segments()) for lines in axes.collections
                           if isinstance(lines, LineCollection) and len(lines.get_segments()) > 10]
                self.assertEqual(len(borders), 2 if axes.get_images() else 1, name)
                np.testing.assert_allclose(borders[-1][:, 0], 12.25, atol=1e-9)
                tinted = [patches for patches in axes.collections if isinstance(patches, PolyCollection)
                          and np.allclose(patches.get_facecolor()[:, :3], to_rgb(style.OTHER_MATERIAL))]
                corners = np.concatenate([path.vertices for path in tinted[-1].get_paths()])
                np.testing.assert_allclose([corners[:, 0].min(), corners[:, 0].max()], [12.25, 24.5])
        self.assertIn("show no fringes", section.text)  # of the stiff half
        edges = np.frombuffer(surface.section(ensemble, Options()).views[0].line, "<f4").reshape(-1, 2, 3)
        self.assertGreater(np.isclose(edges[:, :, 1], 12.25).all(axis=1).sum(), 30)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    options, rest = parser.parse_known_args()
    os.environ["CRACKLE"] = os.path.abspath(options.program)
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
