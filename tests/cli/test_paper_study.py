#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of jobs/paper/study: its inputs, its statistics, and a run that is stopped and continued."""
from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
import unittest
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "jobs" / "paper")]

from crackle_report.photoelasticity import Grid  # noqa: E402
from crackle_runs import RunError, with_keys  # noqa: E402
from paper_study import comparing, course, fringes, ramp, rows, tables  # noqa: E402
from paper_study.campaign import keep_ensemble  # noqa: E402
from paper_study.keeping import keep  # noqa: E402
from paper_study.running import Known, compute, gaps, known_of  # noqa: E402
from paper_study.studies import OWN, STUDIES, TARGET_LOAD, Run  # noqa: E402


def make_rows(z, label="5 mm, 5 mm", onset=None, pattern=None, name="run"):
    n = len(z)
    values = {name: np.zeros(n) for name in rows.FIELDS}
    values["onset_force"] = np.zeros(n) if onset is None else np.asarray(onset, float)
    values["pattern"] = np.full(n, 1.0) if pattern is None else np.asarray(pattern, float)
    return rows.Rows(name, label, "input", np.arange(n), values, np.asarray(z, float), np.ones(n))


class Signals(unittest.TestCase):
    def test_the_program_is_told_and_waited_for(self):
        program = "trap 'sleep 1; echo parked; exit 3' USR1; echo running; while :; do sleep 0.05; done"
        study = ("import sys; from crackle_runs import RunError, status_of\n"
                 "try: status_of(['bash', '-c', sys.argv[1]], open(sys.argv[2], 'w'))\n"
                 "except RunError as error: print(error)")
        for number in (signal.SIGINT, signal.SIGTERM):
            with tempfile.TemporaryDirectory() as name:
                log = Path(name) / "log.txt"
                with subprocess.Popen([sys.executable, "-B", "-c", study, program, str(log)], stdout=subprocess.PIPE, text=True,
                                      env={**os.environ, "PYTHONPATH": str(ROOT / "tools")}) as process:
                    until = time.monotonic() + 60
                    while not (log.is_file() and log.read_text()) and time.monotonic() < until:
                        time.sleep(0.05)
                    process.send_signal(number)
                    said = process.communicate(timeout=60)[0]
                self.assertEqual(log.read_text(), "running\nparked\n")
                self.assertEqual(said, f"stopped by {number.name}; the same command continues\n")


class Inputs(unittest.TestCase):
    def test_every_run_changes_what_it_says_and_nothing_else(self):
        for run in (run for study in STUDIES.values() for run in study):
            before = tomllib.loads(run.source_file.read_text())
            after = tomllib.loads(run.input_text())
            self.assertEqual(after["ensemble"]["samples"], run.samples, run.name)
            if "ensemble.seed" not in run.keys:
                self.assertEqual(after["ensemble"]["seed"], before["ensemble"]["seed"])
            for key, value in run.keys.items():
                table, name = key.split(".")
                if value is None:
                    self.assertNotIn(name, after[table], run.name)
                else:
                    self.assertEqual(after[table].pop(name), tomllib.loads(f"x = {value}")["x"], run.name)
                before_table = dict(before[table])
                before_table.pop(name, None)
                before[table] = before_table
            notches = after["specimen"]["notch"]
            if run.depth is not None:
                self.assertEqual([notch["depth"] for notch in notches], 2 * [f"{run.depth:g} mm"])
                places = [float(notch["at"].split()[0]) for notch in notches]
                self.assertAlmostEqual(places[1] - places[0], run.distance)
                self.assertAlmostEqual(sum(places), 140)
            elif run.thickness is not None:
                self.assertEqual(after["specimen"]["size"], [f"{run.thickness:g} mm", *before["specimen"]["size"][1:]])
                self.assertEqual(after["specimen"]["notch"], before["specimen"]["notch"])
                for key in ("rate", "force"):
                    whole, part = (float(one["boundary"][1][key][2].split()[0]) for one in (before, after))
                    self.assertAlmostEqual(part / whole, run.thickness / 5)
            else:
                self.assertEqual(after["specimen"], before["specimen"], run.name)
            for key, value, unit in (("rate", run.rate, "N/s"), ("force", run.load, "N")):
                if value is not None:
                    self.assertEqual(after["boundary"][1][key][2], f"{value:g} {unit}")
            if run.rate is run.load is run.thickness is None:
                self.assertEqual(after["boundary"], before["boundary"])
            added = [after["mesh"].get("region") != before["mesh"].get("region"), "variation" in after["fracture"]]
            self.assertEqual(run.tables != "", any(added), run.name)
            del after["ensemble"]["samples"], before["ensemble"]["samples"]
            for tables in (before, after):
                tables["mesh"].pop("region", None)
                tables["fracture"].pop("variation", None)
            for table in ("ensemble", "mesh", "material", "fracture", "time", "sections", "output"):
                self.assertEqual(after[table], before[table], f"{run.name}: [{table}]")

    def test_names_of_runs_differ(self):
        names = [run.name for study in STUDIES.values() for run in study]
        self.assertEqual(len(names), len(set(names)))

    def test_the_program_accepts_one_of_each_kind(self):
        with tempfile.TemporaryDirectory() as folder:
            for study in STUDIES.values():
                file = Path(folder) / "input.toml"
                # Coarser away from the notches, which takes a tenth of the time.
                file.write_text(with_keys(study[-1].input_text(), {"mesh.growth": "0.3", "mesh.spacing": '"3 mm"'}))
                result = subprocess.run([OPTIONS.program, "check", "--no-measure", str(file)], capture_output=True, text=True)
                self.assertEqual(result.returncode, 0, result.stderr)


