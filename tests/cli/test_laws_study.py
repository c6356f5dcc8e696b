#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of jobs/laws/study: its inputs, its statistics and references, and two samples of its coarsest runs."""
from __future__ import annotations

import argparse
import math
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "jobs" / "laws"), str(ROOT / "jobs" / "paper")]

import convergence  # noqa: E402
import cost  # noqa: E402
import plane_slot  # noqa: E402
import slot_heights  # noqa: E402
import smoothness  # noqa: E402
from crackle_launch import environment  # noqa: E402
from crackle_runs import run, with_keys  # noqa: E402

COARSEST = ("immediate-0.4", "averaged-0.4", "softening-0.2")


class Study(unittest.TestCase):
    def test_every_run_has_its_law_and_its_spacing(self):
        for name, one in convergence.RUNS.items():
            keys = tomllib.loads(one.input_text())
            self.assertEqual(keys["mesh"]["notch_spacing"], f"{one.spacing:g} mm", name)
            self.assertEqual(keys["mesh"]["region"][0]["spacing"], f"{one.spacing:g} mm", name)
            self.assertEqual("length" in keys["fracture"], one.law == "averaged", name)
            self.assertEqual(keys["fracture"].get("release") == "softening", one.law == "softening", name)

    def test_check_says_what_the_mesh_resolves(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("averaged-0.4", "softening-0.2"):
                source = Path(folder) / f"{name}.toml"
                source.write_text(convergence.RUNS[name].input_text())
                result = subprocess.run([OPTIONS.program, "check", "--no-measure", str(source)], capture_output=True, text=True,
                                        env=environment(), check=True)
                if name.startswith("softening"):
                    self.assertRegex(result.stdout, r"process zone +=.*0\.4041 mm, E G / strength\^2")
                    self.assertIn("softening wants at most 0.1347 mm", result.stdout)
                else:
                    self.assertRegex(result.stdout, r"toughness +=.*the averaging length")

    def test_inputs_of_slots_fringes_and_cost_are_right(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, one in {**slot_heights.RUNS, **smoothness.RUNS, **cost.RUNS}.items():
                source = Path(folder) / f"{name}.toml"
                source.write_text(one.input_text())
                subprocess.run([OPTIONS.program, "check", "--no-measure", str(source)], stdout=subprocess.DEVNULL,
                               env=environment(), check=True)

    def test_the_reference_finds_what_a_crack_sets_free(self):
        # A slot as thin as can be, and a crack 0.5 to 0.7 mm beyond it; an edge crack by Tada, Paris and Irwin.
        young, nu, width = 3.3e9, 0.38, 24.5e-3
        plate = plane_slot.Plate(width, 50e-3, 5.5e-3, 1e-4, young, nu, element=5e-5, reach=9e-4)
        near, far = plane_slot.energy_release(plate, 0, np.array([5e-4, 7e-4]))
        found = (7 * far - 5 * near) / 2

        def exact(crack: float) -> float:
            angle = math.pi * crack / width / 2
            shape = (math.sqrt(math.tan(angle) / angle)
                     * (0.752 + 2.02 * crack / width + 0.37 * (1 - math.sin(angle))**3) / math.cos(angle))
            return math.pi * crack * shape**2 / width**2 * (1 - nu**2) / young

        print(f"energy release of an edge crack over Tada's: {found / exact(6.1e-3):.3f}")
        self.assertLess(abs(found / exact(6.1e-3) - 1), 0.02)
        # A crack whose cohesive zone is much smaller than itself starts at Griffith's load.
        load = plane_slot.cohesive_load(plate, 0, 15e6, 15) / math.sqrt(15 / exact(5.5e-3))
        print(f"load of a cohesive zone over Griffith's: {load:.3f}")
        self.assertLess(abs(load - 1), 0.02)

    def test_slopes_of_power_laws_are_found(self):
        rng = np.random.default_rng(1)
        spacings = np.repeat([0.05, 0.1, 0.2, 0.4], 16)
        loads = 50 * spacings**0.3 * np.exp(0.02 * rng.standard_normal(spacings.size))
        slope, width = convergence.slope(spacings, loads)
        self.assertLess(abs(slope - 0.3), width)
        self.assertLess(width, 0.02)

    def test_two_samples_of_each_law_give_a_table(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            text = convergence.Run.input_text

            def short(run):
                return with_keys(text(run), {"ensemble.samples": "2", "time.duration": '"4 us"'})
            with mock.patch.object(convergence.Run, "input_text", short):
                for one in COARSEST:
                    run(convergence.RUNS[one].input_text(), folder / one, Path(OPTIONS.program))
            kept = folder / "kept"
            kept.mkdir()
            (folder / "cost-strength").symlink_to(folder / COARSEST[0])
            self.assertEqual(cost.table(folder).count("| immediate, 35 MPa |"), 2)
            found = convergence.keep_rows(folder, kept)
            self.assertEqual([one["law"] for one in found], ["immediate"] * 2 + ["averaged"] * 2 + ["softening"] * 2)
            load = {law: np.mean([one["load_n"] for one in found if one["law"] == law]) for law in ("immediate", "averaged",
                                                                                                  "softening")}
            print("; ".join(f"{law} {value:.1f} N" for law, value in load.items()))
            self.assertLess(load["immediate"], load["averaged"])
            lines = convergence.table(found).splitlines()
            self.assertEqual(len(lines), 2 + len(COARSEST))
            self.assertTrue((kept / "convergence.png").stat().st_size > 0)
            # A run that is not there any more keeps its rows.
            (folder / COARSEST[0]).rename(folder / "elsewhere")
            again = convergence.keep_rows(folder, kept)
            self.assertEqual(len(again), len(found))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", required=True)
    OPTIONS, remaining = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0], *remaining], verbosity=2)
