#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""crackle mesh: the table of one realization, and the survey of many."""
import argparse
import csv
import functools
import io
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import h5py
import matplotlib
import numpy as np

matplotlib.use("Agg")

TOOLS = pathlib.Path(__file__).resolve().parents[2] / "tools"
sys.path.insert(0, str(TOOLS))

import command_lines  # noqa: E402
import crackle  # noqa: E402
import in_process  # noqa: E402
from crackle_report import survey  # noqa: E402

PROGRAM = ""
DEMO = pathlib.Path(__file__).resolve().parents[2] / "jobs" / "demo.toml"


REGIONS = """
[[mesh.region]]
y = ["6 mm", "18.5 mm"]
z = ["64 mm", "76 mm"]
spacing = "0.8 mm"
[[mesh.region]]
z = ["60 mm", "80 mm"]
spacing = "1.5 mm"
"""
REGION_OF_A_DISC = """
[[specimen.region]]
material = "disc"
center = ["12.25 mm", "100 mm"]
radius = "4 mm"
"""
VARIATION = """
[fracture.variation]
distribution = "{}"
{}
"""
STRENGTH = 35e6  # in jobs/demo.toml [Pa]


def run_program(command, *arguments):
    return command_lines.crackle(PROGRAM, command, *arguments)


def invoke(*arguments):
    return run_program("mesh", *arguments)


@functools.cache
def mesh_of_the_demo():
    """What `crackle mesh` says of it, and the content of its file."""
    with tempfile.TemporaryDirectory(prefix="crackle-mesh-") as folder:
        mesh = pathlib.Path(folder) / "mesh.vtkhdf"
        result = invoke(DEMO, "-o", mesh)
        return result, mesh.read_bytes()


