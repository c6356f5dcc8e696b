#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The report and the package's pictures of bodies unlike the paper's plate: slender, of micrometres, without notches."""
from __future__ import annotations

import argparse
import atexit
import functools
import os
import re
import shutil
import sys
import tempfile
import unittest
import warnings
from pathlib import Path

import h5py
import matplotlib
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "cli")]
matplotlib.use("Agg")

import crackle  # noqa: E402
import in_process  # noqa: E402
import small_input  # noqa: E402
from effort import repetitions  # noqa: E402
from crackle import units  # noqa: E402
from crackle_report import figures, reading, style  # noqa: E402
from crackle_report.options import Options  # noqa: E402
from test_report import overlapping_texts  # noqa: E402

PROGRAM = Path()
SCALE = 2.0**-10  # of the tiny body's lengths, so that its files have the numbers of the usual one times powers of two


def scaled(text: str) -> str:
    """The input of a body SCALE times as long: the same stresses, at SCALE^2 of the forces and SCALE of the times."""
    powers = {"mm": 1, "N": 2, "N/s": 2, "us": 1, "MPa^2 s": 1}

    def number(match: re.Match) -> str:
        return f'"{float(match[1]) * SCALE ** powers[match[2]]!r} {match[2]}"'

    return re.sub(r'"([\d.e-]+) (mm|N/s|N|us|MPa\^2 s)"', number, text)


def text_of(page: Path) -> str:
    """What a page shows, without its pictures."""
    text = re.sub(r'(?s)<script>.*?</script>|<style>.*?</style>|="[^"]*base64[^"]*"|data-\w+="[^"]*"', "", page.read_text(encoding="utf-8"))
    return text.partition("<h2>Input</h2>")[0]


def columns_of(page: str) -> dict[str, list[str]]:
    """Cells of the samples' table by the heads' titles and units."""
    table = page.partition("<h2>Samples</h2>")[2].partition("</table>")[0]
    heads = [f"{title} [{unit}]" for title, unit in re.findall(r"<th[^>]*>(.*?)<small>(.*?)</small>", table)]
    rows = [re.findall(r"<td[^>]*>(.*?)</td>", row) for row in re.findall(r"<tr class.*?</tr>", table)]
    return {head: [row[k] for row in rows] for k, head in enumerate(heads)}


@functools.cache
def made() -> tuple[dict[str, Path], dict[str, str]]:
    """Folders of the bodies' ensembles, and the texts of their reports."""
    top = Path(tempfile.mkdtemp())
    atexit.register(shutil.rmtree, top)
    # The cracks of its two notches lie far apart.
    notches = "".join(small_input.NOTCH.replace("15 mm", at).replace("3 mm", "1 mm") for at in ("6 mm", "54 mm"))
    slender = small_input.small_input(samples=9, notch=notches).replace('["2 mm", "12 mm", "30 mm"]', '["2 mm", "3 mm", "60 mm"]').replace(
        'y = ["5 mm", "8 mm"]', 'y = ["1.5 mm", "2.5 mm"]')
    usual = small_input.small_input().replace('spacing = "2 mm"', 'spacing = "1 mm"')  # fine enough for a crack speed
    inputs = {"usual": usual, "tiny": scaled(usual), "slender": slender,
              "smooth": small_input.small_input(notch="")}
    folders = {name: small_input.run(PROGRAM, text, top / name) for name, text in inputs.items()}
    pages = {}
    for name in ("usual", "tiny", "smooth"):
        done = in_process.report(folders[name], "--no-animation", "--no-fringes", kind="svg")
        assert done.returncode == 0, done.stderr
        pages[name] = text_of(folders[name] / "report.html")
    return folders, pages


