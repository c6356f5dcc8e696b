#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fragments of struck plates: tables, statistics beside NumPy and SciPy, pictures, any number of ranks."""
from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np
from scipy import stats

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "cli")]

import command_lines  # noqa: E402
import crackle  # noqa: E402
import in_process  # noqa: E402
from effort import repetitions  # noqa: E402
from crackle_report import paraview  # noqa: E402
from crackle_report.fields import Tool  # noqa: E402
from crackle_report.figures import fragments  # noqa: E402
from crackle_report.sample_files import SampleFiles  # noqa: E402
from crackle_launch import environment  # noqa: E402

OPTIONS: argparse.Namespace
STRUCK = """[ensemble]
samples = 4
seed = 3
[specimen]
size = ["1 mm", "12 mm", "12 mm"]
[mesh]
spacing = "0.7 mm"
[material]
youngs_modulus = "70 GPa"
poisson_ratio = 0.22
density = "2500 kg/m^3"
[fracture]
strength = "40 MPa"
[[tool]]
name = "ball"
shape = "sphere"
at = ["2.6 mm", "6 mm", "6 mm"]
radius = "1.5 mm"
mass = "0.1 g"
velocity = ["-150 m/s", "0 m/s", "0 m/s"]
[time]
start = "rest"
duration = "30 us"
integrator = "verlet"
precision = "double"
[sections]
y = ["6 mm"]
[output]
frames = 3
"""
MASS = 2500 * 1e-3 * 12e-3 * 12e-3  # [kg]


def invoke(*words: object) -> str:
    done = command_lines.crackle(OPTIONS.program, *words)
    if done.returncode != 0:
        raise RuntimeError(f"crackle {words[0]} ended with status {done.returncode}: {done.stderr}")
    return done.stdout


