#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of tools/crackle-report on invented ensembles."""
from __future__ import annotations

import base64
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
from matplotlib.text import Text

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "cli")]

from crackle_report import confidence, figures, input_text, reading, style  # noqa: E402
from crackle_report.figures import crack_paths, realizations  # noqa: E402
from crackle_report.mesh import Mesh  # noqa: E402
from crackle_report.plate import Notch, Plate  # noqa: E402
from crackle_report.statistics import make_statistics, wilson_half_width  # noqa: E402
from synthetic_ensemble import write_ensemble  # noqa: E402

REPORT = ROOT / "tools" / "crackle-report"


def overlapping_texts(figure) -> list[str]:
    """Pairs of visible texts whose boxes share more than half a point in both directions."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    boxes = []
    for axes in [figure, *figure.axes]:
        for text in axes.findobj(Text):
            shown = text.get_visible() and text.get_text().strip()
            if shown and not any(text is other for other, _ in boxes):
                boxes.append((text, text.get_window_extent(renderer)))
    # Ticks beyond the limits of an axis are not drawn.
    for axis in itertools.chain.from_iterable((axes.xaxis, axes.yaxis) for axes in figure.axes):
        drawn = {id(label) for tick in axis._update_ticks() for label in (tick.label1, tick.label2)}
        ticks = [*axis.majorTicks, *axis.minorTicks]
        hidden = {id(label) for tick in ticks for label in (tick.label1, tick.label2)} - drawn
        boxes = [(text, box) for text, box in boxes if id(text) not in hidden]
    slack = 0.5 * figure.dpi / 72
    pairs = []
    for (a, box_a), (b, box_b) in itertools.combinations(boxes, 2):
        width = min(box_a.x1, box_b.x1) - max(box_a.x0, box_b.x0)
        height = min(box_a.y1, box_b.y1) - max(box_a.y0, box_b.y0)
        if width > slack and height > slack:
            pairs.append(f"'{a.get_text()}' and '{b.get_text()}'")
    return pairs


class Ensembles(unittest.TestCase):
    """Folders with invented results."""

    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.folder = Path(self._folder.name) / "demo"

    def run_report(self, *arguments: str) -> subprocess.CompletedProcess:
        return subprocess.run([str(REPORT), *arguments], capture_output=True, text=True, check=False,
                              env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})


class Report(Ensembles):
    def test_a_finished_ensemble_gives_a_page_in_one_file(self):
        rows = write_ensemble(self.folder, 6)
        result = self.run_report(str(self.folder))
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stdout, f"report: {self.folder}/report.html\n")

        page = (self.folder / "report.html").read_text(encoding="utf-8")
        addresses = re.findall(r"""(?:src|href)\s*=\s*["']([^"']*)|url\(([^)]*)\)|@import""", page)
        images = [base64.b64decode(source.removeprefix("data:image/png;base64,")) for source, _ in addresses]
        self.assertEqual(len(images), 3)
        for image in images:
            self.assertTrue(image.startswith(b"\x89PNG\r\n"))
        names = sorted(file.name for file in (self.folder / "report").iterdir())
        self.assertEqual(names, ["convergence.png", "convergence.svg", "crack-paths.png", "crack-paths.svg",
                                 "crossings.png", "crossings.svg"])
        self.assertEqual(images[0], (self.folder / "report" / "crack-paths.png").read_bytes())
        for name in names[1::2]:
            xml.etree.ElementTree.parse(self.folder / "report" / name)

        self.assertEqual(re.findall(r">[^<]*\bnan\b[^<]*<", page), [])
        for row in rows:
            self.assertIn(f">{row['onset_force']:.1f}<", page)
        self.assertIn("Open MPI 4.1.4, PETSc 3.18.5", page)
        self.assertIn("[[specimen.notch]]", page)
        self.assertNotIn("not finished", page)

    def test_the_same_results_give_the_same_files(self):
        write_ensemble(self.folder, 4)
        contents = []
        for _ in range(2):
            self.assertEqual(self.run_report(str(self.folder)).returncode, 0)
            files = sorted(self.folder.glob("report*/*")) + [self.folder / "report.html"]
            contents.append([file.read_bytes() for file in files])
        self.assertEqual(*contents)

    def test_a_failed_sample_is_shown_with_its_reason(self):
        write_ensemble(self.folder, 5, failed=(3,))
        with h5py.File(self.folder / "ensemble.h5", "r+") as root:
            root["samples/error"][3] = "quality 0.1 < 0.2 & no way out"
        self.assertEqual(self.run_report(str(self.folder)).returncode, 0)
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
            z = ensemble.samples.z
            self.assertEqual(ensemble.samples.count(1), 11)
            np.testing.assert_allclose(ensemble.statistics.z_mean, np.nanmean(z, axis=0), rtol=1e-14)
            np.testing.assert_allclose(ensemble.statistics.z_std, np.nanstd(z, axis=0, ddof=1), rtol=1e-9)
        (self.folder / "samples" / "0007.h5").unlink()
        self.assertEqual(self.run_report(str(self.folder)).returncode, 0)
        page = (self.folder / "report.html").read_text(encoding="utf-8")
        self.assertIn("10 of 12", page)
        self.assertIn("1 failed, 1 pending", page)
        self.assertIn("not finished", page)

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
        np.testing.assert_allclose(new.statistics.z_mean, np.nanmean(new.samples.z, axis=0), rtol=1e-14)
        self.assertGreater(new.statistics.reached.sum(), old.statistics.reached.sum())

    def test_without_any_crack_or_section_there_is_still_a_page(self):
        write_ensemble(self.folder, 2, failed=(0, 1))
        result = self.run_report(str(self.folder))
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stderr, "")
        page = (self.folder / "report.html").read_text(encoding="utf-8")
        self.assertIn("0 of 2", page)
        self.assertEqual(re.findall(r">[^<]*\bnan\b[^<]*<", page), [])

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
            del root["statistics/z_std"]
        cases = {self.folder: "neither ensemble.h5 nor samples", foreign: "cannot be read",
                 other: "is not a crackle ensemble file", incomplete: "z_std",
                 self.folder / "missing": "is no folder"}
        for folder, message in cases.items():
            with self.subTest(folder.name):
                result = self.run_report(str(folder))
                self.assertEqual(result.returncode, 1)
                self.assertEqual(result.stdout, "")
                self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
                self.assertIn(message, result.stderr)