class Statistics(unittest.TestCase):
    def test_exact_tests_give_the_textbooks_values(self):
        self.assertAlmostEqual(comparing.binomial_test(3, 12), 2 * (1 + 12 + 66 + 220) / 4096)
        self.assertEqual(comparing.binomial_test(6, 12), 1)
        self.assertEqual(comparing.binomial_test(0, 0), 1)

    def test_one_share_in_all_groups_is_tested(self):
        # Two groups of 4 with 3 and 1 hits: Fisher's lady tasting tea, where the two-sided p is 34/70.
        self.assertAlmostEqual(comparing.same_share_test([3, 1], [4, 4]), 34 / 70, delta=0.015)
        self.assertLess(comparing.same_share_test([10, 0, 5], [10, 10, 10]), 1e-3)
        self.assertGreater(comparing.same_share_test([5, 5, 5], [10, 10, 10]), 0.99)
        self.assertGreater(comparing.same_share_test([3, 0, 4], [6, 0, 8]), 0.99, "an empty group says nothing")
        self.assertEqual(comparing.same_share_test([3, 0], [6, 0]), 1)

    def test_differences_have_students_intervals(self):
        one, other = np.array([1.0, 2, 3, np.nan]), np.array([2.0, 2.5, 4.5, 7])
        mean, half_width = comparing.difference(one, other, paired=True)
        self.assertAlmostEqual(mean, 1)
        self.assertAlmostEqual(half_width, 4.302653 * 0.5 / np.sqrt(3), delta=1e-5)  # t of 2 degrees of freedom
        mean, half_width = comparing.difference(one, other, paired=False)
        self.assertAlmostEqual(mean, 2)
        # Welch: variances 1/3 and 5.1667/4, 4.30 degrees of freedom, rounded down.
        self.assertAlmostEqual(half_width, 2.776445 * np.sqrt(1 / 3 + np.var(other, ddof=1) / 4), delta=1e-4)
        self.assertTrue(np.isnan(comparing.difference(one[:1], other[:1], paired=True)[0]))

    def test_the_number_of_samples_needed_is_the_last_to_leave_the_tolerance(self):
        half_width = np.array([[np.nan, 9], [3, 3], [1, 2], [0.5, 1], [1.2, 1], [1, 1]])
        self.assertEqual(comparing.needed(half_width, 1), 6)
        self.assertEqual(comparing.needed(half_width, 2), 3)
        self.assertIsNone(comparing.needed(half_width, 0.5))

    def test_groups_by_reach(self):
        found = make_rows(np.zeros((4, 2, 5)))
        found.values["reach_0"][:] = [0.9, 0.3, 0.9, 0.5]
        found.values["reach_1"][:] = [0.3, 0.9, 0.45, 0.1]
        self.assertEqual(comparing.groups(found, 0.4), (2, 1, 1))
        self.assertEqual(comparing.groups(found, 0.5), (3, 0, 1))

    def test_a_shift_of_paired_paths_is_found_wherever_it_is(self):
        chance = np.random.default_rng(1).normal(0, 1, (20, 5))
        self.assertGreater(comparing.same_path_test(chance), 0.05)
        self.assertLess(comparing.same_path_test(chance + [0, 0, 0, 1.5, 0]), 0.01)
        # Of three pairs with one sign, 2 of the 8 choices of signs are as extreme.
        self.assertAlmostEqual(comparing.same_path_test(np.array([[1.0], [1.1], [1.2]])), 0.25, delta=0.02)
        self.assertEqual(comparing.same_path_test(np.zeros((4, 5))), 1)

    def test_scatter_of_means_leaves_chance_out(self):
        generator = np.random.default_rng(1)
        groups = [generator.normal(mean, 2, 50) for mean in generator.normal(0, 3, 400)]
        scatter, limit = comparing.scatter_of_means(groups)
        self.assertAlmostEqual(scatter, 3, delta=0.3)
        self.assertTrue(scatter < limit < 3.5, limit)
        self.assertLess(comparing.scatter_of_means([generator.normal(0, 2, 5) for _ in range(400)])[0], 0.4)
        # Of eight groups of four whose means are the same, the limit covers a scatter of zero and says how little is known.
        limits = [comparing.scatter_of_means([generator.normal(0, 45, 4) for _ in range(8)])[1] for _ in range(200)]
        self.assertTrue(10 < np.median(limits) < 40, np.median(limits))
        truth, n_held = 20, 0
        for _ in range(400):
            held = comparing.scatter_of_means([generator.normal(generator.normal(0, truth), 45, 4) for _ in range(8)])[1]
            n_held += held >= truth
        print(f"the 95 % limit holds in {n_held} of 400")
        self.assertGreater(n_held, 360)
        for unknown in ([np.array([1.0, 2, np.nan])], [np.array([1.0]), np.array([2.0])]):
            self.assertTrue(np.isnan(comparing.scatter_of_means(unknown)[0]))

    def test_paired_shares_have_newcombes_interval(self):
        # Newcombe 1998, table II: 43 of 50 against 40 of 50 by pairs, of 5 mm 36, 12, 2, 0.
        one = np.repeat([True, True, False, False], [36, 12, 2, 0])
        other = np.repeat([True, False, True, False], [36, 12, 2, 0])
        value, low, high = comparing.share_difference(other, one)
        self.assertAlmostEqual(value, 0.2)
        self.assertAlmostEqual(low, 0.0569, delta=5e-4)
        self.assertAlmostEqual(high, 0.3404, delta=5e-4)
        value, low, high = comparing.share_difference(one[:20], one[:20])
        self.assertEqual(value, 0)
        self.assertTrue(low < -0.1 and high > 0.1, "no pair that differs is not certainty")

    def test_the_notch_whose_crack_came_farther_leads(self):
        found = make_rows(np.zeros((4, 2, 5)))
        found.z[1, 1, 2:] = np.nan  # fewer sections, though it came farther and started first
        found.values["reach_1"][:] = [0, 0.9, 0.6, 0]
        found.values["reach_0"][:] = [0, 0.5, 0.5, 0]
        found.values["start_0"][:] = [0, 2, 1, 2]
        found.values["start_1"][:] = [0, 1, 2, 1]
        self.assertEqual(comparing.leading_notch(found).tolist(), [-1, 0, 1, 1])
        np.testing.assert_array_equal(comparing.of_notch(found, "start", np.array([-1, 0, 1, 1])), [np.nan, 2, 2, 1])

    def test_a_turned_mesh_is_turned_back(self):
        found = make_rows(np.zeros((4, 2, 5)))
        found.values["turned"][:] = [0, 1, 1, 1]
        self.assertEqual(comparing.in_base_frame(found, np.array([0, 0, 1, -1])).tolist(), [0, 1, 0, -1])

    def test_a_plate_turned_by_180_degrees_has_the_same_leading_path(self):
        path = np.array([0.0670, 0.0672, 0.0675, 0.0681, 0.0690])
        gone = np.full(5, np.nan)
        one = make_rows([[path, gone], [gone, comparing.LENGTH - path[::-1]]])
        self.assertEqual(comparing.leading_notch(one).tolist(), [0, 1])
        np.testing.assert_allclose(comparing.leading_path(one), [path, path])
        np.testing.assert_allclose(comparing.distances(comparing.leading_path(one)), [0], atol=1e-12)
        np.testing.assert_allclose(comparing.distances(path[None], np.array([path, path + 1e-3])), [0, 1e-3], atol=1e-12)
        self.assertAlmostEqual(float(comparing.path_distance(path, path + 1e-3)), 1e-3)

    def test_the_depth_of_the_target_load_is_found(self):
        depths = (4.0, 5.0, 6.0)
        runs = [make_rows(np.zeros((9, 2, 5)), f"{depth} mm, 5 mm",
                          TARGET_LOAD - 50 * (depth - 5.3) + np.array([-9, -4, -2, -1, 0, 1, 2, 3, 40])) for depth in depths]
        _, depth = tables.median_curve(runs)
        self.assertAlmostEqual(depth, 5.3, delta=0.01)
        low, high = tables.depth_interval(runs, 0)
        self.assertLess(low, 5.3)
        self.assertGreater(high, 5.3)
        wider = tables.depth_interval(runs, 10)
        self.assertGreater(wider[1] - wider[0], 2 * (high - low))

    def test_rows_come_back_from_their_file(self):
        z = np.random.default_rng(1).random((3, 2, 5))
        z[1, 1] = np.nan
        before = make_rows(z, "a label, with a comma", [1.5, 2.5, np.nan])
        with tempfile.TemporaryDirectory() as folder:
            rows.write_csv([before], Path(folder) / "rows.csv")
            (after,) = rows.read_csv(Path(folder) / "rows.csv")
        self.assertEqual(after.label, before.label)
        np.testing.assert_allclose(after.z, before.z, rtol=1e-5)
        np.testing.assert_array_equal(after.values["onset_force"], before.values["onset_force"])


    def test_samples_of_another_input_do_not_stay(self):
        known = make_rows(np.zeros((3, 2, 5)), onset=[1, 2, 3])
        found = replace(make_rows(np.zeros((2, 2, 5)), onset=[4, 5]), input="another")
        with self.assertRaisesRegex(RunError, "the 3 samples of run that are kept are of another input"):
            rows.joined(known, found)
        paper = STUDIES["campaign"][0].input_text()
        self.assertEqual(rows.digest(paper), rows.digest("# A comment\n" + paper.replace("samples = 200", "samples = 9")))
        self.assertNotEqual(rows.digest(paper), rows.digest(paper.replace("seed = 2026", "seed = 1")))

    def test_samples_that_were_computed_elsewhere_stay(self):
        known, found = make_rows(np.zeros((3, 2, 5)), onset=[1, 2, 3]), make_rows(np.ones((2, 2, 5)), onset=[20, 40])
        known.sample[:], found.sample[:] = [0, 1, 2], [1, 3]
        both = rows.joined(known, found)
        self.assertEqual(both.sample.tolist(), [0, 1, 2, 3])
        self.assertEqual(both.values["onset_force"].tolist(), [1, 20, 3, 40])
        self.assertEqual(both.z[:, 0, 0].tolist(), [0, 1, 0, 1])


