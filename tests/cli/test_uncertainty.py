#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Random inputs and sweeps through the program: known answers, draws that fail, any ranks, stopped and continued."""
from __future__ import annotations

import argparse
import csv
import json
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "tools"))

import command_lines  # noqa: E402
from crackle_launch import environment, mpirun  # noqa: E402
from effort import repetitions  # noqa: E402

PROGRAM = Path()
PLATE = (ROOT / "tests" / "support" / "plate.toml").read_text().replace('"100 N"', '"5 N"').replace('step = "20 ns"', 'step = "auto"')
BAR = """
[ensemble]
samples = 64
plan = "sobol"
[specimen]
size = ["2 mm", "2 mm", "6 mm"]
[mesh]
spacing = "1 mm"
base = "own"
min_quality = 0.1
[material]
youngs_modulus = "3 GPa"
poisson_ratio = 0
density = "1000 kg/m^3"
[fracture]
strength = "30 MPa"
impulse = "1e-12 MPa^2 s"
[[boundary]]
on = "z-min"
fix = ["x", "y", "z"]
[[boundary]]
on = "z-max"
displacement = ["free", "free", "0 mm"]
rate = ["free", "free", "1 um/s"]
[time]
duration = "2 us"
arrest = "1 us"
[sections]
z = ["3 mm"]
[output]
frames = 2
[[random]]
key = "fracture.strength"
distribution = "lognormal"
standard_deviation = "6 MPa"
[[random]]
key = "material.youngs_modulus"
distribution = "lognormal"
standard_deviation = "300 MPa"
[[random]]
key = "specimen.size[0]"
distribution = "uniform"
lower = "1.5 mm"
upper = "2.5 mm"
"""
DEPTHS = """
[[random]]
key = "specimen.notch[0].depth"
distribution = "uniform"
lower = "1 mm"
upper = "10 mm"
"""
SWEEP = """
[[sweep]]
key = "fracture.release"
values = ["element", "facet"]
[[sweep]]
key = "mesh.perturbation"
values = [0.05, 0.1]
"""


def datasets(file: Path) -> dict[str, tuple]:
    """Type, shape and bytes (texts as such) of each dataset, but for what differs between two runs."""
    found = {}
    with h5py.File(file) as root:
        def take(name: str, item: h5py.HLObject) -> None:
            if isinstance(item, h5py.Dataset) and name.partition("/")[0] not in ("provenance", "timing"):
                value = np.asarray(item[()])
                found[name] = (item.dtype, item.shape, value.tolist() if value.dtype.hasobject else value.tobytes())
        root.visititems(take)
    return found


def same_content(one: Path, other: Path) -> bool:
    """Bit by bit."""
    return datasets(one) == datasets(other)


