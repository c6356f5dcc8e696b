#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""tools/benchmark --peers without the other programs, and --scaling: arguments, what they hand to programs, and tables."""
from __future__ import annotations

import argparse
import copy
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "cli"), str(ROOT / "tests" / "benchmark"), str(ROOT / "tools")]

import command_lines  # noqa: E402
import peers  # noqa: E402
import scaling  # noqa: E402
from crackle_readme import block  # noqa: E402
from crackle_runs import with_keys  # noqa: E402

PROGRAM = ""
SIZE = np.array([5e-3, 24.5e-3, 140e-3])  # [m]
FIGURES = {
    "input": "plate.toml", "processor": "P", "versions": {"DOLFINx": "0.5.2", "CalculiX": "2.20", "LAMMPS": "20220106"}, "rounds": 3,
    "steps": 100, "tetrahedra": 293700, "force_of_dolfinx": "MatMult",
    "programs": {
        "crackle": {"points": 50000, "step": 50e-9, "seconds": {"1": [1e-3, 2e-3, 4e-3], "2": [1e-3, 1e-3, 1e-3]}},
        "CalculiX": {"points": 50000, "step": 5e-9, "seconds": {"1": [0.5], "2": [0.25]}, "difference": -2e-7},
        "LAMMPS, peri/lps": {"points": 48000, "step": 500e-9, "seconds": {"1": [0.1], "2": [0.05]}, "difference": 0.012}}}


class Peers(unittest.TestCase):
    def test_arguments_that_do_not_fit_are_refused_before_anything_is_built(self):
        for arguments, message in ((["--peers", "--samples", "3"], "--samples does not go with --peers"),
                                   (["--readme"], "--readme needs --peers or --scaling"),
                                   (["--peers", "--scaling"], "--peers does not go with --scaling"), (["--peers", "--input", "none.toml"], "there is no file"),
                                   (["--peer"], "unknown argument '--peer'")):
            result = subprocess.run([ROOT / "tools" / "benchmark", *arguments], capture_output=True, text=True, check=False)
            self.assertEqual((result.returncode, result.stdout), (1, ""))
            self.assertIn(message, result.stderr)

    def test_the_table_has_rates_costs_and_differences(self):
        titles, _, *rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in peers.table(FIGURES).splitlines() if line.startswith("|")]
        self.assertEqual((titles[0], [row[0] for row in rows]),
                         ("`plate.toml`, 293,700 tetrahedra, P", ["crackle", "CalculiX 2.20", "LAMMPS 20220106 `peri/lps`"]))
        self.assertEqual(rows[0][1:], ["50,000", "50 ns", "25 (12.5 to 50)", "50 (50 to 50)", "4 s", "4 s", ""])
        self.assertEqual(rows[1][1:], ["50,000", "5 ns", "0.1 (0.1 to 0.1)", "0.2 (0.2 to 0.2)", "2.8 h", "2.8 h", "-2e-05 %"])
        self.assertEqual(rows[2][5:], ["20 s", "20 s", "+1.2 %"])
        self.assertIn("its 100 µs would take 17 min", peers.table(FIGURES))
        without = copy.deepcopy(FIGURES)
        del without["versions"]["CalculiX"]
        self.assertIn("| CalculiX |", peers.table(without))

    def test_durations(self):
        for seconds, text in ((0.123, "0.12 s"), (99.7, "100 s"), (119, "119 s"), (150, "2.5 min"), (7200, "2 h"), (720_000, "200 h")):
            self.assertEqual(peers.duration_text(seconds), text)

    def test_the_page_has_all_programs(self):
        first = [line.split("|")[1].strip() for line in block("peers").splitlines() if line.startswith("|")][2:]
        for name, row in zip(("crackle", "crackle, cracks running", "DOLFINx", "CalculiX", "LAMMPS", "LAMMPS"), first, strict=True):
            self.assertTrue(row.startswith(name), row)

    def test_the_input_of_a_sudden_load_is_valid(self):
        for name in ("paper.toml", "paper/clock-from-zero.toml"):
            coarse = with_keys((ROOT / "jobs" / name).read_text(encoding="utf-8"),
                               {"mesh.spacing": '"3 mm"', "mesh.notch_spacing": '"1 mm"', "mesh.growth": "0.2"})
            text = peers.pulled(coarse, "auto", 1e-4, 1e-5)
            with tempfile.TemporaryDirectory() as folder:
                file = Path(folder) / "pulled.toml"
                file.write_text(text, encoding="utf-8")
                result = command_lines.crackle(PROGRAM, "check", "--no-measure", str(file))
            self.assertEqual((result.returncode, result.stderr), (0, ""))
            self.assertNotIn("rate", text)

    def test_the_load_is_shared_as_by_linear_triangles(self):
        nodes = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [1, 0, 1], [0, 1, 1]], dtype=float)
        tetrahedra = np.array([[0, 3, 5, 6], [1, 5, 4, 0], [5, 6, 4, 0]])  # two triangles at z = 1
        force = peers.nodal_force({"nodes": nodes, "tetrahedra": tetrahedra})
        np.testing.assert_allclose(force, peers.FORCE / 6 * np.array([0, 0, 0, 1, 1, 2, 2]), rtol=1e-12)

    def test_the_lattice_is_as_dense_as_the_mesh(self):
        for n_nodes in (2_000, 55_000):
            lattice = peers.Lattice(SIZE, n_nodes)
            self.assertLess(abs(lattice.n_points / n_nodes - 1), 0.25)
            np.testing.assert_allclose(lattice.shape * lattice.spacing, SIZE, atol=lattice.spacing / 2)

    def test_the_stable_step_of_a_lattice(self):
        lattice = peers.Lattice(SIZE, 55_000)
        steps = {law: lattice.stable_step(law) for law in ("pmb", "lps")}
        # The fastest plane wave of an endless lattice; surfaces make a little difference.
        shifts = np.stack(np.meshgrid(*3 * (np.arange(-3, 4),), indexing="ij"), axis=-1).reshape(-1, 3)
        length = np.linalg.norm(shifts, axis=1)
        shifts, length = (values[(length > 0) & (length <= 3)] for values in (shifts, length))
        bonds = lattice.coefficients("pmb")[0] * lattice.spacing**2 * np.where(length > 2.5, 3.5 - length, 1) / length**3
        fastest = max(np.linalg.eigvalsh(shifts.T * (bonds * (1 - np.cos(np.pi / 6 * (shifts @ wave)))) @ shifts)[-1]
                      for wave in np.ndindex(7, 7, 7))
        endless = 2 / np.sqrt(fastest / peers.DENSITY)
        self.assertGreater(steps["pmb"], endless)
        self.assertLess(steps["pmb"], 1.06 * endless)
        self.assertLess(steps["lps"], steps["pmb"])

    def test_the_script_for_lammps_leaves_out_bonds_across_notches(self):
        slots = np.array([[[0, 2.5e-3], [66.7e-3, 67.3e-3]], [[22e-3, 24.5e-3], [72.7e-3, 73.3e-3]]])
        lattice = peers.Lattice(SIZE, 2_000)
        script = peers.Lammps(Path(), {"slots": slots, "size": SIZE}, lattice, "lps", 1e-6, 10).script()
        self.assertEqual(script.count("set region"), 4)
        self.assertIn(f"pair_coeff 2 3 {' '.join(map(str, lattice.coefficients('lps')))} {lattice.spacing / 2} ", script)
        self.assertLess(script.index("run 0\n"), script.index("run 10\n"))