class Tables(unittest.TestCase):
    @staticmethod
    def bases(setting: str, onsets: list[list[float]], forks=None) -> list[rows.Rows]:
        made = []
        for seed, onset in enumerate(onsets):
            one = make_rows(np.zeros((len(onset), 2, 5)), setting, onset, name=f"{setting}-base-{seed}")
            one.values["bifurcations_projected"][:] = np.nan if forks is None else forks[seed]
            made.append(one)
        return made

    @staticmethod
    def cells(table: str, line: int) -> list[str]:
        return [cell.strip() for cell in table.splitlines()[line + 2].strip("|").split("|")]

    def test_the_same_bases_are_compared_by_pairs(self):
        usual = self.bases("usual", [[500, 502], [520, 522], [540, 542]])
        other = self.bases("other", [[503, 505], [524, 526], [543, 545]])
        for same_bases, difference in ((True, r"524 \(\+3.3 ± 1.4\)"), (False, r"524 \(\+3.3 ± \d\d.\d\)")):
            table = tables.on_bases("setting", "usual", [("usual", usual), ("other", other)], same_bases)
            self.assertRegex(self.cells(table, 1)[2], difference)
        self.assertEqual(self.cells(table, 0)[2], "521")
        self.assertEqual(self.cells(table, 0)[6:8], ["–", "–"], "forks that were not counted are not none")
        counted = [self.bases(setting, 3 * [[500, 502]], forks) for setting, forks in (("usual", ([0, 0], [0, 1], [1, 1])), ("other", 3 * ([0, 0],)))]
        table = tables.on_bases("setting", "usual", list(zip(("usual", "other"), counted)), True)
        self.assertEqual(self.cells(table, 0)[6:8], ["50", "1 / 1 / 1"])
        self.assertEqual(self.cells(table, 1)[7], "3 / 0 / 0")
        self.assertIn("+0.000 in every base", self.cells(table, 1)[5])

    def test_what_was_not_counted_is_not_none(self):
        one = make_rows(np.zeros((4, 2, 5)))
        one.values["bifurcations_projected"][:] = [0, 1, 2, 0]
        one.values["long_forks"][:] = np.nan
        self.assertEqual(self.cells(tables.branching([one]), 0)[5:7], ["50 % (15 to 85)", "–"])

    def test_few_samples_and_runs_give_tables_too(self):
        one = make_rows(np.full((1, 2, 5), np.nan), "2012", [380.0], name="base-2012")
        self.assertIn("| 2012 | 1 |", tables.bases([one]))
        run = Run("other", "other", 1, reference="base-2012")
        self.assertIn("| other | 1 |", tables.comparison({"base-2012": one, "other": one}, [(run, replace(one, name="other", label="other"))]))