class Pictures(Ensembles):
    def test_labels_do_not_overlap(self):
        style.apply()
        for n_samples in (1, 2, 6, 20, 31):
            folder = self.folder.with_name(f"of-{n_samples}")
            write_ensemble(folder, n_samples, failed=(1,) if n_samples > 2 else ())
            ensemble = reading.read_ensemble(folder)
            for make_section in figures.SECTIONS:
                for picture in make_section(ensemble).pictures:
                    with self.subTest(f"{n_samples} samples, {picture.name}"):
                        self.assertEqual(overlapping_texts(picture.figure), [])


    def test_many_samples_are_spread_over_sheets(self):
        write_ensemble(self.folder, 5)
        with mock.patch.object(crack_paths, "PANELS_PER_SHEET", 2):
            pictures = crack_paths.section(reading.read_ensemble(self.folder)).pictures
        self.assertEqual([picture.name for picture in pictures],
                         ["crack-paths-0000-0001", "crack-paths-0002-0003", "crack-paths-0004-0004"])


class Numbers(unittest.TestCase):
    def test_students_quantiles_are_those_of_the_tables(self):
        for degrees, expected in ((1, 12.7062), (2, 4.30265), (3, 3.18245), (10, 2.22814), (199, 1.97196)):
            found = confidence.student_quantile(0.95, degrees)
            print(f"t(0.95, {degrees}) = {found:.6f}, tables {expected}")
            self.assertAlmostEqual(found, expected, delta=1e-5 * expected)

    def test_running_values_are_those_of_the_leading_samples(self):
        values = np.array([np.nan, 3.0, 1.0, np.nan, 2.5, 7.0])
        mean, half_width = confidence.running_mean(values), confidence.running_half_width(values, 0.9)
        self.assertTrue(np.isnan(mean[0]) and np.isnan(half_width[1]))
        for i in range(2, len(values)):
            leading = values[:i + 1][~np.isnan(values[:i + 1])]
            t = confidence.student_quantile(0.9, len(leading) - 1)
            self.assertAlmostEqual(mean[i], leading.mean(), places=14)
            self.assertAlmostEqual(half_width[i], t * leading.std(ddof=1) / np.sqrt(len(leading)), places=13)

    def test_wilsons_interval(self):
        # 8 of 20 at 95 %: 0.2188 to 0.6134.
        self.assertAlmostEqual(wilson_half_width(0.4, 20, 0.95), (0.6134 - 0.2188) / 2, delta=1e-4)
        self.assertGreater(wilson_half_width(0.0, 20, 0.95), 0.05)

    def test_lengths_are_read_with_their_units(self):
        for text, metres in (("24.5 mm", 24.5e-3), ("2.45 cm", 24.5e-3), ("5e3 um", 5e-3), ("1 inch", 0.0254),
                             ("0.14 m", 0.14), ("140 millimeters", 0.14), ("7mm", 7e-3), (".5 µm", 5e-7)):
            self.assertAlmostEqual(input_text.length(text), metres, delta=1e-12 * metres)
        for text in ("5 s", "mm", "5", "5 mm^2", "5 qm"):
            with self.assertRaises(ValueError, msg=text):
                input_text.length(text)

    def test_the_outline_encloses_the_plate_without_its_slots(self):
        plate = Plate((5e-3, 24.5e-3, 140e-3), (
            Notch("y-min", 65e-3, 6e-3, 0.6e-3), Notch("y-max", 75e-3, 5e-3, 0.5e-3),
            Notch("y-min", 30e-3, 2e-3, 0.4e-3), Notch("z-max", 10e-3, 3e-3, 0.7e-3),
            Notch("z-min", 12e-3, 4e-3, 0.8e-3)))
        y, z = plate.outline().T
        area = 0.5 * np.sum(y * np.roll(z, -1) - np.roll(y, -1) * z)
        expected = 24.5e-3 * 140e-3 - sum(n.depth * n.height for n in plate.notches)
        print(f"area {area:.9e} m^2, exact {expected:.9e} m^2")
        self.assertAlmostEqual(area, expected, delta=1e-12 * expected)
        self.assertEqual(plate.tip(1), (24.5e-3 - 5e-3, 75e-3))

    def test_statistics_leave_out_what_failed(self):
        with tempfile.TemporaryDirectory() as folder:
            write_ensemble(Path(folder), 9, failed=(2, 5))
            samples = reading.read_ensemble(Path(folder)).samples
        expected = np.isfinite(samples.z).sum(axis=0)
        samples.z[[2, 5]] = 0.07
        statistics = make_statistics(samples, 0.95)
        np.testing.assert_array_equal(statistics.reached, expected)
        self.assertAlmostEqual(statistics.pattern_share.sum(), 1.0, places=14)
        self.assertEqual(statistics.running_mean.shape, samples.z.shape)