class Mesh(unittest.TestCase):
    def setUp(self):
        self.parent = tempfile.TemporaryDirectory(prefix="crackle-mesh-")
        self.folder = pathlib.Path(self.parent.name)

    def tearDown(self):
        self.parent.cleanup()

    def test_table_is_complete(self):
        mesh = self.folder / "mesh.vtkhdf"
        result = invoke(DEMO, "--sample", 2, "--ranks", 4, "-o", mesh)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        for row in (r"sample +2 of seed 2012", r"nodes +\d+", r"tetrahedra +\d+", r"boundary triangles +\d+",
                    r"spacing +min 0\.600, 1 % .*, median .*, max 3\.000 mm", r"edge length +min .* mm",
                    r"quality +min 0\.2\d+, 1 % ", r"dihedral angles +[\d.]+ to [\d.]+ degrees",
                    r"stable step +[\d.]+ ns", r"redrawn points +\d+ \([\d.]+ %\) in \d+ rounds",
                    r"time +[\d.]+ s for the realization",
                    r"partition +4 ranks: edge cut \d+ faces, imbalance [\d.]+ %"):
            self.assertRegex(result.stdout, rf"(?m)^{row}")
        with h5py.File(mesh) as root:
            self.assertEqual(len(root["VTKHDF/Points"]), int(re.search(r"nodes +(\d+)", result.stdout)[1]))
        self.assertNotIn("partition", mesh_of_the_demo()[0].stdout)

    def test_mass_scaling_lengthens_the_step(self):
        plate, mesh = (self.folder / name for name in ("plate.toml", "mesh.vtkhdf"))
        plate.write_text(DEMO.read_text().replace('step = "auto"', 'mass_scaling = "0.2 %"'))
        plain, scaled, checked = (result.stdout for result in (mesh_of_the_demo()[0], invoke(plate, "-o", mesh),
                                                               run_program("check", "--no-measure", plate)))
        step, longer, again = (float(re.search(r"stable step [ =]*([\d.]+) ns", text)[1]) for text in (plain, scaled, checked))
        row = r"mass scaling [ =]*[\d.]+ % of the mass, 0\.2 % in the corridor, at [\d.]+ % of the nodes: a step ([\d.]+) times as long"
        self.assertNotIn("mass scaling", plain)
        self.assertEqual(re.search(row, scaled)[1], re.search(row, checked)[1])
        self.assertEqual(longer, again)
        self.assertAlmostEqual(longer / step / float(re.search(row, checked)[1]), 1, delta=0.01)
        self.assertGreater(longer, 1.05 * step)
        self.assertIn("time.mass_scaling", checked)

    def test_regions_are_counted_and_drawn(self):
        plate, mesh = (self.folder / name for name in ("plate.toml", "mesh.vtkhdf"))
        plate.write_text(DEMO.read_text() + REGIONS)
        result = invoke(plate, "-o", mesh)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        with h5py.File(mesh) as root:
            points, region = (root[f"VTKHDF/{name}"][...] for name in ("Points", "PointData/region"))
            cells = root["VTKHDF/Connectivity"][...].reshape(-1, 4)

        def number(places):
            y, z = 1e3 * places[:, 1], 1e3 * places[:, 2]
            inner = (6 <= y) & (y <= 18.5) & (64 <= z) & (z <= 76)
            return [-1 if not outer else 0 if inner else 1 for inner, outer in zip(inner, (60 <= z) & (z <= 80))]

        np.testing.assert_array_equal(region, number(points))
        of_cells = number(points[cells].mean(axis=1))
        result = run_program("check", "--no-measure", plate)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        for name, which, spacing in ((r"mesh\.region\[0\]", 0, " at 0.8 mm"), (r"mesh\.region\[1\]", 1, " at 1.5 mm"),
                                     ("notches and rest", -1, "")):
            self.assertRegex(result.stdout, rf"(?m)^{name} += {region.tolist().count(which)} nodes, "
                                            rf"{of_cells.count(which)} tetrahedra{spacing}$")
        self.assertGreater(of_cells.count(0), 1000)
        self.assertNotIn("notches and rest", run_program("check", "--no-measure", DEMO).stdout)

        with h5py.File(mesh) as root:
            self.assertEqual(root["specimen/outline"].shape, (12, 2))
            np.testing.assert_allclose(root["specimen/size"], [5e-3, 24.5e-3, 140e-3])
            np.testing.assert_allclose(root["regions/box"][0], [[0, 5e-3], [6e-3, 18.5e-3], [64e-3, 76e-3]])
            np.testing.assert_allclose(root["regions/spacing"], [0.8e-3, 1.5e-3])
        axes = crackle.plot_mesh(mesh)
        shown = axes.collections[0]
        on_face = points[points[:, 0] == 0]
        self.assertAlmostEqual(shown.get_array().min(), 0.6, delta=0.05)
        self.assertGreater(shown.get_array().max(), 2.4)
        np.testing.assert_allclose(axes.dataLim.get_points(), 1e3 * np.array([on_face[:, 1:].min(axis=0), on_face[:, 1:].max(axis=0)]))
        areas = [np.cross(b - a, c - a) / 2 for a, b, c in (path.vertices[:3] for path in shown.get_paths())]
        self.assertAlmostEqual(abs(np.sum(np.abs(areas))), 24.5 * 140 - 2 * 6 * 0.6, delta=1)
        for wrong in (plate, self.folder / "missing.vtkhdf"):
            with self.assertRaisesRegex(crackle.ResultsError, wrong.name):
                crackle.plot_mesh(wrong)

    def test_materials_are_counted_and_drawn(self):
        plate, mesh = (self.folder / name for name in ("plate.toml", "mesh.vtkhdf"))
        material = re.search(r"(?s)\[material\]\n(.*?\n)\n", DEMO.read_text())[1]
        named = "".join(f'[[material]]\nname = "{name}"\n{material}' for name in ("plate", "disc"))
        plate.write_text(DEMO.read_text().replace("[material]\n" + material, named) + REGION_OF_A_DISC)
        result = invoke(plate, "-o", mesh)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        with h5py.File(mesh) as root:
            points, of_cells = (root[f"VTKHDF/{name}"][...] for name in ("Points", "CellData/material"))
            corners = points[root["VTKHDF/Connectivity"][...].reshape(-1, 4)]
        centre = 1e3 * corners.mean(axis=1)
        distance = np.hypot(centre[:, 1] - 12.25, centre[:, 2] - 100)
        self.assertTrue(np.all(of_cells[distance < 3.5] == 1))
        self.assertTrue(np.all(of_cells[distance > 4] == 0))
        volumes = 1e9 * np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
        checked = run_program("check", "--no-measure", plate)
        for number, name in enumerate(("plate", "disc")):
            volume = float(re.search(rf"(?m)^material {name} +(\d+) tetrahedra, ([\d.]+) mm\^3$", result.stdout)[2])
            self.assertAlmostEqual(volume, volumes[of_cells == number].sum(), delta=1e-5 * volume)
            self.assertRegex(checked.stdout, rf"(?m)^material {name} += {np.sum(of_cells == number)} tetrahedra, ")
        self.assertRegex(checked.stdout, r"(?m)^specimen\.region\[0\] += \d+ chords of up to .* inside the curve, area -")

    def test_one_strength_on_a_graded_mesh_is_warned_of(self):
        plate = self.folder / "plate.toml"
        graded = re.sub("(?m)^nucleation = .*\n", "", DEMO.read_text())
        even = graded + '[[mesh.region]]\ny = ["0 mm", "24.5 mm"]\nz = ["64 mm", "76 mm"]\nspacing = "0.6 mm"\n'
        tough = re.sub("(?m)^strength = .*$", 'toughness = "145 J/m^2"', graded)
        warning = (r"(?m)^Warning: with one strength the toughness follows the spacing, 145 to 366 J/m\^2 along the ligaments; "
                   r"make .* \[\[mesh\.region\]\], or give fracture\.toughness instead of fracture\.strength$")
        for text, warned in ((graded, True), (even, False), (tough, False)):
            plate.write_text(text)
            result = run_program("check", "--no-measure", plate)
            self.assertEqual((result.returncode, result.stderr), (0, ""))
            (self.assertRegex if warned else self.assertNotRegex)(result.stdout, warning if warned else "Warning")

    def test_the_strength_varies_as_asked_for(self):
        def factors(sample, variation):
            file, mesh = self.folder / "varied.toml", self.folder / "varied.vtkhdf"
            file.write_text(DEMO.read_text().replace('"140 us"', '"30 us"') + variation)
            run = invoke(file, "--sample", sample, "-o", mesh)
            self.assertEqual((run.returncode, run.stderr), (0, ""))
            with h5py.File(mesh) as root:
                found = root["VTKHDF/CellData/strength_factor"][...]
                corner = root["VTKHDF/Points"][...][root["VTKHDF/Connectivity"][...].reshape(-1, 4)]
            quantiles = [float(value) for value in re.findall(r"[\d.]+", re.search("strength factor (.*)", run.stdout)[1]
                                                              .replace("1 %", ""))]
            np.testing.assert_allclose(quantiles, [found.min(), np.quantile(found, 0.01), np.median(found), found.max()],
                                       atol=2e-3)
            return found, np.linalg.det(corner[:, 1:] - corner[:, :1])

        spread, volume = factors(0, VARIATION.format("lognormal", 'coefficient_of_variation = 0.2\ncorrelation_length = "2 mm"'))
        mean = np.average(spread, weights=volume)
        deviation = np.sqrt(np.average((spread - mean) ** 2, weights=volume))
        print(f"lognormal: over the volume mean {mean:.3f}, coefficient of variation {deviation / mean:.3f}")
        self.assertAlmostEqual(mean, 1, delta=0.03)
        self.assertAlmostEqual(deviation / mean, 0.2, delta=0.02)
        weibull = VARIATION.format("weibull", 'modulus = 10\ncorrelation_length = "0.5 mm"')
        other, found = (factors(sample, weibull)[0] for sample in (0, 1))
        self.assertNotEqual(other[0], found[0])
        shown = crackle.plot_mesh(self.folder / "varied.vtkhdf").collections[0].get_array()
        self.assertTrue(np.isin(shown, found).all())
        self.assertGreater(len(np.unique(shown)), 100)
        # The sample breaks with the field that its mesh shows.
        out = self.folder / "out"
        run = run_program("sample", self.folder / "varied.toml", "--sample", 1, "-o", out)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        with h5py.File(out / "samples" / "0001.h5") as root:
            np.testing.assert_array_equal(root["mesh/strength_factor"][...], found)
            stress, strength = root["breaks/principal_stress"][...], STRENGTH * found[root["breaks/tetrahedron"][...]]
        correlation = np.corrcoef(stress, strength)[0, 1]
        print(f"{len(stress)} breaks at {np.median(stress / strength):.3f} times the strength of their places, "
              f"correlation {correlation:.3f}")
        self.assertAlmostEqual(np.median(stress / strength), 1, delta=0.05)
        self.assertGreater(correlation, 0.9)
        check = run_program("check", self.folder / "varied.toml", "--no-measure")
        self.assertIn("the correlation length of the strength, 0.5 mm, is less than 2 spacings", check.stdout)
        long = (self.folder / "varied.toml").read_text().replace('correlation_length = "0.5 mm"', 'correlation_length = "1 m"')
        (self.folder / "long.toml").write_text(long)
        check = run_program("check", self.folder / "long.toml", "--no-measure")
        self.assertIn("the correlation length of the strength, 1 m, exceeds the body", check.stdout)

    def survey(self, *arguments, starts=False):
        """What the command returns, and the rows of its table. @param starts it in a process of its own"""
        table = self.folder / "survey.csv"
        words = [*arguments, "--table", table, "--program", PROGRAM]
        result = in_process.call(survey.main, *words) if not starts else subprocess.run(
            [TOOLS / "crackle-survey", *map(str, words)], capture_output=True, text=True, check=False, timeout=300)
        with table.open() as file:
            return result, list(csv.DictReader(file))

    def test_survey_counts_what_it_lists(self):
        result, rows = self.survey(DEMO, 3)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertEqual([row["sample"] for row in rows], ["0", "1", "2"])
        self.assertTrue(all(row["conforms"] == "1" for row in rows))
        self.assertRegex(result.stdout, "(?m)^realizations +3 of seed 2012: 3 conform, 0 failed$")
        worst = min(float(row["worst_quality"]) for row in rows)
        self.assertRegex(result.stdout, rf"worst quality +min {worst:.4f}")
        mean = sum(int(row["redrawn_points"]) for row in rows) / len(rows)
        nodes = int(re.search(r"nodes +(\d+)", result.stdout)[1])
        self.assertRegex(result.stdout, rf"redrawn points +mean {100 * mean / nodes:.3f} %")
        for row in rows:
            self.assertAlmostEqual(sum(float(row[f"share_{axis}"]) for axis in "xyz"), 1, places=5)
            self.assertGreater(float(row["mesh_s"]), 0)
        for order, bound in (("2nd", 0.02), ("4th", 0.03)):
            self.assertLess(float(re.search(rf"(?m)^  bias, {order} order .*, of their mean tensor ([\d.]+)$", result.stdout)[1]), bound)
        # Uniform in a ball.
        number = int(re.search(r"(?m)^displacements +(\d+) in the interior", result.stdout)[1])
        means = re.search(r"(?m)^  mean +([-\d.]+), ([-\d.]+), ([-\d.]+) \(x", result.stdout).groups()
        variances = re.search(r"(?m)^  covariance +([\d.]+), ([\d.]+), ([\d.]+) \(xx", result.stdout).groups()
        for mean, variance in zip(means, variances):
            self.assertAlmostEqual(float(mean), 0, delta=4 * np.sqrt(0.2 / number))
            self.assertAlmostEqual(float(variance), 0.2, delta=4 * np.sqrt(0.2 / number))
        # The first one once more, apart from the time that it takes.
        for row, again in zip(rows, self.survey(DEMO, 1)[1]):
            self.assertEqual({**row, "mesh_s": ""}, {**again, "mesh_s": ""})

    def test_survey_goes_on_after_a_mesh_that_fails(self):
        own = DEMO.read_text().replace('base = "shared"', 'base = "own"')
        random = '[[random]]\nkey = "mesh.min_quality"\ndistribution = "uniform"\nlower = -0.5\nupper = 0.4\n'
        (self.folder / "plate.toml").write_text(f"{own}\n{random}")
        result, rows = self.survey(self.folder / "plate.toml", 4, starts=True)
        failed = [row["sample"] for row in rows if row["conforms"] == "0"]
        self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
        self.assertEqual(failed, ["2"])
        self.assertEqual(re.findall(r"(?m)^crackle-survey: sample (\d):", result.stderr), failed)
        self.assertRegex(result.stdout, rf"(?m)^realizations +4 of seed 2012: {4 - len(failed)} conform, {len(failed)} failed$")

    def test_tetrahedra_of_the_fine_zone_are_marked(self):
        result, content = mesh_of_the_demo()
        self.assertEqual(result.returncode, 0)
        with h5py.File(io.BytesIO(content)) as root:
            points, corners = root["VTKHDF/Points"][...], root["VTKHDF/Connectivity"][...].reshape(-1, 4)
            spacing, refined = root["VTKHDF/PointData/spacing"][...], root["VTKHDF/CellData/refined"][...]
        x, of_cell = points[corners, 0].mean(axis=1), spacing[corners]
        self.assertGreater(refined.sum(), 100)
        self.assertLess(of_cell[refined == 1].min(axis=1).max(), 2 * 0.6e-3)
        self.assertGreater(np.minimum(x, 5e-3 - x)[refined == 1].min(), 2 * of_cell[refined == 1].min())
        deep = (np.minimum(x, 5e-3 - x) > 2 * of_cell.max(axis=1)) & (of_cell.max(axis=1) < 2 * 0.6e-3)
        self.assertGreater(refined[deep].mean(), 0.4)  # others are near a slot

    def test_wrong_options(self):
        mesh = self.folder / "mesh.vtkhdf"
        for arguments, reason in (((DEMO,), "--output is required"),
                                  ((DEMO, "--ranks", 0, "-o", mesh), "not in range 1 to 10000"),
                                  ((DEMO, "--sample", -1, "-o", mesh), "'-1' is not a sample number"),
                                  ((DEMO, "--sample", 8, "-o", mesh), "there is no sample 8: ensemble.samples = 8")):
            result = invoke(*arguments)
            self.assertEqual((result.returncode, result.stdout), (1, ""), arguments)
            self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
            self.assertIn(reason, result.stderr)
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_files_of_other_kinds_stay(self):
        other = self.folder / "plate.toml"
        other.write_text("mine")
        for arguments in (("-o", other), ("-o", self.folder / "mesh.vtkhdf", "--dual-facets", other)):
            result = invoke(DEMO, *arguments)
            self.assertEqual((result.returncode, other.read_text()), (1, "mine"))
            self.assertIn("plate.toml exists and is no VTKHDF file; give another name", result.stderr)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", required=True)
    options, rest = parser.parse_known_args()
    PROGRAM = os.path.abspath(options.program)
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