class Course(unittest.TestCase):
    def test_stations_are_crossed_when_enough_of_the_thickness_is(self):
        # Squares across the advance-thickness plane: a tenth of the thickness by a fiftieth of the ligament each.
        def facet(i, k):
            x, y = np.array([0, 0, 1, 1]) * 0.1 + 0.1 * i, np.array([0, 1, 1, 0]) * 0.02 + 0.02 * k
            return x, y

        facets = [(*facet(i, k), 10.0 * k + i) for k in range(20) for i in range(4)]
        facets += [(*facet(i, 30), 1.0) for i in range(2)]  # ahead, but a fifth of the thickness only
        x, y, time = (np.array(column) for column in zip(*facets))
        arrival = course.arrivals(x, y, time)
        # Three of the four squares of each row make three tenths.
        np.testing.assert_allclose(arrival[:20], 10.0 * np.arange(20) + 2)
        self.assertTrue(np.all(np.isinf(arrival[20:])))
        self.assertAlmostEqual(course.reach_at(arrival, np.inf), 0.4)
        self.assertAlmostEqual(course.reach_at(arrival, 102.0), 0.22)
        self.assertEqual(course.reach_at(arrival, 1.0), 0)
        self.assertEqual(course.time_of(arrival, 0.06), 22)
        self.assertTrue(np.isnan(course.time_of(arrival, 0.8)))
        self.assertTrue(np.all(np.isinf(course.arrivals(np.empty((0, 4)), np.empty((0, 4)), np.empty(0)))))

    def test_the_speed_before_a_fork_is_that_of_the_arrivals(self):
        ligament, speed = 22e-3, 700.0
        station = (np.arange(course.STATIONS) + 0.5) * ligament / course.STATIONS
        arrival = station / speed
        self.assertAlmostEqual(course.speed_before(arrival, ligament, 12e-3), speed)
        arrival[station > 12e-3] += 5e-6  # what comes after the fork does not matter
        self.assertAlmostEqual(course.speed_before(arrival, ligament, 12e-3), speed)
        arrival[23] += 30e-6  # one that is covered late hardly does
        self.assertAlmostEqual(course.speed_before(arrival, ligament, 12e-3), speed, delta=0.03 * speed)
        self.assertTrue(np.isnan(course.speed_before(arrival, ligament, 1.5e-3)), "too near to the notch")
        arrival[:] = np.inf
        self.assertTrue(np.isnan(course.speed_before(arrival, ligament, 12e-3)))

    def test_groups_by_reach_are_about_the_programs_patterns(self):
        (found,) = rows.read_csv(ROOT / "jobs" / "paper" / "clock-from-zero.csv")
        one, two, other = comparing.groups(found, comparing.DEVELOPED)
        print(f"one / two / other: {one} / {two} / {other}, patterns {[found.share(p) for p in (1, 2, 3)]}")
        self.assertAlmostEqual(one / len(found), found.share(1) / len(found), delta=0.02)
        self.assertEqual(other, found.share(3))

    def test_the_load_of_a_held_bar_is_dalemberts(self):
        transit = 0.14 / ramp.BAR_SPEED
        # At the held end the load doubles from the first arrival on, until the free end's answer comes.
        at_end = ramp.section_load(1e6, np.array([0.5, 1.5, 2.5, 3.5, 5]) * transit, 0.0, 0.14)
        np.testing.assert_allclose(at_end / (1e6 * transit), [0, 1, 3, 4, 4], rtol=1e-9, atol=1e-12)
        slow = ramp.section_load(5.0, np.array([10.0, np.nan]), 0.07, 0.14)
        self.assertAlmostEqual(slow[0], 50, delta=1e-3)
        self.assertTrue(np.isnan(slow[1]))