class Bodies(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folders, cls.pages = made()
        style.apply()


class Slender(Bodies):
    def test_labels_do_not_overlap_and_pictures_have_a_page(self):
        ensemble = reading.read_ensemble(self.folders["slender"])
        seen, samples = set(), repetitions((0,), (0, 1))
        for make_section in figures.SECTIONS:
            section = make_section(ensemble, Options(samples))
            for picture in section.pictures if section else ():
                seen.add(picture.name)
                with self.subTest(picture.name):
                    self.assertEqual(overlapping_texts(picture.figure), [])
                    self.assertLess(picture.figure.get_figheight(), 16)
        self.assertLessEqual({"typical-paths", "crack-paths", "crossings", *(f"growth-{i:04d}" for i in samples)}, seen)

    def test_few_large_panels_name_number_and_pattern_apart(self):
        ensemble = reading.read_ensemble(self.folders["slender"])
        figure = figures.crack_paths._section(ensemble, "", "", [[0, 1, 2]]).pictures[0].figure
        self.assertEqual(overlapping_texts(figure), [])
        texts = [text.get_text() for axes in figure.axes for text in axes.texts]
        self.assertTrue(any("crack" in text or text == "other" for text in texts), texts)


class Units(Bodies):
    def test_the_table_has_units_in_which_its_numbers_can_be_read(self):
        shown = {name: columns_of(page) for name, page in self.pages.items()}
        self.assertLessEqual({"onset force [N]", "peak load [N]", "displacement at peak [mm]", "work of fracture [mJ]", "rough crack area [mm^2]"},
                             shown["usual"].keys())
        tiny = shown["tiny"]
        samples = crackle.open(self.folders["tiny"]).samples
        for name, title, size in (("onset_force", "onset force [µN]", 1e-6), ("peak_load", "peak load [µN]", 1e-6),
                                  ("displacement_at_peak", "displacement at peak [nm]", 1e-9), ("work_of_fracture", "work of fracture [pJ]", 1e-12),
                                  ("crack_area", "rough crack area [µm^2]", 1e-12)):
            with self.subTest(title):
                self.assertIn(title, tiny)
                np.testing.assert_allclose(np.array(tiny[title], float) * size, samples[name], atol=0.6e-3 * size)
                self.assertGreater(float(tiny[title][0]), 0.9)
        # As in the usual one, but for the unit.
        np.testing.assert_allclose(np.array(tiny["peak load [µN]"], float) * 1e-6, np.array(shown["usual"]["peak load [N]"], float) * SCALE**2,
                                   rtol=0.02)

    def test_the_page_and_its_pictures_use_them_throughout(self):
        for name, wanted, unwanted in (("usual", ("mm", "N", "µs", "mJ"), ("µm", "nm", "µN", "ns")),
                                       ("tiny", ("µm", "µN", "ns", "nm"), ("mm", "N", "µs", "mJ"))):
            drawn = " ".join(file.read_text(encoding="utf-8") for file in sorted((self.folders[name] / "report").glob("*.svg")))
            labels = set(re.findall(r">[^<>]*\[([^\]<>]+)\]<", drawn))
            with self.subTest(name):
                self.assertLessEqual(set(wanted), labels)
                self.assertFalse(set(unwanted) & labels, labels)
        tiny = self.pages["tiny"]
        self.assertRegex(tiny, r"<b>[\d.]+ µN</b><span>median onset force \([\d.]+ to [\d.]+ µN\)")
        self.assertRegex(tiny, r"mean position<small>µm</small>")
        self.assertIn("y = 4.883 µm", tiny)
        self.assertIsNone(re.search(r"\d ?(mm|N)\b", tiny))
        self.assertRegex(self.pages["usual"], r"<b>\d+ N</b>")
        self.assertIn("y = 5 mm", self.pages["usual"])

    def test_the_package_draws_in_them(self):
        usual, tiny = (crackle.open(self.folders[name]) for name in ("usual", "tiny"))
        labels = [[(axes.get_xlabel(), axes.get_ylabel()) for axes in (
            plot.load([1]), plot.crack_length([1]), plot.tip_speed([1]), plot.cracks([1]), plot.histogram("peak_load"),
            plot.histogram("crack_area"))] for plot in (usual.plot, tiny.plot)]
        self.assertEqual(labels[0], [("displacement [mm]", "load [N]"), ("time since onset [µs]", "crack length [mm]"),
                                     ("time since onset [µs]", "tip speed [m/s]"), ("y [mm]", "z [mm]"), ("peak load [N]", "samples"),
                                     ("crack area [mm^2]", "samples")])
        self.assertEqual(labels[1], [("displacement [nm]", "load [µN]"), ("time since onset [ns]", "crack length [µm]"),
                                     ("time since onset [ns]", "tip speed [m/s]"), ("y [µm]", "z [µm]"), ("peak load [µN]", "samples"),
                                     ("crack area [µm^2]", "samples")])
        line = tiny.plot.load([1]).lines[0]
        np.testing.assert_allclose(line.get_ydata() * 1e-6, tiny[1].history.governing_load)
        np.testing.assert_allclose(line.get_xdata() * 1e-9, tiny[1].history.governing_displacement)
        # On axes that have a unit all curves are in that one.
        axes = usual.plot.load([1])
        tiny.plot.load([1], axes=axes)
        self.assertEqual(axes.get_ylabel(), "load [N]")
        np.testing.assert_allclose(axes.lines[1].get_ydata(), tiny[1].history.governing_load)

    def test_a_unit_fits_the_largest_value(self):
        cases = (([0.2, -70], units.NEWTON, "N"), ([9.99e4], units.NEWTON, "N"), ([2e5], units.NEWTON, "kN"), ([3e-6, np.nan], units.NEWTON, "µN"),
                 ([0.0], units.NEWTON, "N"), ([], units.MM, "mm"), ([39e-6], units.MM, "µm"), ([200.0], units.MM, "m"), ([5e4], units.MM, "m"),
                 ([4e-8], units.US, "ns"), ([0.5], units.US, "ms"), ([1e4], units.US, "s"), ([1e-11], units.MM2, "µm^2"),
                 ([1e-30], units.NEWTON, "pN"), ([5.0], units.Unit("m/s", 1), "m/s"), ([1e9], units.Unit("", 1), ""))
        for values, usual, name in cases:
            fit = units.fitting(values, usual)
            self.assertEqual(fit.name, name, (values, usual))
            self.assertEqual(fit, units.named(name) or fit)
        self.assertEqual(units.named("us"), units.US)
        self.assertEqual(units.of_label("time since onset [µs]"), units.US)
        self.assertIsNone(units.of_label("samples"))


class Smooth(Bodies):
    """A body without notches."""

    def test_the_report_says_where_it_broke(self):
        ensemble = reading.read_ensemble(self.folders["smooth"])
        first = {}
        for number in range(3):
            with h5py.File(self.folders["smooth"] / "samples" / f"{number:04d}.h5") as root:
                order = sorted(zip(root["breaks/load_time"], root["breaks/phase_time"], root["breaks/tetrahedron"]))
                first[number] = root["mesh/nodes"][...][root["mesh/tetrahedra"][order[0][2]]].mean(axis=0), order[0][0]
                surface, crack = root["crack_surface"], int(np.argmax(root["crack_surface/cracks/area"]))
                corners = surface["corners"][...][surface["crack"][...] == crack]
            place = ensemble.places[number]
            np.testing.assert_allclose(place.first, first[number][0])
            self.assertAlmostEqual(place.first_time, float(ensemble.samples.first_break_time[number]), places=6)
            self.assertTrue((place.largest > corners.min(axis=(0, 1))).all() and (place.largest < corners.max(axis=(0, 1))).all())
            self.assertAlmostEqual(place.largest_start, float(ensemble.files.crack(number).time[surface_of(ensemble, number) == crack].min()))
        page = self.pages["smooth"]
        z = [1e3 * place[2] for place, _ in first.values()]
        self.assertIn("<h2>Where it broke</h2>", page)
        self.assertIn(f"z = {np.median(z):.2f} mm ({min(z):.2f} to {max(z):.2f})", page)
        for place, time in first.values():
            self.assertIn("".join(f"<td>{1e3 * value:.2f}</td>" for value in place) + f"<td>{format(time, ensemble.samples.result('first_break_time').format)}</td>", page)
        drawn = figures.places.section(ensemble, Options()).pictures[0].figure.axes[0].lines
        np.testing.assert_allclose(sorted(drawn[-1].get_ydata()), sorted(z))

    def test_nothing_is_said_of_cracks_from_notches(self):
        page = self.pages["smooth"]
        for word in ("other", "crack speed", "speed of a tip", "Patterns", "leading", "Rayleigh", "one main crack"):
            self.assertIsNone(re.search(rf">[^<]*\b{word}\b[^<]*<", page.replace("shows other samples", "")), word)
        self.assertIn("crack speed", self.pages["usual"])
        self.assertIn("speed of a tip", self.pages["usual"])
        self.assertNotIn("Where it broke", self.pages["usual"])
        self.assertFalse((self.folders["smooth"] / "report" / "crack-speed.png").is_file())

    def test_no_warnings(self):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            ensemble = reading.read_ensemble(self.folders["smooth"])
            for make_section in figures.SECTIONS:
                make_section(ensemble, Options(animation=False, fringes=False))


def surface_of(ensemble, number: int) -> np.ndarray:
    with h5py.File(ensemble.files.files[number]) as root:
        return root["crack_surface/crack"][...]


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=Path, required=True)
    options, rest = parser.parse_known_args()
    PROGRAM = options.program.resolve()
    os.environ["CRACKLE"] = str(PROGRAM)
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