class Fragments(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        cls.input, cls.out = cls.folder / "struck.toml", cls.folder / "out"
        cls.input.write_text(STRUCK)
        invoke("run", cls.input, "-o", cls.out)
        cls.ensemble = crackle.open(cls.out)

    def test_a_table_holds_the_whole_body(self):
        self.assertGreater(max(len(sample.fragments) for sample in self.ensemble), 3)
        for sample in self.ensemble:
            table, dust = sample.fragments, sample.fragments.attrs["dust"]
            print(f"sample {sample.number}: {len(table)} fragments, largest {table['share'][0]:.3f}, dust {dust['nodes']} nodes")
            self.assertTrue((np.diff(table["mass"]) <= 0).all())
            self.assertTrue((table["nodes"] > 1).all())
            np.testing.assert_allclose(table["mass"].sum() + dust["mass"], MASS, rtol=1e-12)
            np.testing.assert_allclose(table["volume"].sum() + dust["volume"], MASS / 2500, rtol=1e-12)
            np.testing.assert_allclose(table["share"].sum() + dust["mass"] / MASS, 1, rtol=1e-12)
            np.testing.assert_allclose(table["kinetic"].sum() + dust["kinetic"], sample.energy["kinetic"][-1], rtol=1e-9)
            self.assertTrue((table["kinetic_of_mean"] <= table["kinetic"] * (1 + 1e-12)).all())
            with sample.open() as root:
                of_node, nodes, last = root["fragments/of_node"][...], root["mesh/nodes"][...], root["frames/velocity"][-1]
            for number, row in table.iterrows():
                own = np.flatnonzero(of_node == number)
                self.assertEqual((own[0], len(own)), (row["first_node"], row["nodes"]))
                np.testing.assert_allclose(np.ptp(nodes[own], axis=0), row[["dx", "dy", "dz"]].astype(float), rtol=1e-12)
                low, high = last[own].min(axis=0), last[own].max(axis=0)  # single precision
                velocity = row[["vx", "vy", "vz"]].astype(float)
                self.assertTrue((low - 1e-4 <= velocity).all() and (velocity <= high + 1e-4).all())
            self.assertEqual(np.count_nonzero(of_node < 0), dust["nodes"])

    def test_numbers_over_time_end_with_the_table(self):
        for sample in self.ensemble:
            history, table = sample.fragment_history, sample.fragments
            self.assertTrue(np.isin(history["time"], sample.energy["time"]).all())
            self.assertEqual((history["time"][0], history["time"][-1]), (0, sample.energy["time"][-1]))
            self.assertGreater(history.sizes["moment"], 40)
            self.assertEqual((history["number"][0], history["dust"][0]), (1, 0))
            np.testing.assert_allclose(history["largest_mass"][0], MASS, rtol=1e-12)
            self.assertTrue((np.diff(history["largest_mass"]) <= 0).all())
            for name, value in (("number", len(table)), ("largest_mass", table["mass"][0]), ("second_mass", [*table["mass"], 0][1]),
                                ("dust", table.attrs["dust"]["nodes"]), ("dust_mass", table.attrs["dust"]["mass"])):
                self.assertEqual(history[name][-1], value, name)

    def test_statistics_are_those_of_the_tables(self):
        tables = [sample.fragments for sample in self.ensemble]
        with h5py.File(self.out / "ensemble.h5") as root:
            rows = {name: found[...] for name, found in root["fragments"].items()}
            found = {name: value[()] for name, value in root["statistics/fragments"].items()}
        expected = {"number": [len(table) for table in tables], "largest_mass": [table["mass"][0] for table in tables],
                    "mean_mass": [table["mass"].mean() for table in tables], "median_mass": [table["mass"].median() for table in tables],
                    "dust_mass": [table.attrs["dust"]["mass"] for table in tables], "body_mass": [MASS] * 4,
                    "fastest": [np.linalg.norm(table[["vx", "vy", "vz"]], axis=1).max() for table in tables],
                    "kinetic_energy": [table["kinetic_of_mean"].sum() for table in tables], "frozen": [0] * 4}
        for name, values in expected.items():
            np.testing.assert_allclose(rows[name], values, rtol=1e-12, err_msg=name)
            np.testing.assert_allclose(found[f"{name}_mean"], np.mean(values), rtol=1e-12, err_msg=name)
            np.testing.assert_allclose(found[f"{name}_std"], np.std(values, ddof=1), rtol=1e-9, atol=1e-18, err_msg=name)
            half = stats.t.ppf(0.975, 3) * np.std(values, ddof=1) / 2
            np.testing.assert_allclose(found[f"{name}_half_width"], half, rtol=1e-9, atol=1e-18, err_msg=name)
        heavier = np.array([[(table["share"] >= share).sum() for share in rows["shares"]] for table in tables])
        np.testing.assert_array_equal(rows["heavier"], heavier)
        np.testing.assert_allclose(found["heavier_mean"], heavier.mean(axis=0), rtol=1e-12)
        np.testing.assert_allclose(found["heavier_half_width"], stats.t.ppf(0.975, 3) * heavier.std(axis=0, ddof=1) / 2, rtol=1e-9, atol=1e-18)
        others = [table["share"][2:].sum() for table in tables]
        fragmented = int(np.sum(np.array(others) >= 0.01))
        self.assertGreater(fragmented, 0)
        self.assertEqual((found["counted"], found["fragmented"]), (4, fragmented))
        document = json.loads(invoke("stats", self.out, "--json"))
        self.assertEqual(document["fragments"]["number"], expected["number"])
        np.testing.assert_allclose([one["mean"] for one in document["statistics"]["fragments"]["heavier"]], heavier.mean(axis=0), rtol=1e-12)
        text = invoke("stats", self.out)
        self.assertIn(f"more than two in {fragmented} of 4 samples", text)
        self.assertRegex(text, rf"\n *fragments +{np.mean(expected['number']):.1f} ")
        together = self.ensemble.fragments
        self.assertEqual(len(together), sum(map(len, tables)))

    def test_any_number_of_ranks_gives_the_same_bits(self):
        one = self.ensemble[1]
        for n_ranks in repetitions((3,), (2, 3, 4)):
            folder = self.folder / f"ranks-{n_ranks}"
            subprocess.run([*OPTIONS.mpirun.split(), "-n", str(n_ranks), OPTIONS.program, "sample", self.input, "--sample", "1", "-o", folder],
                           check=True, capture_output=True, env={**environment(), "OMPI_MCA_mpi_yield_when_idle": "1"})
            other = crackle.open(folder)[1]
            self.assertTrue(other.fragments.equals(one.fragments), n_ranks)
            self.assertTrue(other.fragment_history.equals(one.fragment_history), n_ranks)

    def test_tools_are_drawn_where_they_are(self):
        ball, = SampleFiles(self.out).tools(1)
        corners = ball.outline(0)
        np.testing.assert_allclose(np.hypot(*(corners - 6e-3).T), 1.5e-3, rtol=1e-12)
        self.assertLess(ball.position[-1, 0], 0.0026 - 0.5 * 150 * ball.time[-1])
        at_rest = {"time": np.array([0, 1]), "position": np.array([(0, 2, 3), (0, 4, 3)]), "radius": 0.5}
        for shape, axis, size, low, high in (("cylinder", (1, 0, 0), (), (2.5, 2.5), (3.5, 3.5)), ("cylinder", (0, 0, 2), (4,), (2.5, 1), (3.5, 5)),
                                             ("box", (0, 0, 0), (9, 2, 4), (2, 1), (4, 5)), ("plane", (0, 0, -1), (), (2, 3), (4, 3))):
            corners = Tool(shape=shape, axis=np.array(axis), size=np.array(size), **at_rest).outline(0.5)
            np.testing.assert_allclose((corners.min(axis=0), corners.max(axis=0)), (low, high), atol=1e-9, err_msg=shape)
        quarter = np.tile(np.array((1, 1, 0, 0)) / np.sqrt(2), (2, 1))
        corners = Tool(shape="box", axis=np.zeros(3), size=np.array((9, 2, 4)), orientation=quarter, **at_rest).outline(0.5)
        np.testing.assert_allclose((corners.min(axis=0), corners.max(axis=0)), ((1, 2), (5, 4)), atol=1e-9)
        self.assertEqual(len(Tool(shape="plane", axis=np.array((1, 0, 0)), size=np.array(()), **at_rest).outline(0)), 0)

    def test_pictures_show_them(self):
        result = in_process.report(self.out, "--program", OPTIONS.program, "--no-animation", sections=(fragments.section,))
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertTrue((self.out / "report/fragments.png").is_file())
        self.assertIn("Fragments are pieces of the body", (self.out / "report.html").read_text())
        in_process.call(paraview.main, self.out, "--sample", "2").check_returncode()
        with self.ensemble[2].open() as root:
            of_node, corners = root["fragments/of_node"][...], root["mesh/tetrahedra"][...]
        with h5py.File(self.out / "paraview/0002/frame-0001.vtkhdf") as root:
            of_point, of_cell = (root[f"VTKHDF/{kind}/fragment"][...] for kind in ("PointData", "CellData"))
        np.testing.assert_array_equal(of_point, of_node)
        same = (of_node[corners] == of_node[corners[:, :1]]).all(axis=1)
        np.testing.assert_array_equal(of_cell, np.where(same, of_node[corners[:, 0]], -1))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=Path, required=True)
    parser.add_argument("--mpirun", required=True)
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0], *rest])