class Fringes(unittest.TestCase):
    def test_roughness_is_that_of_noise_and_not_of_a_slope(self):
        y, z = np.meshgrid(np.linspace(0, 1, 200), np.linspace(0, 1, 300))
        slope = 3 + y + 2 * z
        inside = (slice(20, -20), slice(20, -20))
        self.assertLess(fringes.roughness(slope[inside], slope.mean()), 5e-3)
        noise = np.random.default_rng(1).normal(0, 0.5, slope.shape)
        # What a mean over n pixels takes away from noise is 1 - 1/n of its variance.
        self.assertAlmostEqual(fringes.roughness(5 + noise, 1), 0.5 * np.sqrt(1 - 1 / 121), delta=0.01)
        with_gap = 5 + noise
        with_gap[50:60] = np.nan
        self.assertAlmostEqual(fringes.roughness(with_gap, 2), 0.25, delta=0.01)

    def test_a_crack_and_its_margin_are_marked(self):
        grid = Grid.over((0, 2e-3), (0, 3e-3), fringes.PIXEL)
        marked = fringes.near(np.array([1.05e-3, 9.0]), np.array([2.05e-3, 0.0]), grid, 3)
        self.assertEqual(marked.shape, (30, 20))
        rows_of, columns = np.nonzero(marked)
        self.assertEqual((rows_of.min(), rows_of.max(), columns.min(), columns.max()), (17, 23, 7, 13))
        self.assertEqual(marked.sum(), 49)

    def test_likeness_is_not_changed_by_the_load(self):
        order = np.random.default_rng(1).random((20, 20))
        order[3] = np.nan
        self.assertAlmostEqual(fringes.likeness(order, 1.2 * order), 1)
        self.assertAlmostEqual(fringes.likeness(order, 1 - order), -1)


