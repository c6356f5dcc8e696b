#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of tools/crackle-report on invented ensembles."""
from __future__ import annotations

import argparse
import base64
import dataclasses
import itertools
import os
import re
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree
from pathlib import Path
from unittest import mock

import h5py
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.text import Text
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "cli")]

from crackle_report import choosing, command, drawing, figures, reading, style, tables  # noqa: E402
from crackle_report.figures import comparison, convergence, crack_paths, crossings, growth, material, sensitivity  # noqa: E402
from crackle_report.mesh import Mesh  # noqa: E402
from crackle_report.options import Options  # noqa: E402
from crackle_report.photoelasticity import Optics  # noqa: E402
import command_lines  # noqa: E402
import in_process  # noqa: E402
from box_mesh import box_mesh  # noqa: E402
from effort import repetitions  # noqa: E402
from synthetic_ensemble import SLOTS, changed, write_ensemble  # noqa: E402

REPORT = ROOT / "tools" / "crackle-report"


def overlapping_texts(figure) -> list[str]:
    """Pairs of visible texts whose boxes share more than half a point in both directions."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    boxes = {}
    for axes in [figure, *figure.axes]:
        for text in axes.findobj(Text):
            if text.get_visible() and text.get_text().strip():
                boxes[id(text)] = (text, text.get_window_extent(renderer).extents)
    # Ticks beyond the limits of an axis are not drawn.
    for axis in itertools.chain.from_iterable((axes.xaxis, axes.yaxis) for axes in figure.axes):
        drawn = {id(label) for tick in axis._update_ticks() for label in (tick.label1, tick.label2)}
        ticks = [*axis.majorTicks, *axis.minorTicks]
        for hidden in {id(label) for tick in ticks for label in (tick.label1, tick.label2)} - drawn:
            boxes.pop(hidden, None)
    texts = [text.get_text() for text, _ in boxes.values()]
    corners = np.array([extents for _, extents in boxes.values()]).reshape(-1, 4)
    shared = np.minimum(corners[:, None, 2:], corners[:, 2:]) - np.maximum(corners[:, None, :2], corners[:, :2])
    overlap = np.triu((shared > 0.5 * figure.dpi / 72).all(axis=2), k=1)
    return [f"'{texts[a]}' and '{texts[b]}'" for a, b in np.argwhere(overlap)]


class Ensembles(unittest.TestCase):
    """Folders with invented results."""

    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.folder = Path(self._folder.name) / "demo"

    def run_report(self, *arguments: str, **options: object) -> subprocess.CompletedProcess:
        return in_process.report(*arguments, "--no-animation", "--no-fringes", **options)


class Report(Ensembles):
    def test_a_finished_ensemble_gives_a_page_in_one_file(self):
        rows = write_ensemble(self.folder, 2)
        result = in_process.call(command.main, self.folder)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stdout, f"report: {self.folder}/report.html\n")

        page = (self.folder / "report.html").read_text(encoding="utf-8")
        addresses = re.findall(r"""(?:src|href)\s*=\s*["']([^"']*)|url\(([^)]*)\)|@import""", page)
        images = [base64.b64decode(re.sub("^data:image/(png|gif);base64,", "", source)) for source, _ in addresses]
        for image in images:
            self.assertTrue(image.startswith((b"\x89PNG\r\n", b"GIF89a")))
        chosen = choosing.samples_in_detail(reading.read_ensemble(self.folder))
        detail = [f"growth-{i:04d}" for i in chosen]
        stems = ["convergence", "crack-paths", "crack-speed", "crossings", "energy", "load", "shares", *detail, *(f"surface-{i:04d}" for i in chosen)]
        files = {file.name: file.read_bytes() for file in (self.folder / "report").iterdir()}
        self.assertEqual(sorted(files), sorted([f"{stem}.{kind}" for stem in stems for kind in ("png", "svg")]
                                               + [f"{stem}.gif" for stem in detail]))
        self.assertEqual(sorted(images), sorted(files[name] for name in files if not name.endswith("svg")))
        for name in files:
            if name.endswith("svg"):
                xml.etree.ElementTree.parse(self.folder / "report" / name)
        for stem in detail:
            with Image.open(self.folder / "report" / f"{stem}.gif") as film:
                self.assertEqual(film.n_frames, 4)
                self.assertEqual(film.convert("RGB").getpixel((2, 2)), (255, 255, 255))

        self.assertEqual(re.findall(r">[^<]*\bnan\b[^<]*<", page), [])
        form = reading.read_ensemble(self.folder).samples.result("onset_force").format
        for row in rows:
            self.assertIn(f">{format(row['onset_force'], form)}<", page)
        self.assertIn("Open MPI 4.1.4, PETSc 3.18.5", page)
        self.assertIn("[[specimen.notch]]", page)
        self.assertNotIn("not finished", page)

        # The same results give the same files, in a process of its own too, which has another seed of hashes.
        if not repetitions(False, True):
            return
        result = subprocess.run([REPORT, self.folder], capture_output=True, check=False, env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual({file.name: file.read_bytes() for file in (self.folder / "report").iterdir()}, files)
        self.assertEqual((self.folder / "report.html").read_text(encoding="utf-8"), page)

    def test_a_failed_sample_is_shown_with_its_reason(self):
        write_ensemble(self.folder, 5, failed=(3,))
        with h5py.File(self.folder / "ensemble.h5", "r+") as root:
            root["samples/error"][3] = "quality 0.1 < 0.2 & no way out"
        self.assertEqual(self.run_report(self.folder, kind="svg", sections=(crack_paths.typical, crack_paths.every)).returncode, 0)
        page = (self.folder / "report.html").read_text(encoding="utf-8")
        self.assertIn("quality 0.1 &lt; 0.2 &amp; no way out", page)
        self.assertIn("4 of 5", page)
        self.assertIn("1 failed", page)
        self.assertIn(">failed<", (self.folder / "report" / "crack-paths.svg").read_text(encoding="utf-8"))

    def test_a_running_ensemble_has_the_statistics_of_what_is_there(self):
        finished = self.folder.with_name("finished")
        write_ensemble(finished, 12, failed=(4,))
        write_ensemble(self.folder, 12, failed=(4,), with_ensemble_file=False)
        (self.folder / "samples" / "0011.h5.partial").write_bytes(b"half of a file")
        for ensemble in (reading.read_ensemble(finished), reading.read_ensemble(self.folder)):
            z = ensemble.samples.position
            self.assertEqual(ensemble.samples.count(1), 11)
            np.testing.assert_allclose(ensemble.statistics.z_mean, np.nanmean(z, axis=0), rtol=1e-14)
            np.testing.assert_allclose(ensemble.statistics.z_std, np.nanstd(z, axis=0, ddof=1), rtol=1e-9)
        (self.folder / "samples" / "0007.h5").unlink()
        self.assertEqual(self.run_report(str(self.folder)).returncode, 0)
        page = (self.folder / "report.html").read_text(encoding="utf-8")
        self.assertIn("10 of 12", page)
        self.assertIn("1 failed, 1 pending", page)
        self.assertIn("not finished", page)

    def test_leading_and_following_cracks_are_distinguished(self):
        write_ensemble(self.folder, 8, failed=(3,))
        self.assertEqual(self.run_report(str(self.folder), sections=()).returncode, 0)
        page = (self.folder / "report.html").read_text(encoding="utf-8")
        for words in ("samples led by some notches: notch 1 as if notch 0 did", ">leading<", ">following<",
                      "all of notch 1, leading and following", "one set of mother points"):
            self.assertIn(words, page)
        write_ensemble(self.folder, 8, failed=(3,), leading=[0, 1] * 4)
        ensemble = reading.read_ensemble(self.folder)
        self.assertEqual(ensemble.leading.tolist(), [0, 1, 0, -1, 0, 1, 0, 1])
        self.assertEqual(self.run_report(str(self.folder), sections=()).returncode, 0)
        page = (self.folder / "report.html").read_text(encoding="utf-8")
        self.assertIn("notch 0 in 4, notch 1 in 3.", page)

    def test_samples_that_ensemble_h5_lacks_come_from_their_files(self):
        write_ensemble(self.folder, 8, pending=(5, 6))
        old = reading.read_ensemble(self.folder)
        self.assertEqual(old.samples.count(0), 2)
        write_ensemble(self.folder.with_name("whole"), 8)
        for number in ("0005", "0006"):
            source = self.folder.with_name("whole") / "samples" / f"{number}.h5"
            source.rename(self.folder / "samples" / f"{number}.h5")
        new = reading.read_ensemble(self.folder)
        self.assertTrue(new.finished)
        np.testing.assert_allclose(new.statistics.z_mean, np.nanmean(new.samples.position, axis=0), rtol=1e-14)
        self.assertGreater(new.statistics.reached.sum(), old.statistics.reached.sum())

    def test_sections_across_y_and_z_are_distinguished(self):
        write_ensemble(self.folder, 6)
        old = reading.read_ensemble(self.folder)
        self.assertEqual([section.name for section in old.sections][1:3], ["y = 9 mm", "y = 12.25 mm"])
        write_ensemble(self.folder, 6, slots=(SLOTS[0], ("z-max", 12, 6, 0.6)), leading=[0, 1] * 3,
                       sections=((1, 7), (1, 9), (1, 12.25), (2, 70), (2, 75)))
        ensemble = reading.read_ensemble(self.folder)
        np.testing.assert_array_equal(ensemble.samples.position, old.samples.position)
        self.assertEqual([(section.name, section.along) for section in ensemble.sections][2:4],
                         [("y = 12.25 mm", "z"), ("z = 70 mm", "y")])
        rows = re.findall("<tr>.*?</tr>", tables.sections(ensemble))
        leader = 1e3 * np.nanmean(ensemble.samples.position[1::2, 1], axis=0)
        for cracks, mean in (("all of notch 1, leading and following", 1e3 * np.nanmean(ensemble.samples.position[:, 1, 4])),
                             ("leading where notch 1 leads", leader[4])):
            (row,) = (row for row in rows if f"{cracks}</td><td>z = 75 mm</td>" in row)
            self.assertIn(f"<td>y = {mean:.2f}</td>", row)
        (picture,) = crossings.section(ensemble, Options()).pictures
        means = [line for line in picture.figure.axes[1].lines if line.get_marker() == "o"]
        np.testing.assert_allclose([means[0].get_xdata(), means[0].get_ydata()], [leader[3:], [70, 75]])
        self.assertEqual(picture.figure.axes[0].lines[0].get_xdata(), [7, 7])
        (picture,) = convergence.section(ensemble, Options()).pictures
        self.assertEqual([axes.get_title() for axes in picture.figure.axes][8:], ["notch 1 leads, z = 70 mm", "notch 1 leads, z = 75 mm"])
        self.assertEqual(picture.figure.axes[0].get_ylabel(), "mean position [mm]")

    def test_without_any_crack_or_section_there_is_still_a_page(self):
        write_ensemble(self.folder, 2, failed=(0, 1))
        result = self.run_report(str(self.folder), kind="png")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        page = (self.folder / "report.html").read_text(encoding="utf-8")
        self.assertIn("0 of 2", page)
        self.assertEqual(re.findall(r">[^<]*\bnan\b[^<]*<", page), [])

    def test_before_the_first_sample_has_ended_there_is_a_page(self):
        write_ensemble(self.folder, 2, with_ensemble_file=False)
        with h5py.File(self.folder / "samples" / "0000.h5") as root:
            text = root.attrs["input"]
        (self.folder / "input.toml").write_text(text if isinstance(text, str) else text.decode())
        for file in (self.folder / "samples").iterdir():
            file.unlink()
        result = self.run_report(str(self.folder), kind="png")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertIn("0 of 2", (self.folder / "report.html").read_text(encoding="utf-8"))

    def test_other_ensembles_are_compared_with_it(self):
        write_ensemble(self.folder, 12)
        other = self.folder.with_name("stronger")
        write_ensemble(other, 12)
        with h5py.File(other / "ensemble.h5", "r+") as file:
            file["samples/onset_force"][:] *= 1.1 + 0.01 * np.sin(np.arange(12))
        same = self.folder.with_name("same")
        write_ensemble(same, 8)
        result = self.run_report(str(self.folder), "--compare", str(other), "--compare", str(same), kind="png", sections=(comparison.section,))
        self.assertEqual(result.returncode, 0, result.stderr)
        page = (self.folder / "report.html").read_text()
        self.assertIn("Compared with other ensembles", page)
        self.assertRegex(page, r"stronger differs in onset force \(\+1[01]\.\d %\) \(12 pairs of samples with the same bodies\)")
        self.assertIn("same does not differ significantly", page)
        for number in (0, 1):
            self.assertTrue((self.folder / "report" / f"comparison-{number}.png").is_file())
        refused = self.run_report(str(self.folder), "--compare", str(self.folder.with_name("nowhere")))
        self.assertEqual(refused.returncode, 1)
        self.assertIn("nowhere", refused.stderr)

    def test_what_is_no_ensemble_ends_with_one_line(self):
        self.folder.mkdir()
        foreign = self.folder.with_name("foreign")
        foreign.mkdir()
        (foreign / "ensemble.h5").write_bytes(b"not HDF5")
        other = self.folder.with_name("other")
        other.mkdir()
        with h5py.File(other / "ensemble.h5", "w") as root:
            root.attrs["kind"] = "something else"
        incomplete = self.folder.with_name("incomplete")
        write_ensemble(incomplete, 2)
        with h5py.File(incomplete / "ensemble.h5", "r+") as root:
            del root["samples/pattern"]
        cases = {self.folder: "neither input.toml nor ensemble.h5 nor samples", foreign: "cannot use",
                 other: "not a crackle ensemble file", incomplete: "samples/pattern",
                 self.folder / "missing": "neither input.toml nor ensemble.h5 nor samples"}
        for folder, message in cases.items():
            with self.subTest(folder.name):
                result = self.run_report(str(folder))
                self.assertEqual(result.returncode, 1)
                self.assertEqual(result.stdout, "")
                self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
                self.assertIn(message, result.stderr)


    def test_an_ensemble_that_stopped_early_is_finished(self):
        write_ensemble(self.folder, 12, pending=tuple(range(6, 12)), stop='half_width = "1 m"\nmin_samples = 6')
        ensemble = reading.read_ensemble(self.folder)
        self.assertEqual((len(ensemble.samples), ensemble.finished), (6, True))
        self.assertEqual(ensemble.statistics.running_mean.shape[0], 6)
        self.assertEqual(self.run_report(str(self.folder), sections=()).returncode, 0)
        page = (self.folder / "report.html").read_text(encoding="utf-8")
        self.assertIn("6 of 6", page)
        self.assertIn("these suffice, 12 were planned", page)
        self.assertNotIn("not finished", page)

    def test_a_varying_strength_is_shown(self):
        write_ensemble(self.folder, 2)
        self.assertEqual(self.run_report(str(self.folder), sections=(material.section,)).returncode, 0)
        self.assertNotIn("<h2>Material</h2>", (self.folder / "report.html").read_text(encoding="utf-8"))
        for file in (self.folder / "samples").iterdir():
            with changed(file) as root:
                n = len(root["mesh/tetrahedra"])
                root["mesh/strength_factor"] = np.linspace(0.5, 1.5, n)
        result = self.run_report(str(self.folder), kind="png", sections=(material.section,))
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        page = (self.folder / "report.html").read_text(encoding="utf-8")
        self.assertIn("<h2>Material</h2>", page)
        self.assertIn("least 0.5, greatest 1.5", page)
        self.assertTrue((self.folder / "report" / "strength.png").is_file())

    def test_samples_and_times_can_be_chosen(self):
        write_ensemble(self.folder, 4, failed=(2,))
        result = in_process.report(self.folder, "--sample", "3", "--times", "0,40", "--field", "light", "--reverse", "--form",
                                   "integrated", "--wavelength", "600", "--no-animation", kind="svg", sections=(growth.section,))
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertEqual(sorted(file.name for file in (self.folder / "report").glob("growth*")),
                         ["growth-0003.png", "growth-0003.svg"])
        page = (self.folder / "report.html").read_text(encoding="utf-8")
        self.assertIn("(light field, colours reversed), by the integrated stress along each ray; wavelength 600 nm, "
                      "stress-optic coefficient assumed: 5.5e-11 1/Pa, typical of epoxy", page)
        drawn = (self.folder / "report" / "growth-0003.svg").read_text(encoding="utf-8")
        self.assertIn("t = t₀ + 40 µs", drawn)
        for arguments, message in ((("--sample", "2"), "sample 2 is not done; done are 0, 1, 3"),
                                   (("--times", "x"), "not a list of times")):
            result = self.run_report(str(self.folder), *arguments, sections=())
            self.assertNotEqual(result.returncode, 0)
            self.assertIn(message, result.stderr)

    def test_the_verdict_says_how_many_samples_it_takes(self):
        write_ensemble(self.folder, 12)
        ensemble = reading.read_ensemble(self.folder)
        self.assertRegex(convergence._verdict(ensemble), "^Were 12 samples enough[?] (Yes|No): ")
        ensemble.precision = {"half_width": 0.226e-3, "row": 0, "section": 2, "half_width_wanted": 0.1e-3,
                              "is_of_the_input": True, "n_samples_needed": 196.5}
        self.assertIn("No: the mean position of the leading crack is known to ±0.23 mm at its least certain "
                      "section (y = 12.25 mm); ±0.1 mm (as the input asks for) would take about 200 samples",
                      convergence._verdict(ensemble))
        ensemble.precision["half_width_wanted"] = 0.23e-3
        self.assertIn("Yes: ", convergence._verdict(ensemble))
        for needed in (None, 2.0):  # of two samples with one draw
            ensemble.precision |= {"half_width": None, "n_samples_needed": needed}
            self.assertIn("No: all that have reached y = 12.25 mm have one draw", convergence._verdict(ensemble))
        write_ensemble(self.folder, 1)
        self.assertIn("to tell whether there are enough", convergence._verdict(reading.read_ensemble(self.folder)))

    def test_loads_of_samples_that_were_held_are_bounds(self):
        write_ensemble(self.folder, 8)
        ensemble = reading.read_ensemble(self.folder)
        loads, table = ensemble.loads, ensemble.samples
        self.assertTrue(np.isfinite(loads).all())
        table.numbers["held"], table.numbers["outcome"][2] = np.array([0, 0, 0, 1, 0, 0, 1, 0]), 0
        known = np.isin(np.arange(8), (2, 3, 6), invert=True)
        del ensemble.loads
        np.testing.assert_array_equal(ensemble.loads, np.where(known, loads, np.nan))
        # Where an ensemble has random inputs, they are drawn as what they bore.
        table.numbers["peak_load"] = loads + 1
        ensemble.inputs = [{"key": "fracture.strength", "units": "Pa", "values": list(range(8))}]
        ensemble.sensitivities = {"n_draws": 8}
        effect = {"total": {"value": 0.5}, "rank_correlation": {"value": 0.5}}
        for name, n_bounds in (("onset_force", 3), ("work_of_fracture", 0)):
            row = {"result": name, "share_of": "", "predicted": 0.5, "n_draws": 8, "n_bounds": n_bounds, "inputs": [effect]}
            drawn = [line.get_xydata() for line in sensitivity._scatter([row], ensemble).axes[0].lines]
            factor = table.result(name).factor
            np.testing.assert_allclose(drawn[0], np.stack([np.arange(8), factor * table.numbers[name]], axis=1)[known])
            np.testing.assert_allclose(drawn[1:], [np.stack([np.arange(8), factor * (loads + 1)], axis=1)[~known]] if n_bounds else [])

    def test_where_cracks_take_several_paths_each_group_has_its_mean(self):
        write_ensemble(self.folder, 14, with_ensemble_file=False, leading=[0] * 14)
        for i in (2, 6, 9):
            with changed(self.folder / "samples" / f"{i:04d}.h5") as root:
                root["summary/position"][0] += 30e-3
        ensemble = reading.read_ensemble(self.folder)
        leader = ensemble.ranks["leader"]
        self.assertEqual([group.n for group in leader.groups][1], 3)
        self.assertTrue(leader.is_divided.any())
        below, above = leader.by_group(0, "z_mean")
        apart = leader.is_divided[0].astype(bool) & np.isfinite(below) & np.isfinite(above)
        self.assertTrue((above[apart] - below[apart] > 20e-3).all())
        table = tables.sections(ensemble)
        self.assertIn("several paths", table)
        self.assertNotIn("all of notch 0", table, "it has no other mean where all cracks lead")
        self.assertRegex(table, r"leading: path 2 of 2, 3 of 1\d samples, \d+ % \(\d+ to \d+ %\)")
        means = [line for line in crossings._draw(ensemble).axes[0].lines if line.get_marker() == "o"]
        self.assertEqual(len(means), 2)
        self.assertRegex(convergence._verdict(ensemble), r"of the \d+ of 1\d samples that take one path|y = 7 mm")


class Pictures(Ensembles):
    def test_labels_do_not_overlap(self):
        style.apply()
        for n_samples in repetitions((13,), (1, 6, 31)):
            folder = self.folder.with_name(f"of-{n_samples}")
            write_ensemble(folder, n_samples, failed=(1,) if n_samples > 2 else ())
            ensemble = reading.read_ensemble(folder)
            sections = [make_section(ensemble, Options((0,), animation=False)) for make_section in figures.SECTIONS]
            for section in filter(None, sections):
                for picture in section.pictures:
                    with self.subTest(f"{n_samples} samples, {picture.name}"):
                        self.assertEqual(overlapping_texts(picture.figure), [])


    def test_what_slow_loading_opens_minutes_later_does_not_stretch_the_colours(self):
        write_ensemble(self.folder, 2)
        ensemble = reading.read_ensemble(self.folder)
        crack = ensemble.files.crack(0)
        late = dataclasses.replace(crack, time=np.append(crack.time[:-1], 300.0))
        latest = late.last_opening
        self.assertEqual(latest, crack.time[:-1].max())
        rgb = drawing.facet_colours(1e6 * np.array([-1e-6, latest, 300.0]), drawing.time_colours(latest))
        np.testing.assert_allclose(rgb, [to_rgb(style.BEFORE_ONSET), style.TIME_COLOURS(1.0)[:3], to_rgb(style.AFTER_PHASE)])

    def test_many_samples_are_spread_over_sheets(self):
        write_ensemble(self.folder, 9)
        with mock.patch.object(crack_paths, "PANELS_PER_SHEET", 4):
            pictures = crack_paths.every(reading.read_ensemble(self.folder), Options()).pictures
        self.assertEqual([picture.name for picture in pictures],
                         ["crack-paths-0000-0003", "crack-paths-0004-0007", "crack-paths-0008-0008"])

    def test_of_very_many_samples_the_first_are_drawn(self):
        write_ensemble(self.folder, 12, pending=(1, 10, 11))
        ensemble = reading.read_ensemble(self.folder)
        with mock.patch.object(crack_paths, "MOST_PANELS", 4):
            section = crack_paths.every(ensemble, Options())
        self.assertEqual(section.title, "Crack paths of 4 samples")
        self.assertIn("of samples 0, 2, 3, 4 on", section.pictures[0].description)
        self.assertIn("The first samples computed, of 12", section.text)

    def test_typical_samples_stand_for_all(self):
        write_ensemble(self.folder, 30, failed=(4,))
        ensemble = reading.read_ensemble(self.folder)
        samples = ensemble.samples
        chosen = choosing.typical_samples(ensemble, 8)
        branching = samples.bifurcations_projected
        kinds = [(int(samples.pattern[i]), bool(branching[i])) for i in ensemble.done]
        print("chosen", [(i, kinds[list(ensemble.done).index(i)]) for i in chosen])
        self.assertEqual(len(set(chosen)), 8)
        self.assertNotIn(4, chosen)
        for kind in set(kinds):
            group = [int(i) for i, of in zip(ensemble.done, kinds) if of == kind]
            taken = [i for i in chosen if i in group]
            self.assertGreaterEqual(len(taken), 1)
            self.assertLess(abs(len(taken) - 8 * len(group) / len(kinds)), 1.5)
            # The first is the one with the least sum of distances to the others.
            z = samples.position[group].reshape(len(group), -1)
            sums = [sum(np.nanmean(np.abs(np.where(np.isnan(a) == np.isnan(b), np.nan_to_num(a - b), 24.5e-3)))
                        for b in z) for a in z]
            self.assertEqual(taken[0], group[int(np.argmin(sums))])
        self.assertEqual([int(samples.pattern[i]) for i in choosing.samples_in_detail(ensemble)], [1, 2])
        # Of the samples with two cracks the one that branches is shown, typical or not.
        two = [int(i) for i in ensemble.done if samples.pattern[i] == 2]
        for only in two[:3]:
            branching[:] = 0
            branching[only] = 1
            self.assertEqual(choosing.samples_in_detail(ensemble)[1], only)

    def test_fringes_are_those_of_the_frames(self):
        write_ensemble(self.folder, 1)
        ensemble = reading.read_ensemble(self.folder)
        frames = ensemble.files.frames(0)
        optics = Optics(stress_optic=3e-11, wavelength=600e-9)
        view = growth._View(ensemble, 0, frames, ensemble.files.crack(0), Options(stress_optic=(3e-11,), wavelength=600e-9))
        for k, factor in enumerate((1, 1.1, 1.2, 1.3)):
            order = view._fringes[k].order
            expected = optics.order_per_stress_length * 3300e6 * 1e-3 * factor * 5e-3
            print(f"frame {k}: N = {np.median(order):.5f}, expected {expected:.5f}, least {order.min():.3f}")
            self.assertAlmostEqual(np.median(order), expected, delta=1e-4 * expected)
            # Broken tetrahedra are dark holes in what the rays cross.
            broken = frames.broken[k]
            corners = frames.nodes[frames.tetrahedra[broken]]
            seen = corners[:, :, 2].max(initial=0) > view._grid.z[0]
            self.assertEqual(len(broken), k)
            self.assertEqual(order.min() < 0.5 * expected, k > 0 and seen)

    def test_fringes_can_be_left_out(self):
        write_ensemble(self.folder, 2)
        ensemble = reading.read_ensemble(self.folder)
        with mock.patch.object(growth, "make_series", side_effect=AssertionError("fringes are computed")):
            section = growth.section(ensemble, Options((0,), fringes=False))
        (picture,) = section.pictures
        self.assertEqual([axes.get_images() for axes in picture.figure.axes], [[]] * len(picture.figure.axes))
        drawn = [axes for axes in picture.figure.axes if axes.collections and not axes.get_xlabel().startswith("time")]
        self.assertEqual([axes.get_title() for axes in drawn], ["t = t₀", "t = t₀ + 20 µs", "t = t₀ + 40 µs", "t = t₀ + 60 µs"][:len(drawn)])
        self.assertGreater(len(drawn), 1)
        self.assertEqual(len(section.animations), 1)
        with_fringes = growth.section(ensemble, Options((0,), animation=False)).pictures[0].figure
        self.assertTrue(any(axes.get_images() for axes in with_fringes.axes))
        self.assertLess(picture.figure.get_figheight(), 0.7 * with_fringes.get_figheight())
        result = in_process.report(self.folder, "--no-fringes")
        self.assertEqual(result.returncode, 0, result.stderr)
        page = re.sub(r'="[^"]*base64[^"]*"|data-\w+="[^"]*"', "", (self.folder / "report.html").read_text(encoding="utf-8"))
        self.assertIn("<h2>Crack growth</h2>", page)
        self.assertIsNone(re.search("(?i)fringe|polari|optic|wavelength|below, the cracks", page))

    def test_times_asked_for_are_shown(self):
        write_ensemble(self.folder, 1)
        ensemble = reading.read_ensemble(self.folder)
        frames, crack = ensemble.files.frames(0), ensemble.files.crack(0)
        self.assertEqual(growth._chosen_frames(frames, crack, (0.0, 19e-6, 55e-6, 90e-6)), [0, 1, 3])
        self.assertEqual(growth._chosen_frames(frames, crack, ())[0], 0)


class Plates(Ensembles):
    """A plate that does not begin at y = z = 0, with cracks that may start anywhere."""

    INPUT = """[ensemble]
samples = 2
seed = 7
[specimen]
thickness = "2 mm"
outline = [["5 mm", "-30 mm"], ["25 mm", "-30 mm"], ["22 mm", "10 mm"], ["8 mm", "10 mm"]]
[[specimen.hole]]
center = ["17 mm", "-22 mm"]
radius = "2 mm"
[[specimen.notch]]
from = ["5 mm", "-9 mm"]
to = ["11 mm", "-11 mm"]
height = "1 mm"
[mesh]
base = "shared"
spacing = "2 mm"
notch_spacing = "0.7 mm"
growth = 0.2
[material]
youngs_modulus = "3100 MPa"
poisson_ratio = 0.36
density = "1190 kg/m^3"
[fracture]
strength = "35 MPa"
impulse = "1e-8 MPa^2 s"
[[boundary]]
on = "edge-0"
fix = ["x", "y", "z"]
[[boundary]]
on = "edge-2"
force = ["0 N", "0 N", "1 N"]
rate = ["0 N/s", "0 N/s", "5 N/s"]
[time]
duration = "60 us"
[sections]
y = ["13 mm", "17 mm"]
[output]
frames = 3
"""

    def test_a_box_without_notches_has_a_page(self):
        text = re.sub(r"(?s)thickness = .*?(?=\n\[mesh)", 'size = ["2 mm", "20 mm", "40 mm"]', self.INPUT)
        text = text.replace("samples = 2", "samples = 1").replace("edge-0", "z-min").replace("edge-2", "z-max")
        source = self.folder.with_name("plain.toml")
        source.write_text(text)
        command_lines.crackle(os.environ["CRACKLE"], "run", source, "-o", self.folder).check_returncode()
        self.assertEqual(reading.read_ensemble(self.folder).plate.notch_slot.shape, (0, 2, 2))
        result = self.run_report(str(self.folder))
        self.assertEqual((result.returncode, result.stderr), (0, ""))

    def test_a_plate_is_drawn_where_it_lies(self):
        source = self.folder.with_name("input.toml")
        source.write_text(self.INPUT)
        command_lines.crackle(os.environ["CRACKLE"], "run", source, "-o", self.folder).check_returncode()
        self.assertEqual(self.run_report(str(self.folder), kind="png").returncode, 0)
        page = (self.folder / "report.html").read_text(encoding="utf-8")
        self.assertIn("notch 0 in 2, hole 0 in 0, free surface in 0.", page)
        self.assertIn(">leading where notch 0 leads<", page)
        self.assertNotIn("where hole 0 leads", page)
        ensemble = reading.read_ensemble(self.folder)
        titles = [axes.get_title(loc="left") for axes in crossings.section(ensemble, Options()).pictures[0].figure.axes]
        self.assertEqual(titles, ["leading where notch 0 leads"])
        picture = growth.section(ensemble, Options()).pictures[0]
        fringes = [image for axes in picture.figure.axes for image in axes.get_images()]
        self.assertEqual(len(fringes), 3)
        for image in fringes:
            left, right, low, high = image.get_extent()
            self.assertEqual((left, right), (5, 25))
            self.assertLess(low, -11)
            # Between the slanted edges there is the body, but for the hole; outside there is nothing.
            seen = np.isfinite(np.asarray(image.get_array(), float))
            rows = low + (np.arange(len(seen)) + 0.5) * (high - low) / len(seen)
            width = 20 - 6 * (rows + 30) / 40 - np.where(np.abs(rows + 22) < 2, 2 * np.sqrt(4 - np.minimum((rows + 22) ** 2, 4)), 0)
            away = (rows < -15) | (rows > -5)  # from the slot
            np.testing.assert_allclose(seen.mean(axis=1)[away] * 20, width[away], atol=1)


class Meshes(unittest.TestCase):
    def test_a_cut_covers_the_section(self):
        polygons, numbers = Mesh(*box_mesh((5e-3, 20e-3, 60e-3), (4, 4, 4))).cut(0, 2e-3)
        area = [0.5 * abs(np.sum(p[:, 0] * np.roll(p[:, 1], -1) - p[:, 1] * np.roll(p[:, 0], -1))) for p in polygons]
        self.assertAlmostEqual(sum(area) / (20e-3 * 60e-3), 1, places=12)
        self.assertEqual(len(polygons), len(numbers))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    options, rest = parser.parse_known_args()
    os.environ["CRACKLE"] = os.path.abspath(options.program)
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
