#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The Python package crackle on an ensemble of two samples, against `crackle stats --json` and the files themselves."""
from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import warnings
from pathlib import Path

import h5py
import matplotlib
import numpy as np
from matplotlib import pyplot

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "cli")]
matplotlib.use("Agg")

import command_lines  # noqa: E402
import crackle  # noqa: E402
import small_input  # noqa: E402
from effort import repetitions  # noqa: E402
from crackle import curves  # noqa: E402
from crackle_report import stress  # noqa: E402
from crackle_report.figures import histories  # noqa: E402
from crackle_report.options import Options  # noqa: E402
from crackle_report.reading import read_ensemble  # noqa: E402
from crackle_report.sample_files import SampleFiles  # noqa: E402
from synthetic_ensemble import changed, write_ensemble  # noqa: E402

PROGRAM = Path()
PROBE = """
[[output.probe]]
name = "gauge"
at = ["2.5 mm", "12 mm", "40 mm"]
"""


class Running(unittest.TestCase):
    def test_a_failed_sample_lacks_what_the_others_have(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "out"
            write_ensemble(folder, 4, failed=(2,), with_ensemble_file=False)
            for number in (0, 1, 3):  # as the program writes it for samples that are done only
                with changed(folder / "samples" / f"{number:04d}.h5") as root:
                    root["summary/phase_start"] = 10.0 + number
            table = crackle.open(folder).samples
            self.assertEqual(list(table["status"]), ["done", "done", "failed", "done"])
            np.testing.assert_array_equal(table["phase_start"], [10, 11, np.nan, 13])


    def test_without_a_sample_that_is_done_it_says_so(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "out"
            write_ensemble(folder, 2, failed=(0, 1))
            for table in ("histories", "fragments", "plane_traces"):
                with self.assertRaisesRegex(crackle.ResultsError, "out': no sample is done"):
                    getattr(crackle.open(folder), table)


class Kinds(unittest.TestCase):
    """Everything that the package offers, on ensembles of every kind."""

    OF_ENSEMBLE = ("samples", "paths", "input", "done", "histories")
    OF_SAMPLE = ("summary", "history", "energy", "frames", "mesh", "crack_surface", "crack_lines", "forks")
    OF_PLOTS = ("load", "crack_length", "tip_speed", "cracks")

    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        top = Path(temporary.name)
        sweep = '[[sweep]]\nkey = "fracture.strength"\nvalues = ["35 MPa", "45 MPa"]\n'
        random = small_input.RANDOM
        # Stiff draws fail: their waves are too fast for the step.
        failing = small_input.small_input(random, time='step = "138 ns"\n')
        inputs = {"plain": small_input.small_input(), "random": small_input.small_input(random),
                  "replicates": small_input.small_input(random, samples=4, ensemble="replicates = 2\n"),
                  "sweep": small_input.small_input(sweep), "one": small_input.small_input(samples=1),
                  "no notch": small_input.small_input(notch=""), "failed": failing,
                  "unbroken": small_input.small_input(strength="1e5 MPa", time='start = "rest"\n', force="1 N", rate="0 N/s")}
        cls.folders = {name: small_input.run(PROGRAM, text, top / name, may_fail=name == "failed") for name, text in inputs.items()}
        cls.folders["a case"] = cls.folders["sweep"] / "case-1"
        for name, first in (("random", "under way"), ("failed", "failed, under way")):
            cls.folders[first] = shutil.copytree(cls.folders[name], top / first)
            (cls.folders[first] / "ensemble.h5").unlink()
        pending = cls.folders["pending"] = top / "pending"
        small_input.run(PROGRAM, small_input.small_input(random, samples=5), pending, "--samples", "1-2")
        command_lines.crackle(PROGRAM, "stats", pending).check_returncode()

    def test_everything_works_on_each(self):
        for name, folder in self.folders.items():
            if name == "sweep":
                continue
            with self.subTest(name), warnings.catch_warnings():
                warnings.simplefilter("error")
                # The other kinds have the results of one of these, and pictures as "random" and "failed" have them.
                self.use(crackle.open(folder), draws=name not in repetitions(("replicates", "a case", "under way", "failed, under way"), ()),
                         draws_every_result=name in repetitions(("random", "unbroken"), ("random", "failed", "no notch", "one", "unbroken")))

    def use(self, ensemble: crackle.Ensemble, draws: bool, draws_every_result: bool) -> None:
        done = ensemble.done
        self.assertTrue(done)
        for name in self.OF_ENSEMBLE:
            self.assertIsNotNone(getattr(ensemble, name))
        self.assertIn(f"{len(done)} of {len(ensemble)} samples done", repr(ensemble))
        self.assertEqual(list(ensemble.histories.sample), done)
        self.assertTrue(np.isfinite(ensemble.histories.governing_load.isel(moment=0)).all())
        for sample in ensemble:
            self.use_sample(sample, ensemble)
        if not draws:
            return
        for axes in [getattr(ensemble.plot, name)() for name in self.OF_PLOTS]:
            self.assertTrue(axes.get_xlabel() and axes.get_ylabel())
        self.assertEqual(len(ensemble.plot.load(over="time").lines), len(done))
        pyplot.close("all")
        axes = pyplot.figure().add_subplot()
        for column in ensemble.samples if draws_every_result else ():
            for bar in list(axes.patches):  # clearing the axes would make all ticks anew
                bar.remove()
            axes.set_xlabel("")
            self.assertTrue(ensemble.plot.histogram(column, axes=axes).get_xlabel())
        pyplot.close()

    def use_sample(self, sample: crackle.Sample, ensemble: crackle.Ensemble) -> None:
        row = ensemble.samples.loc[sample.number]
        self.assertEqual(sample.is_done, row["status"] == "done")
        self.assertIn(f"Sample {sample.number} of", repr(sample))
        self.assertEqual(sample.input, ensemble.input)
        sample.open().close()
        if sample.is_done:
            for name in self.OF_SAMPLE:
                self.assertIsNotNone(getattr(sample, name))
        else:
            for name in self.OF_SAMPLE[1:]:
                with self.assertRaisesRegex(AttributeError, "the sample failed .*exceeds the stable step"):
                    getattr(sample, name)
        numbers = {name: value for name, value in sample.summary.items() if name in row and not isinstance(row[name], str)}
        self.assertGreater(len(numbers), 10 if sample.is_done else 0)
        for name, value in numbers.items():
            np.testing.assert_equal(float(value), float(row[name]), name)

    def test_histories_of_samples_with_more_cracks_and_fewer(self):
        """As in solids; without cracks there is no such group."""
        with tempfile.TemporaryDirectory() as name:
            folder = shutil.copytree(self.folders["plain"], Path(name) / "out")
            for number, n_cracks in ((0, 2), (2, 3)):
                with changed(folder / "samples" / f"{number:04d}.h5") as root:
                    reach = root.create_dataset("history/cracks/reach", data=np.full((len(root["history/time"]), n_cracks), 1e-3 * number))
                    reach.dims[0].label, reach.dims[1].label = "moment", "crack"
            together, n_moments = (crackle.open(folder).histories, [sample.history.sizes["moment"] for sample in crackle.open(folder)])
        self.assertEqual(together.each_crack_reach.sizes, {"sample": 3, "moment": max(n_moments), "crack": 3})
        known = np.zeros((3, max(n_moments), 3), bool)
        known[0, :n_moments[0], :2] = known[2, :n_moments[2]] = True
        np.testing.assert_array_equal(together.each_crack_reach, np.where(known, [[[0]], [[0]], [[2e-3]]], np.nan))
        self.assertEqual(together.governing_load.dims, ("sample", "moment"))

    def test_random_inputs_are_among_the_results(self):
        ensemble = crackle.open(self.folders["random"])
        moduli = ensemble.samples["material.youngs_modulus"]
        self.assertEqual(len(set(moduli)), 3)
        self.assertEqual(ensemble.samples.attrs["units"]["material.youngs_modulus"], "Pa")
        self.assertEqual([sample.summary["material.youngs_modulus"] for sample in ensemble], list(moduli))
        replicates = crackle.open(self.folders["replicates"])
        self.assertEqual([sample.summary["material.youngs_modulus"] for sample in replicates],
                         [moduli[draw] for draw in (0, 0, 1, 1)])

    def test_states_are_those_of_the_run(self):
        states = {"failed": ["failed", "done", "done"], "failed, under way": ["failed", "done", "done"],
                  "pending": ["pending", "done", "done", "pending", "pending"], "under way": ["done"] * 3}
        for name, expected in states.items():
            self.assertEqual(list(crackle.open(self.folders[name]).samples["status"]), expected, name)

    def test_a_sweep_is_opened_case_by_case(self):
        with self.assertRaisesRegex(crackle.ResultsError, "holds a sweep; open one of its cases: case-0, case-1"):
            crackle.open(self.folders["sweep"])
        loads = [crackle.open(self.folders["sweep"] / case).samples["onset_force"].median() for case in ("case-0", "case-1")]
        self.assertGreater(loads[1], 1.1 * loads[0])

    def test_before_the_first_sample_has_ended_it_says_so(self):
        with tempfile.TemporaryDirectory() as name:
            shutil.copy(self.folders["plain"] / "input.toml", name)
            with self.assertRaisesRegex(crackle.ResultsError, "holds no results yet: no sample has ended"):
                crackle.open(name)


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = Path(cls.temporary.name) / "out"
        text = (ROOT / "jobs" / "demo.toml").read_text()
        for key, value in (("samples", "2"), ("spacing", '"5 mm"'), ("notch_spacing", '"1 mm"')):
            text, n_replaced = re.subn(rf"(?m)^{key} = .*", f"{key} = {value}", text)
            assert n_replaced == 1, key
        text = re.sub(r"(?m)^frames = .*", 'frames = 3\nhistory = "2 us"', text) + PROBE
        source = Path(cls.temporary.name) / "two.toml"
        source.write_text(text)
        command_lines.crackle(PROGRAM, "run", source, "-o", cls.folder).check_returncode()
        cls.ensemble = crackle.open(cls.folder)
        done = command_lines.crackle(PROGRAM, "stats", cls.folder, "--json", "--read-only")
        cls.json = json.loads(done.stdout)

    def test_samples_are_those_of_the_program(self):
        table = self.ensemble.samples
        self.assertEqual(list(table["status"]), ["done", "done"])
        for result in self.json["results"]:
            if result.get("categories"):
                continue
            np.testing.assert_array_equal(table[result["name"]].astype(float),
                                          np.array(self.json["samples"][result["name"]], float), result["name"])
        names = [result["name"] for result in self.json["results"]]
        self.assertEqual([name for name in table if name in names], names, "the order is another one")
        self.assertEqual(table.attrs["units"]["peak_load"], "N")
        self.assertIn("load", table.attrs["meaning"]["peak_load"])
        self.assertIn(table["outcome"][0], ("separated", "in one piece", "arrested", "undecided"))
        self.assertEqual(len(self.ensemble), 2)
        self.assertEqual(repr(self.ensemble), f"<crackle.Ensemble '{self.folder}': 2 of 2 samples done, 0 failed>")

    def test_paths_have_names_units_and_places(self):
        position = self.ensemble.paths.position
        self.assertEqual(position.dims, ("sample", "notch", "section"))
        self.assertEqual(position.attrs["units"], "m")
        np.testing.assert_array_equal(position.section, self.json["crack_path"]["section"])
        np.testing.assert_array_equal(position, np.array(self.json["crack_path"]["position"], float))
        self.assertGreater(float(self.ensemble.paths.arrival_time.max()), 1e-6)

    def test_histories_are_those_of_the_files(self):
        together = self.ensemble.histories
        for number in (0, 1):
            history = self.ensemble[number].history
            n = history.sizes["moment"]
            with h5py.File(self.folder / "samples" / f"{number:04d}.h5") as root:
                for name in ("governing_load", "external", "crack_length", "tip_speed"):
                    stored = root["history"][name][...]
                    np.testing.assert_array_equal(history[name], stored)
                    np.testing.assert_array_equal(together[name].sel(sample=number).isel(moment=slice(n)), stored)
                self.assertEqual(root["history/governing_load"].dims[0].label, "moment")
                self.assertEqual(root["history/governing_load"].dims[0][0].name, "/history/time")
            self.assertTrue(np.isnan(together.governing_load.sel(sample=number).isel(moment=slice(n, None))).all())
            self.assertEqual(history.governing_load.attrs["units"], "N")
            self.assertEqual(history["load"].dims, ("moment", "condition", "component"))
            self.assertEqual(list(history.condition_on.values), ["z-min", "z-max"])
            # What pulls above is held below, at rest.
            at_rest = history.isel(moment=history.phase == 0).sel(component="z")
            applied = at_rest["load"].isel(condition=1)
            np.testing.assert_allclose(at_rest.reaction.isel(condition=0), -applied, rtol=1e-6)
            self.assertTrue((at_rest.reaction.isel(condition=1) == 0).all() and (at_rest["load"].isel(condition=0) == 0).all())
            self.assertEqual(history.probe_stress.dims, ("probe", "moment", "stress_component"))
            self.assertEqual(list(history.probe.values), ["gauge"])
            # Far from the notches the stress is the mean one.
            mean = applied / (5e-3 * 24.5e-3)
            np.testing.assert_allclose(history.isel(moment=history.phase == 0).probe_stress.sel(stress_component="zz").isel(probe=0),
                                       mean, rtol=0.1)

    def test_a_sample_has_fields_and_cracks(self):
        sample = self.ensemble[1]
        self.assertEqual(sample.frames.displacement.dims, ("frame", "node", "component"))
        self.assertEqual(sample.frames.sizes["node"], len(sample.mesh["nodes"]))
        self.assertEqual(len(sample.frames.time), 3)
        self.assertAlmostEqual(float(sample.crack_surface.area.sum()), float(self.ensemble.samples["crack_area"][1]), delta=1e-14)
        self.assertTrue(set(sample.crack_surface.notch.values) <= {-1, 0, 1})
        self.assertTrue(sample.crack_lines and all(line.attrs["notch"] in (0, 1) for line in sample.crack_lines))
        self.assertEqual(sample.summary["onset_force"], self.ensemble.samples["onset_force"][1])
        self.assertGreater(sample.history.attrs["rayleigh_speed"], 900)
        with sample.open() as root:
            self.assertIn("breaks", root)

    def test_each_picture_takes_one_line(self):
        plot = self.ensemble.plot
        for axes in (plot.load(), plot.load(over="time"), plot.crack_length(), plot.tip_speed(), plot.cracks([1])):
            self.assertTrue(any(np.isfinite(line.get_ydata()).sum() > 3 for line in axes.lines))
            self.assertTrue(axes.get_xlabel() and axes.get_ylabel())
        self.assertEqual(sum(patch.get_height() for patch in plot.histogram("peak_load").patches), 2)
        with self.assertRaisesRegex(ValueError, '"displacement" or "time"'):
            plot.load(over="space")

    def test_frames_and_energies_are_found_by_their_time(self):
        sample = self.ensemble[1]
        times = sample.frames.time.values
        near = sample.frames.sel(time=0.9 * times[1] + 0.1 * times[2], method="nearest")
        self.assertEqual(float(near.time), times[1])
        moments = sample.energy.time.values
        self.assertEqual(float(sample.energy.sel(time=1.01e-6, method="nearest").time), moments[np.abs(moments - 1.01e-6).argmin()])
        frames = SampleFiles(self.folder).frames(1)
        np.testing.assert_array_equal(near.stress, stress.frame_stress(frames, 1))
        self.assertEqual((near.stress.dims, near.stress.attrs["units"]), (("tetrahedron", "stress_component"), "Pa"))
        some = sample.frames.stress.isel(frame=[2, 0], tetrahedron=slice(3, 6)).sel(stress_component=["zz", "xx"])
        np.testing.assert_array_equal(some, np.array([stress.frame_stress(frames, k)[3:6][:, [2, 0]] for k in (2, 0)]))

    def test_a_name_that_is_none_is_answered_with_those_that_are(self):
        with self.assertRaisesRegex(KeyError, "no result is named 'peak_laod'; did you mean peak_load.*There are status, .*crack_speed_max"):
            self.ensemble.plot.histogram("peak_laod")

    def test_pictures_have_names_an_outline_and_limits(self):
        plot, sample = self.ensemble.plot, self.ensemble[0]
        names = {call: [text.get_text() for text in getattr(plot, call)().get_legend().get_texts()] for call in ("load", "crack_length", "tip_speed", "cracks")}
        self.assertEqual(names["load"], ["sample 0", "sample 1"])
        self.assertTrue(all(re.fullmatch("sample [01], notch [01]", name) for name in names["crack_length"]), names)
        self.assertIn("Rayleigh speed", names["tip_speed"])
        self.assertTrue(set(names["cracks"]) <= {"from notch 0", "from notch 1"}, names)
        outline = plot.cracks().lines[0].get_xydata()
        np.testing.assert_allclose(np.ptp(outline, axis=0), [24.5, 140])
        self.assertGreater(plot.tip_speed().get_ylim()[1], sample.history.attrs["rayleigh_speed"])
        # What has broken moves on, and its load may spring back.
        left, right = plot.load().get_xlim()
        at_peak = 1e3 * self.ensemble.samples["displacement_at_peak"].max()
        self.assertEqual(left, 0)
        self.assertLess(right, 1.3 * at_peak)
        bottom, top = plot.load().get_ylim()
        self.assertEqual(bottom, 0)
        self.assertLess(top, 1.1 * self.ensemble.samples["peak_load"].max())
        pyplot.close("all")

    def test_what_moves_on_after_the_break_does_not_squeeze_the_curves(self):
        load, flying = np.array([0, 90, 100, -650, 40.0]), np.array([0, 0.9, 1, 5, 60])
        (left, right), (bottom, top) = curves.load_limits([(flying, load, np.array([0, 0, 1, 1, 1]))])
        np.testing.assert_allclose((left, right, bottom, top), (0, 1.15, 0, 108))
        # Cracks that run and stop: loading goes on behind the first peak.
        (_, right), _ = curves.load_limits([(flying, load, np.array([0, 0, 1, 0, 1]))])
        self.assertAlmostEqual(right, 5.75)

    def test_a_missing_package_is_named_with_what_installs_it(self):
        for name, call in (("h5py", "import crackle"), ("xarray", "import crackle; crackle.open")):
            code = f"import sys; sys.path[0] = {str(ROOT / 'tools')!r}; sys.modules[{name!r}] = None; {call}"
            failed = subprocess.run([sys.executable, "-B", "-c", code], capture_output=True, text=True, check=False)
            self.assertEqual(failed.returncode, 1)
            self.assertRegex(failed.stderr.splitlines()[-1], f"crackle needs the Python package {name}, which .*python.* does not have; install it "
                                                             f"with '.*' -m pip install '{ROOT / 'tools'}'")

    def test_a_run_on_its_way_is_read_from_its_samples(self):
        with tempfile.TemporaryDirectory() as name:
            shutil.copytree(self.folder / "samples", Path(name) / "samples")
            (Path(name) / "samples" / "0000.h5").unlink()
            ensemble = crackle.open(name)
            self.assertEqual(ensemble.done, [1])
            self.assertEqual(ensemble.samples["onset_force"][1], self.ensemble.samples["onset_force"][1])
            np.testing.assert_array_equal(ensemble.paths.position[0], self.ensemble.paths.position[1])
            with self.assertRaisesRegex(KeyError, "sample 0 has not ended; those that have: 1"):
                ensemble[0]

    def test_samples_that_ended_after_the_results_were_written_are_among_them(self):
        with tempfile.TemporaryDirectory() as name:
            folder = small_input.run(PROGRAM, small_input.small_input(samples=2), Path(name) / "out")
            source = Path(name) / "five.toml"
            source.write_text(small_input.small_input(samples=5))
            command_lines.crackle(PROGRAM, "run", source, "-o", folder, "--resume", "--samples", "2-3").check_returncode()
            found = crackle.open(folder)
            self.assertEqual(found.done, [0, 1, 2, 3])
            self.assertEqual(found.histories.sizes["sample"], 4)
            command_lines.crackle(PROGRAM, "stats", folder).check_returncode()
            merged = crackle.open(folder)
            self.assertEqual([len(found), len(merged)], [4, 5])
            for column in ("onset_force", "crack_area", "wall_time"):
                np.testing.assert_array_equal(found.samples[column], merged.samples[column][:4])
            np.testing.assert_array_equal(found.paths.position, merged.paths.position[:4])

    def test_paths_at_lines(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "out"
            source = Path(name) / "line.toml"
            source.write_text(small_input.small_input('[[sections.line]]\nfrom = ["2 mm", "8 mm"]\nto = ["10 mm", "22 mm"]\n'))
            command_lines.crackle(PROGRAM, "run", source, "-o", folder, "--samples", "0-0").check_returncode()
            command_lines.crackle(PROGRAM, "stats", folder).check_returncode()
            with h5py.File(folder / "ensemble.h5") as root:
                n_sections, n_across_y = root["crack_path/position"].shape[2], root["crack_path/z"].shape[2]
            self.assertLess(n_across_y, n_sections)
            found = crackle.open(folder)
            self.assertEqual(found.paths.sizes["section"], n_sections)
            self.assertEqual(found.done, [0])

    def test_the_report_draws_the_histories(self):
        section = histories.section(read_ensemble(self.folder, PROGRAM), Options())
        self.assertEqual([picture.name for picture in section.pictures], ["load", "crack-speed", "arrival"])
        load, growth, arrival = (picture.figure.axes for picture in section.pictures)
        stored = self.ensemble[0].history
        drawn = [(line.get_xdata(), line.get_ydata()) for line in load[0].lines]
        self.assertTrue(any(len(x) == stored.sizes["moment"] and np.array_equal(y, stored.governing_load)
                            and np.allclose(1e-3 * x, stored.governing_displacement) for x, y in drawn))
        rayleigh = stored.attrs["rayleigh_speed"]
        self.assertTrue(any(np.allclose(line.get_ydata(), rayleigh) for line in growth[1].lines))
        self.assertTrue(any(f"{rayleigh:.0f} m/s" in text.get_text() for text in growth[1].texts))
        times = np.concatenate([np.ravel(line.get_ydata()) for line in arrival[0].lines])
        expected = 1e6 * self.ensemble.paths.arrival_time.values
        for time in expected[np.isfinite(expected) & (expected > -1)]:
            self.assertLess(np.abs(times - time).min(), 1e-9)

    def test_what_is_no_result_is_refused_with_the_reason(self):
        with tempfile.TemporaryDirectory() as name:
            with self.assertRaisesRegex(crackle.ResultsError, "holds no results"):
                crackle.open(name)
            with self.assertRaisesRegex(crackle.ResultsError, "there is no folder"):
                crackle.open(Path(name) / "missing")

    def test_the_figures_of_the_paper_are_told(self):
        with tempfile.TemporaryDirectory() as name:
            done = subprocess.run(["/usr/bin/python3", "-B", str(ROOT / "jobs" / "figures.py"), str(self.folder)], capture_output=True,
                                  text=True, check=False, cwd=name, env={**os.environ, "PYTHONPATH": str(ROOT / "tools"), "CRACKLE": str(PROGRAM)})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("work_of_fracture", done.stdout)

    @unittest.skipUnless(repetitions(False, True), "takes long and rarely fails")
    def test_it_can_be_installed(self):
        with tempfile.TemporaryDirectory() as name:
            copy, target = Path(name) / "tools", Path(name) / "site"
            shutil.copytree(ROOT / "tools", copy, ignore=shutil.ignore_patterns("__pycache__"))
            install = subprocess.run(["/usr/bin/python3", "-m", "pip", "install", "--no-deps", "--no-build-isolation", "--no-index",
                                      "--target", str(target), str(copy)], capture_output=True, text=True, check=False)
            self.assertEqual(install.returncode, 0, install.stderr)
            variables = {**os.environ, "PYTHONPATH": str(target), "CRACKLE": str(PROGRAM)}
            folder = small_input.run(PROGRAM, small_input.small_input(samples=2), Path(name) / "out")
            five_lines = f"import crackle\np = crackle.open({str(folder)!r})\np.plot.load().figure.savefig('load.png')\nprint(crackle.__file__)"
            done = subprocess.run(["/usr/bin/python3", "-B", "-c", five_lines], capture_output=True, text=True, check=True, cwd=name,
                                  env={**variables, "MPLBACKEND": "Agg"})
            self.assertIn(str(target), done.stdout)
            self.assertGreater((Path(name) / "load.png").stat().st_size, 10_000)
            done = subprocess.run(["/usr/bin/python3", "-B", str(target / "bin" / "crackle-report"), str(folder), "--no-animation",
                                   "--no-fringes"], capture_output=True, text=True, check=False, env=variables)
            self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=Path, required=True)
    options, rest = parser.parse_known_args()
    PROGRAM = options.program.resolve()
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
