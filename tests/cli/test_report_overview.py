#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of what a report says first: headlines, tables, limits of axes, and the report of a sweep."""
from __future__ import annotations

import argparse
import os
import re
import sys
import tempfile
import unittest
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import h5py
import numpy as np
from matplotlib.figure import Figure

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "cli")]

import crackle  # noqa: E402
import in_process  # noqa: E402
import small_input  # noqa: E402
from crackle.program import statistics_of  # noqa: E402
from crackle_report import command, page, reading, sweep, tables  # noqa: E402
from crackle_report.figures import crack_paths, histories, shares  # noqa: E402
from crackle_report.options import Options  # noqa: E402
from crackle_report.results import Result  # noqa: E402
from synthetic_ensemble import SLOTS, changed, write_ensemble  # noqa: E402
from test_report import Ensembles  # noqa: E402


class Headlines(Ensembles):
    """What a report says first."""

    def test_the_peak_load_where_the_onset_says_nothing(self):
        for with_peaks in (False, True):
            write_ensemble(self.folder, 6)
            with h5py.File(self.folder / "ensemble.h5", "r+") as root:
                onset = root["samples/onset_force"][...]
                root["samples/peak_load"][:] = 1.01 * onset
                if with_peaks:
                    root["samples/onset_force"][2] = 0.2
            ensemble = reading.read_ensemble(self.folder)
            shown, name = (1.01 * onset, "peak load") if with_peaks else (onset, "onset force")
            self.assertEqual(ensemble.load.label, name)
            np.testing.assert_array_equal(ensemble.loads, shown)
            self.assertIn(f"<b>{np.median(shown):.0f} N</b><span>median {name} ({shown.min():.0f} to {shown.max():.0f} N)", tables.tiles(ensemble))
            section = shares.section(ensemble, Options())
            self.assertEqual(section.title, f"Patterns and {name}")
            self.assertEqual(section.pictures[0].figure.axes[1].get_xlabel(), f"{name} [N]")
            self.assertEqual([warning for warning in ensemble.warnings if "before the last dynamic phase" in warning] != [], with_peaks)

    def test_loads_of_which_only_bounds_are_known(self):
        load = Result("peak_load", "peak load", "N", 1.0, ".3f", [], 0, None, (50.0, 60.0, np.nan, np.nan, np.nan), (np.nan,) * 2 + (70.0,) * 3, 5)
        self.assertEqual(tables._load(load), ("over 70 N", "median peak load (50 to over 70 N; 5 bore more)"))

    def test_warnings_of_the_program_stand_at_the_top(self):
        write_ensemble(self.folder, 6)
        with h5py.File(self.folder / "ensemble.h5", "r+") as root:
            root["samples/crack_speed_ratio"][:] = [0.5, 1.5, 0.5, 1.7, 1.9, 2.5]
        self.assertEqual(self.run_report(self.folder, sections=()).returncode, 0)
        found = re.findall('<p class="notice">(.*?)</p>', (self.folder / "report.html").read_text(encoding="utf-8"))
        self.assertEqual([text.split(" times")[0] for text in found], ["In 4 samples a crack runs at more than 0.85"])

    def test_of_many_warnings_the_first_are_shown(self):
        shown = page._warnings(SimpleNamespace(warnings=[f"warning: sample {number} is odd" for number in range(page.MOST_WARNINGS + 1)]))
        texts = [*(f"Sample {number} is odd." for number in range(page.MOST_WARNINGS)), "1 more warning: crackle stats prints all."]
        self.assertEqual(shown, [f'<p class="notice">{text}</p>' for text in texts])

    def test_tables_leave_out_what_is_empty_or_the_same(self):
        write_ensemble(self.folder, 6, slots=SLOTS[:1], leading=[0] * 6)
        ensemble = reading.read_ensemble(self.folder)
        rows = [re.findall("<td.*?>(.*?)</td>", row) for row in re.findall("<tr>.*?</tr>", tables.sections(ensemble))[1:]]
        self.assertTrue(rows)
        self.assertFalse([row for row in rows if row[2].startswith("0 ")])
        self.assertEqual(len({tuple([row[2].split()[0], row[1], *row[3:]]) for row in rows}), len(rows), rows)
        self.assertNotIn("all of notch 0", {row[0] for row in rows})
        self.assertIn("<td class=\"text\">notch 0</td>", tables.samples(ensemble))

    def test_breaks_at_supports_do_not_stretch_the_panels(self):
        write_ensemble(self.folder, 3)
        limits = []
        for notch in (None, -1, 0):  # of a facet at the upper end of the body
            if notch is not None:
                with changed(self.folder / "samples" / "0001.h5") as root:
                    surface = root["crack_surface"]
                    surface["corners"][0, :, 2] = 139e-3
                    surface["crack"][0] = surface["cracks/notch"][...].tolist().index(notch)
            section = crack_paths.typical(reading.read_ensemble(self.folder), Options())
            limits.append(section.pictures[0].figure.axes[0].get_ylim())
            self.assertEqual("lies outside the panels" in section.text, notch == -1)
        self.assertEqual(limits[0], limits[1])
        self.assertGreater(limits[2][1], 139)

    def test_an_outlier_does_not_stretch_the_bins(self):
        values = np.append(np.linspace(700, 780, 19), 0.2)
        edges = shares._bins(values)
        self.assertLess(np.diff(edges).max(), 60)
        self.assertGreater(edges[0], 300)
        self.assertEqual((edges[0] <= 700, edges[-1] >= 780), (True, True))

    def test_speeds_are_not_cut_off_silently(self):
        axes = Figure().subplots()
        axes.plot([0, 1], [400, 1700])
        self.assertGreater(histories._top(axes, 950), 1700)
        self.assertEqual(len(axes.texts), 0)
        axes.plot([0, 1], [np.nan, 56000])
        self.assertLess(histories._top(axes, 950), 3000)
        self.assertEqual(axes.texts[0].get_text(), "↑ up to 56,000")