PLANS = """
tetrahedra         = about 1.04e+08

Plans for 1025 ranks and 200 samples, on cores as this one with messages of 2 us and 1 GB/s per rank:
ranks per sample  groups  tetrahedra/rank  memory/root  memory/other       sample  efficiency     ensemble
               1    1024        104000000      45.1 GB             -  25 h 10 min       100 %  25 h 15 min
               2     512         52100000      22.4 GB       22.2 GB  12 h 40 min        99 %  12 h 50 min  groups wait for meshes
recommended: ensemble.ranks_per_sample = 2
Of a shared sample METIS takes 3 min 20 s, on one core, to divide the mesh.
"""


class Scaling(unittest.TestCase):
    def test_the_plans_are_read(self):
        found = scaling.plans(PLANS)
        self.assertEqual((found["tetrahedra"], found["for"], found["network"], found["recommended"], found["division"]),
                         (1.04e8, "1025 ranks and 200 samples", "2 us and 1 GB/s per rank", 2, "3 min 20 s"))
        self.assertEqual([(row["groups"], row["memory/other"], row["sample"]) for row in found["plans"]],
                         [("1024", "-", "25 h 10 min"), ("512", "22.2 GB", "12 h 40 min")])

    def test_the_meshes_are_alike(self):
        text = (ROOT / "jobs/paper/clock-from-zero.toml").read_text(encoding="utf-8")
        fine = scaling.scaled(text, 0.5)
        changed = set(fine.splitlines()) - set(text.splitlines())
        self.assertEqual(changed, {'spacing = "0.5 mm"', 'notch_spacing = "0.15 mm"', "growth = 0.015"})

    def test_the_table_of_steps(self):
        steps = [{"mesh": mesh, "ranks": n, "tetrahedra": size, "step": step, "check": step / 4, "exchange": step / 10}
                 for mesh, n, size, step in (("once", 1, 100, 1e-3), ("once", 2, 100, 0.6e-3), ("fine", 1, 1000, 1e-2), ("fine", 2, 1000, 0.5e-2),
                                             ("twice", 2, 200, 1.25e-3))]
        rows = [line.split("|")[1:-1] for line in scaling.steps_table(steps).splitlines()[2:]]
        self.assertEqual([row[-2].strip() for row in rows], ["", "83 %", "", "100 %", "80 %"])
        self.assertEqual([cell.strip() for cell in rows[1]], ["strong", "100", "2", "0.6 ms", "25 %", "83 %", "0.06 ms"])

    def test_the_page_has_the_tables(self):
        text = block("scaling")
        self.assertEqual(len(re.findall(r"(?m)^\|[-|]+\|$", text)), 4)
        # The law that the estimate of memory assumes (compact_part).
        ghosts = [float(row.split("|")[5]) for row in text.splitlines() if row.startswith("|") and " kB |" in row]
        self.assertEqual(len(ghosts), len(scaling.PARTS))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    options, rest = parser.parse_known_args()
    PROGRAM = os.environ["CRACKLE"] = os.path.abspath(options.program)
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