class Running(unittest.TestCase):
    def test_gaps_between_known_samples(self):
        self.assertEqual(list(gaps(6, frozenset([1, 2, 5]))), [(0, 0), (3, 4)])
        self.assertEqual(list(gaps(3, frozenset([0, 1, 2]))), [])
        self.assertEqual(list(gaps(2, frozenset())), [(0, 1)])

    def test_tables_of_the_same_input_are_known(self):
        table = ROOT / "jobs" / "paper" / "own.csv"
        kept = {one.input for one in rows.read_csv(table)}
        self.assertEqual(len(kept), 1)
        with tempfile.TemporaryDirectory() as folder:
            for digest, samples in ((rows.digest(OWN.input_text()), list(range(200))), ("0" * 16, [])):
                (Path(folder) / "own.csv").write_text(table.read_text().replace(kept.copy().pop(), digest))
                known = known_of(OWN, Path(folder))
                self.assertEqual((sorted(known.samples), known.ensemble), (samples, None))

    def test_a_run_that_was_stopped_goes_on(self):
        run = Run("small", "small", 3, {"mesh.notch_spacing": '"1.2 mm"', "time.duration": '"90 us"'}, source="demo")
        with tempfile.TemporaryDirectory() as folder:
            output = Path(folder)
            self.assertFalse(compute(run, output, OPTIONS.program, 1, time.monotonic() + 1), "no time to start")
            subprocess.run([OPTIONS.program, "run", output / "small" / "input.toml", "-o", output / "small" / "out",
                            "--samples", "0-0"], capture_output=True, check=False)
            self.assertTrue(compute(run, output, OPTIONS.program, 2, None))
            log = (output / "small" / "log.txt").read_text()
            self.assertIn("2 of 3 samples to do", log)
            self.assertTrue(compute(run, output, OPTIONS.program, 2, None))
            self.assertEqual((output / "small" / "log.txt").read_text(), log, "a finished run is not started again")
            for name in ("campaign", "clock-from-zero", "fast", "branching-center", "branching-own"):
                (output / name).symlink_to("small")
            for name in ("base-2012", "base-1", "base-2", "perturbation-0.1-base-1", "perturbation-0.1-base-2",
                         "perturbation-0.2-base-1", "perturbation-0.2-base-2", "spacing-0.4-base-1", "spacing-0.4-base-2", "both-vary-base-1", "both-vary-base-2"):
                (output / name).symlink_to("small")
            for name in ("rate-1e6", "steps-auto", "steps-verlet", "own", "softening"):
                (output / name).symlink_to("small")
            keep(["branching", "bases", "campaign", "own", "softening", "steps", "clock-from-zero", "convergence", "spacing", "disturbance", "heterogeneity", "rate"], output, output / "kept", of_any_input=True)
            kept = {file.name for file in (output / "kept").iterdir()}
            self.assertLessEqual({"ensemble.h5", "branching.csv", "branching.png", "campaign.csv", "convergence.csv", "fringes.csv", "fringes.png",
                                  "second-crack.png", "spacing.png", "disturbance.png", "heterogeneity.png", "rate.png", "crossings.png",
                                  "growth-1.png", "own.csv", "softening.csv", "steps.csv", "fringes-laws.png"}, kept)
            found = rows.read(run, output / "small" / "out")
            self.assertTrue(np.all(np.maximum(found.values["reach_0"], found.values["reach_1"]) > 0.2))
            self.assertEqual(rows.read_csv(output / "kept" / "campaign.csv")[0].sample.tolist(), [0, 1, 2])
            self.assertEqual(found.sample.tolist(), [0, 1, 2])
            self.assertTrue(np.all(found.values["onset_force"] > 0))
            (output / "branching-own").unlink()
            keep(["branching"], output, output / "kept", of_any_input=True)
            self.assertEqual([one.name for one in rows.read_csv(output / "kept" / "branching.csv")],
                             ["branching-center", "branching-own"], "a run that is not here keeps its rows")
            keep(["campaign"], output, output / "none")
            self.assertFalse((output / "none" / "campaign.csv").exists(), "these samples are not the study's")
            # Nothing that is kept is lost to fewer samples.
            (output / "fewer" / "out").mkdir(parents=True)
            with h5py.File(output / "small" / "out" / "ensemble.h5") as file:
                status = file["samples/status"][...]
            with h5py.File(output / "fewer" / "out" / "ensemble.h5", "w") as file:
                file["samples/status"] = np.where(np.arange(3) == 1, 0, status)
            with self.assertRaisesRegex(RunError, "has 1 samples that .* lacks"):
                keep_ensemble(output / "fewer" / "out", output / "kept")
            # Elsewhere only what the tables do not hold is computed, and ensemble.h5 has it all.
            known = Known(frozenset([1]), output / "kept" / "ensemble.h5")
            for _ in range(2):
                self.assertTrue(compute(run, output / "elsewhere", OPTIONS.program, 2, None, known))
            results = output / "elsewhere" / "small" / "out"
            log = output / "elsewhere" / "small" / "log.txt"
            self.assertEqual(log.read_text().count("1 of 3 samples to do"), 2)
            (results / "ensemble.h5").unlink()
            self.assertTrue(compute(run, output / "elsewhere", OPTIONS.program, 2, None, known))
            self.assertEqual(log.read_text().count("1 of 3 samples to do"), 2)
            self.assertEqual(sorted(file.name for file in (results / "samples").glob("*.h5")), ["0000.h5", "0002.h5"])
            with h5py.File(results / "ensemble.h5") as merged, h5py.File(output / "kept" / "ensemble.h5") as whole:
                self.assertEqual(merged["samples/status"][...].tolist(), [1, 1, 1])
                np.testing.assert_array_equal(merged["crack_path/position"][...], whole["crack_path/position"][...])
            self.assertEqual(rows.read(run, results).sample.tolist(), [0, 2])
            self.assertEqual(known_of(STUDIES["campaign"][0], output / "kept"), Known(), "these tables are of another input")
            with self.assertRaises(RunError):
                compute(replace(run, keys={**run.keys, "fracture.strength": '"36 MPa"'}), output, OPTIONS.program, 2, None)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", required=True)
    OPTIONS, remaining = parser.parse_known_args()
    os.environ["CRACKLE"] = os.path.abspath(OPTIONS.program)
    unittest.main(argv=[sys.argv[0], *remaining])