class Uncertainty(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def write(self, text: str, name: str = "input.toml") -> str:
        (self.folder / name).write_text(text)
        return name

    def call(self, *arguments: str, ranks: int = 1, status: int = 0) -> str:
        if ranks == 1:
            result = command_lines.crackle(PROGRAM, *arguments, cwd=self.folder)
        else:
            result = subprocess.run([*mpirun(ranks), str(PROGRAM), *arguments], capture_output=True, text=True, check=False,
                                    cwd=self.folder, env=environment(), timeout=500)
        self.assertEqual(result.returncode, status, result.stdout[-2000:] + result.stderr[-2000:])
        return result.stdout + result.stderr

    def statistics(self, folder: str) -> dict:
        return json.loads(self.call("stats", "--json", folder))

    # Random inputs

    def test_a_bar_breaks_where_and_because_theory_says(self):
        self.call("run", self.write(BAR), "-o", "out")
        with h5py.File(self.folder / "out" / "ensemble.h5") as file:
            inputs = {key: data[:] for key, data in file["samples/inputs"].items()}
            units = {key: data.attrs["units"] for key, data in file["samples/inputs"].items()}
            force, moment = file["samples/first_break_load"][:], file["samples/first_break_time"][:]
        self.assertEqual({str(key): unit if isinstance(unit, str) else unit.decode() for key, unit in units.items()},
                         {"fracture.strength": "Pa", "material.youngs_modulus": "Pa", "specimen.size[0]": "m"})
        strength, modulus, thickness = (inputs[key] for key in
                                        ("fracture.strength", "material.youngs_modulus", "specimen.size[0]"))
        worst = [np.abs(force / (strength * thickness * 2e-3) - 1).max(), np.abs(moment / (strength / modulus * 6e-3 / 1e-6) - 1).max()]
        print(f"\nfirst break of {force.size} bars against strength x area and strain x length: {worst[0]:.1e} and {worst[1]:.1e}")
        self.assertLess(max(worst), 1e-6)

        # Of a product of independent factors, with v the squared coefficients of variation.
        results = {result["result"]: result for result in self.statistics("out")["sensitivities"]["results"]}
        for name, factors in (("first_break_load", [0.2**2, 0, (1 / np.sqrt(12) / 2)**2]), ("first_break_time", [0.2**2, 0.1**2, 0])):
            whole = np.prod([1 + v for v in factors]) - 1
            for k, v in enumerate(factors):
                found = results[name]["inputs"][k]
                first, total = v / whole, v / (1 + v) * (whole + 1) / whole
                print(f"{name}, input {k}: first {found['first']['value']:.3f} (exact {first:.3f}), "
                      f"total {found['total']['value']:.3f} (exact {total:.3f})")
                self.assertAlmostEqual(found["first"]["value"], first, delta=0.04)
                self.assertAlmostEqual(found["total"]["value"], total, delta=0.04)
        self.assertGreater(results["first_break_load"]["predicted"], 0.98)

    def test_a_draw_that_is_no_body_fails_as_a_sample(self):
        # With a deeper notch no crack could reach the section, and with one as deep as the plate is wide there is no body.
        text = PLATE.replace('base = "shared"\n', "").replace('["3 mm", "4 mm"]', '["6 mm"]').replace('"5 N"', '"1 N"')
        name = self.write(text + DEPTHS.replace('"10 mm"', '"12 mm"'))
        checked = self.call("check", "--no-measure", name)
        output = self.call("run", name, "-o", "out", ranks=2, status=2)
        rows = self.statistics("out")
        depth = np.array(rows["inputs"][0]["values"])
        failed = np.array(rows["samples"]["status"]) == 2
        width = float(re.search(r'size = \["[\d.]+ mm", "([\d.]+) mm"', PLATE)[1]) * 1e-3
        print(f"depths {np.round(1e3 * depth, 2).tolist()} mm in a width of {1e3 * width:g} mm")
        self.assertTrue(failed.any() and not failed.all())
        self.assertTrue(((depth > 6e-3) & ~failed).any())
        np.testing.assert_array_equal(failed, depth >= width)
        for position in np.array(rows["crack_path"]["position"], float)[(depth > 6e-3) & ~failed]:
            self.assertTrue(np.isnan(position[0]).all(), "where the notch is, its crack has no crossing")
        self.assertIn(f"Warning: {failed.sum()} of 6 draws will fail; the first: the drawn values do not give a valid input", checked)
        self.assertIn("failed: sample", output)
        self.assertIn("specimen.notch[0].depth = ", np.array(rows["samples"]["error"])[failed][0])

    def test_samples_are_the_same_on_any_ranks(self):
        text = PLATE.replace("samples = 6", "samples = 3\nreplicates = 2").replace('base = "shared"\n', "") + \
            DEPTHS.replace('"10 mm"', '"3 mm"')
        self.call("run", self.write(text), "-o", "one")
        self.call("run", self.write(text.replace("seed = 1", "seed = 1\nranks_per_sample = 2"), "shared.toml"), "-o", "shared", ranks=3)
        self.call("sample", "shared.toml", "--sample", "2", "-o", "alone", ranks=3)
        for sample in range(3):
            self.assertTrue(same_content(self.folder / f"one/samples/000{sample}.h5", self.folder / f"shared/samples/000{sample}.h5")
                            or self.same_summary(f"one/samples/000{sample}.h5", f"shared/samples/000{sample}.h5"))
        self.assertTrue(self.same_summary("one/samples/0002.h5", "alone/samples/0002.h5"))
        with h5py.File(self.folder / "one/samples/0000.h5") as first, h5py.File(self.folder / "one/samples/0001.h5") as second:
            key = "summary/inputs/specimen.notch[0].depth"
            self.assertEqual(first[key][()], second[key][()], "replicates")
            self.assertFalse(np.array_equal(first["mesh/nodes"][:], second["mesh/nodes"][:]), "on different meshes")

    def same_summary(self, one: str, other: str) -> bool:
        """Of files whose inputs differ in how they are computed: the mesh and all results."""
        with h5py.File(self.folder / one) as a, h5py.File(self.folder / other) as b:
            return all(np.array_equal(a[name][()], b[name][()], equal_nan=True)
                       for name in ("mesh/nodes", "breaks/tetrahedron", "breaks/phase_time", "frames/displacement",
                                    "summary/onset_force", "summary/crack_area"))

    def test_which_ensembles_can_be_extended(self):
        for plan, extends in (("sobol", True), ("independent", True), ("latin-hypercube", False)):
            text = PLATE.replace("samples = 6", f'samples = 2\nplan = "{plan}"').replace('base = "shared"\n', "") + \
                DEPTHS.replace('"10 mm"', '"3 mm"')
            self.call("run", self.write(text), "-o", plan)
            before = (self.folder / plan / "samples" / "0001.h5").read_bytes()
            output = self.call("run", self.write(text.replace("samples = 2", "samples = 3")), "-o", plan, "--resume",
                               status=0 if extends else 1)
            self.assertEqual((self.folder / plan / "samples" / "0001.h5").read_bytes(), before)
            self.assertIn("1 of 3 samples to compute" if extends else "ensemble.samples is 3, not 2", output)

    # Sweeps

    def test_a_sweep_is_its_cases_also_when_it_was_stopped_and_resumed(self):
        name = self.write(PLATE.replace("samples = 6", "samples = 3") + SWEEP)
        process = subprocess.Popen([str(PROGRAM), "run", name, "-o", "out"], cwd=self.folder, env=environment(),
                                   stdout=subprocess.PIPE, text=True)
        for line in process.stdout:
            if "sample 0 done" in line:
                process.send_signal(signal.SIGTERM)
                break
        rest = process.stdout.read()
        process.stdout.close()
        self.assertEqual(process.wait(timeout=100), 3, rest)
        self.assertIn("to continue: ", rest)
        done = len(list((self.folder / "out").glob("case-*/samples/*.h5")))
        self.assertTrue(0 < done < 12, done)
        output = self.call("run", name, "-o", "out", "--resume", ranks=3)
        self.assertIn("4 cases: 12 done, 0 failed, 0 pending", output)
        if repetitions(False, True):
            self.call("run", name, "-o", "whole")
            self.assertEqual((self.folder / "out/summary.csv").read_text(), (self.folder / "whole/summary.csv").read_text())
            for number in range(4):
                self.assertTrue(same_content(self.folder / f"out/case-{number}/ensemble.h5", self.folder / f"whole/case-{number}/ensemble.h5"))
        with (self.folder / "out" / "summary.csv").open() as file:
            table = list(csv.DictReader(file))
        self.assertEqual([(row["fracture.release"], row["mesh.perturbation"]) for row in table],
                         [('"element"', "0.05"), ('"element"', "0.1"), ('"facet"', "0.05"), ('"facet"', "0.1")])
        for number, row in enumerate(table):
            alone = f"alone-{number}"
            self.call("run", f"out/case-{number}/input.toml", "-o", alone)
            for name in ("ensemble.h5", "samples/0000.h5", "samples/0002.h5"):
                self.assertTrue(same_content(self.folder / f"out/case-{number}" / name, self.folder / alone / name), name)
            with h5py.File(self.folder / alone / "ensemble.h5") as file:
                self.assertAlmostEqual(float(row["onset_force [N]"]), file["samples/onset_force"][:].mean(), places=6)
            self.assertEqual((row["samples"], row["done"], row["failed"]), ("3", "3", "0"))
        shown = self.call("stats", "out")
        self.assertIn('fracture.release = "facet", mesh.perturbation = 0.1', shown)
        # A case whose sample files were moved away is shown from its ensemble.h5, which stays.
        results = self.folder / "out/case-0/ensemble.h5"
        before = results.read_bytes()
        shutil.rmtree(results.with_name("samples"))
        self.assertEqual(self.call("stats", "out"), shown)
        self.assertEqual(results.read_bytes(), before)
        self.assertIn("3 pairs of samples", self.call("compare", "out/case-0", "out/case-2"))

    def test_the_cost_of_a_sweep_is_that_of_all_its_cases(self):
        finer = '\n[[sweep]]\nkey = ["mesh.spacing", "mesh.notch_spacing"]\nvalues = [["1.5 mm", "0.6 mm"], ["1 mm", "0.3 mm"]]\n'
        output = self.call("check", self.write(PLATE + finer))
        first = re.search(r"tetrahedra += (\d+).*\nsample += ([\d.]+) s .*\ncore-hours += ([\d.e-]+) for 6 samples", output, re.DOTALL)
        other = re.search(r"\ncase 1 += (\d+) tetrahedra, \d+ steps, \d+ MB; sample ([\d.]+) s, ([\d.e-]+) core-hours\n"
                          r"all cases = ([\d.e-]+) core-hours\n", output)
        self.assertGreater(int(other[1]), 2 * int(first[1]))
        self.assertGreater(float(other[2]), 2 * float(first[2]))
        self.assertAlmostEqual(float(other[4]), float(first[3]) + float(other[3]), delta=0.01 * float(other[4]))
        heavy = PLATE + '\n[[sweep]]\nkey = "boundary[1].force"\nvalues = [["0 N", "0 N", "5 N"], ["0 N", "0 N", "5000 N"]]\n'
        self.assertIn("case 1: sample 0 would fail", self.call("check", "--samples", "1", self.write(heavy), status=1))

    def test_a_sweep_over_plans_has_the_draws_of_each(self):
        text = PLATE.replace("samples = 6", "samples = 3") + """
[[random]]
key = "mesh.perturbation"
distribution = "uniform"
lower = 0.05
upper = 0.2
[[sweep]]
key = "ensemble.plan"
values = ["independent", "sobol"]
"""
        self.call("run", self.write(text), "-o", "out")
        for number in range(2):
            self.call("run", f"out/case-{number}/input.toml", "-o", f"alone-{number}")
            for sample in range(3):
                name = f"samples/000{sample}.h5"
                self.assertTrue(same_content(self.folder / f"out/case-{number}" / name, self.folder / f"alone-{number}" / name), name)
        refused = self.call("stats", "out", "--sections", "y=3 mm", ranks=2, status=1)
        self.assertEqual(refused.count("holds a sweep"), 1, refused)

    def test_what_a_sweep_cannot_replace_it_names(self):
        name = self.write(PLATE.replace("samples = 6", "samples = 1") + SWEEP)
        self.call("run", name, "-o", "out")
        for file in ("out/case-2/ensemble.h5", "out/summary.csv"):
            (self.folder / file).unlink()
            (self.folder / file / "in the way").mkdir(parents=True)
            self.assertIn(f"{file} is a folder", self.call("run", name, "-o", "out", "--resume", status=1))
            shutil.rmtree(self.folder / file)

    def test_meshes_of_the_same_body_are_made_once(self):
        """The same samples take less time to mesh when cases differ in the material only."""
        name = self.write(PLATE.replace("samples = 6", "samples = 4\nmeshes = \"master\"") + SWEEP.split("[[sweep]]\nkey = \"mesh")[0])
        self.call("run", name, "-o", "out")
        for sample in range(4):
            with h5py.File(self.folder / f"out/case-0/samples/000{sample}.h5") as a, \
                    h5py.File(self.folder / f"out/case-1/samples/000{sample}.h5") as b:
                np.testing.assert_array_equal(a["mesh/nodes"][:], b["mesh/nodes"][:])
                self.assertLess(b["timing/mesh"][()], 0.5 * a["timing/mesh"][()])

    def test_what_a_sweep_refuses(self):
        name = self.write(PLATE + SWEEP)
        self.write(PLATE, "plain.toml")
        wrong = self.write(PLATE + SWEEP.replace("[0.05, 0.1]", "[0.05, 0.9]"), "wrong.toml")
        refused = self.call("run", wrong, "-o", "out", status=1)
        self.assertIn("wrong.toml:17: mesh.perturbation: 0.9 is out of range", refused)
        self.assertIn('(in case 1: fracture.release = "element", mesh.perturbation = 0.9)', refused)
        self.assertFalse((self.folder / "out").exists())
        self.call("run", "plain.toml", "-o", "plain", "--samples", "0")
        self.assertIn("holds an ensemble", self.call("run", name, "-o", "plain", status=1))
        self.call("run", name, "-o", "out", "--samples", "0")
        self.assertIn("continue it with --resume", self.call("run", name, "-o", "out", status=1))
        self.assertIn("holds a sweep", self.call("run", "plain.toml", "-o", "out", status=1))
        fewer = self.write(PLATE + SWEEP.replace("[0.05, 0.1]", "[0.05]"), "fewer.toml")
        self.assertIn("the sweep has 2 cases", self.call("run", fewer, "-o", "out", "--resume", status=1))
        other = self.write(PLATE + SWEEP.replace("[0.05, 0.1]", "[0.05, 0.2]"), "other.toml")
        self.assertIn("mesh.perturbation is 0.2, not 0.1", self.call("run", other, "-o", "out", "--resume", status=1))
        numbers = self.write(PLATE + '[[sweep]]\nkey = "ensemble.samples"\nvalues = [2, 4]\n', "numbers.toml")
        self.assertIn("--part: the cases of this sweep differ in ensemble.samples",
                      self.call("run", numbers, "-o", "parts", "--part", "0/2", status=1))
        for command in (["sample", name, "--sample", "0", "-o", "x"], ["mesh", name, "-o", "x.vtkhdf"]):
            self.assertIn("this is a sweep", self.call(*command, status=1))
        for command in ("watch", "compare"):
            self.assertIn("holds a sweep", self.call(command, *["out"] * (2 if command == "compare" else 1), status=1))
        self.assertIn("give the folder of one of its cases", self.call("stats", "out", "--limit", "peak_load > 1 N", status=1))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=Path, required=True)
    arguments, rest = parser.parse_known_args()
    PROGRAM = arguments.program.resolve()
    unittest.main(argv=[sys.argv[0], *rest])