class Sweeps(unittest.TestCase):
    SWEEP = """[[sweep]]
key = "fracture.strength"
values = ["35 MPa", "45 MPa"]
[[sweep]]
key = "fracture.release"
values = ["facet", "element"]
"""

    def test_results_are_drawn_over_the_swept_values(self):
        with tempfile.TemporaryDirectory() as name:
            program = os.environ["CRACKLE"]
            folder = small_input.run(Path(program), small_input.small_input(self.SWEEP, samples=2), Path(name) / "out")
            document = statistics_of(folder)
            self.assertEqual([one["folder"] for one in document["cases"]], ["case-0", "case-1", "case-2", "case-3"])
            (column,) = (k for k, one in enumerate(document["results"]) if one["name"] == "peak_load")
            for one in document["cases"]:
                of_case = crackle.open(folder / one["folder"]).samples["peak_load"]
                self.assertAlmostEqual(one["value"][column], of_case.mean(), delta=1e-9 * of_case.mean())
                self.assertAlmostEqual(one["upper"][column] - one["lower"][column], 2 * 12.7062 * of_case.std() / np.sqrt(2), delta=1e-3 * of_case.std())
            result = in_process.report(folder, "--no-animation", kind="png")
            self.assertEqual((result.returncode, result.stderr), (0, ""))
            page = (folder / "report.html").read_text(encoding="utf-8")
            self.assertIn("crackle: sweep out", page)
            self.assertNotIn("case-0/report.html", page)
            self.assertTrue((folder / "report" / "sweep.svg").is_file())
            (axes,) = (axes for axes in sweep.section(document).pictures[0].figure.axes if axes.get_title(loc="left") == "peak load [N]")
            self.assertEqual(axes.get_xlabel(), "fracture.strength [MPa]")
            self.assertEqual([container.get_label() for container in axes.containers], ["fracture.release = facet", "fracture.release = element"])
            drawn = [container.lines[0].get_xydata() for container in axes.containers]
            peaks = [one["value"][column] for one in document["cases"]]
            np.testing.assert_allclose(drawn, [[(35, peaks[0]), (45, peaks[2])], [(35, peaks[1]), (45, peaks[3])]])
            with mock.patch.object(command, "SECTIONS", command.SECTIONS[:1]):  # of each case's report
                self.assertEqual(in_process.report(folder, "--cases", "--no-animation", "--no-fringes").returncode, 0)
            self.assertEqual(len(list(folder.glob("case-*/report.html"))), 4)
            self.assertIn('<a href="case-3/report.html">case-3</a>', (folder / "report.html").read_text(encoding="utf-8"))
            refused = in_process.report(folder, "--sample", "0")
            self.assertEqual(refused.returncode, 1)
            self.assertIn("holds a sweep", refused.stderr)

    def test_values_that_are_numbers(self):
        for values, expected, unit in (([0.1, 2], [0.1, 2], ""), (["5 J/m^2", "20 J/m^2"], [5, 20], "J/m^2"),
                                       (["1 MPa m^0.5", "2 MPa m^0.5"], [1, 2], "MPa m^0.5"), (["0.5 mm", "2000 um"], [0.5, 2], "mm")):
            numbers, name = sweep._numbers(values)
            np.testing.assert_allclose(numbers, expected)
            self.assertEqual(name, unit)
        for words in (["facet", "element"], ["1 mm", "1 N"], [True, False], [[1, 2], [3, 4]]):
            self.assertEqual(sweep._numbers(words), (None, ""))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    options, rest = parser.parse_known_args()
    os.environ["CRACKLE"] = os.path.abspath(options.program)
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