def block(n: int, size: tuple[float, float, float]) -> Mesh:
    """A box of n x n x n cuboids, cut into six tetrahedra each."""
    number = np.arange((n + 1) ** 3).reshape(n + 1, n + 1, n + 1)
    nodes = np.stack(np.meshgrid(*[np.arange(n + 1)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) * np.array(size) / n
    tetrahedra = []
    for axes in itertools.permutations(range(3)):
        odd = axes in ((0, 2, 1), (1, 0, 2), (2, 1, 0))
        for start in itertools.product(range(n), repeat=3):
            corner, path = list(start), [number[start]]
            for axis in axes:
                corner[axis] += 1
                path.append(number[tuple(corner)])
            tetrahedra.append([path[0], path[2], path[1], path[3]] if odd else path)
    return Mesh(nodes, np.array(tetrahedra), np.linspace(0.2, 1, len(tetrahedra)))


class Realizations(unittest.TestCase):
    plate = Plate((5e-3, 20e-3, 60e-3), (Notch("y-min", 28e-3, 5e-3, 1e-3), Notch("y-max", 33e-3, 5e-3, 1e-3)))

    def test_a_cut_covers_the_section(self):
        polygons, numbers = block(4, self.plate.size).cut(0, 2e-3)
        area = [0.5 * abs(np.sum(p[:, 0] * np.roll(p[:, 1], -1) - p[:, 1] * np.roll(p[:, 0], -1))) for p in polygons]
        self.assertAlmostEqual(sum(area) / (20e-3 * 60e-3), 1, places=12)
        self.assertEqual(len(polygons), len(numbers))

    def test_bias_of_known_facets(self):
        # The dual facets of the regular tetrahedron have its edges as normals; as in test_geometry_bias.cpp.
        regular = Mesh(np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1.0]]), np.array([[0, 2, 1, 3]]),
                       np.ones(1))
        expected = np.sqrt((3 * (1 / 6 - 1 / 5) ** 2 + 18 * (1 / 12 - 1 / 15) ** 2) / (3 / 25 + 18 / 225))
        facets = regular.dual_facets().reshape(-1, 3)
        self.assertAlmostEqual(realizations.fourth_order_bias(facets), expected, places=12)
        # Facets that point everywhere alike have none.
        facets = np.random.Generator(np.random.PCG64(1)).normal(size=(200_000, 3))
        self.assertLess(realizations.fourth_order_bias(facets), 0.01)

    def test_pictures_have_no_overlapping_texts(self):
        mesh = block(6, self.plate.size)
        facets = np.random.Generator(np.random.PCG64(1)).normal(size=(20_000, 3))
        style.apply()
        for picture in (realizations.base_points(self.plate, mesh.nodes), realizations.cut(self.plate, mesh, 0),
                        realizations.orientations({"cubic lattice": facets, "body-centred lattice": facets,
                                                   "blue noise of crackle": facets}, 0.2)):
            self.assertEqual(overlapping_texts(picture.figure), [], picture.name)


if __name__ == "__main__":
    unittest.main(verbosity=2)
