#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The report in a browser without a screen: narrow, wide and in print, with and without WebGL; what its pixels show."""
from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "cli")]

from synthetic_ensemble import write_ensemble  # noqa: E402

NEEDED = ("chromium", "pdftoppm", "pdftotext")
WEBGL = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
PAGE_WIDTH = 1080  # at most, as page.css has it [pixels]
HEIGHT = 7000  # of the part that is looked at [pixels]


def browse(page: Path, *options: str) -> None:
    with tempfile.TemporaryDirectory() as profile:
        done = subprocess.run(["chromium", "--headless", "--no-sandbox", "--disable-dev-shm-usage", "--hide-scrollbars",
                               f"--user-data-dir={profile}", "--virtual-time-budget=8000", *options, page.as_uri()],
                              capture_output=True, text=True, timeout=300, check=False, env={**os.environ, "HOME": profile})
    if done.returncode != 0:
        raise AssertionError(done.stderr)


def is_coloured(image: np.ndarray) -> np.ndarray:
    """Which pixels are neither grey nor nearly so."""
    return np.ptp(image.astype(int), axis=2) > 40


def rows_of_frames(image: np.ndarray) -> list[tuple[int, int]]:
    """First and last row of each frame round a picture in space: lines of its colour on all four sides."""
    line = (np.abs(image.astype(int) - (206, 212, 218)) < 6).all(axis=2)
    margin = (image.shape[1] - min(image.shape[1], PAGE_WIDTH)) // 2 + 40
    rows = np.flatnonzero(line[:, margin:-margin].mean(axis=1) > 0.95)
    return [(int(a), int(b)) for a, b in zip(rows, rows[1:]) if b - a > 150 and (line[a:b].mean(axis=0) > 0.95).sum() == 2]


@unittest.skipUnless(all(map(shutil.which, NEEDED)) and Path("/usr/share/javascript/three/three.min.js").is_file(),
                     "chromium, poppler-utils or libjs-three is not installed")
class Browser(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = Path(temporary.name) / "demo"
        write_ensemble(cls.folder, 4)
        subprocess.run([str(ROOT / "tools" / "crackle-report"), str(cls.folder), "--no-animation"], check=True, capture_output=True)
        cls.page = cls.folder / "report.html"

    def screenshot(self, width: int, *options: str, height: int = HEIGHT) -> np.ndarray:
        file = self.folder / f"{width}.png"
        browse(self.page, *options, f"--window-size={width},{height}", f"--screenshot={file}")
        with Image.open(file) as image:
            self.assertEqual(image.width, width)
            return np.asarray(image.convert("RGB"))

    def test_at_two_widths_nothing_sticks_out_and_the_cracks_are_drawn_in_space(self):
        for width in (400, 1400):
            image = self.screenshot(width, *WEBGL)
            # The page's margin stays white, so that nothing is wider than the page.
            self.assertTrue((image[:, -8:] > 250).all(), f"something sticks out at {width} pixels")
            self.assertGreater(is_coloured(image).sum(), 5000)
            frames = rows_of_frames(image)
            self.assertEqual(len(frames), 2, f"{width}: {frames}")
            for first, last in frames:
                view = image[first + 2:last - 2]
                n_colours = len(np.unique(view[is_coloured(view)] // 16, axis=0))
                print(f"{width} pixels: view of {last - first} rows, {is_coloured(view).sum()} coloured pixels, {n_colours} shades")
                self.assertGreater(is_coloured(view).sum(), 300)
                self.assertGreater(n_colours, 8, "the facets have one colour")
                self.assertGreater((view.max(axis=2) < 120).sum(), 100, "the body's edges are missing")

    def test_wide_tables_take_the_room_that_the_window_has(self):
        image = self.screenshot(1800, "--disable-gpu", height=HEIGHT + 3000)
        head = (image == (0xf4, 0xf6, 0xf8)).all(axis=2)
        self.assertGreater(head[:, :370].sum(), 1000, "no table reaches out of the text's column, 1032 pixels wide")

    def test_without_webgl_the_pictures_stand(self):
        image = self.screenshot(1400, "--disable-gpu", "--disable-3d-apis")
        self.assertEqual(rows_of_frames(image), [])
        self.assertGreater(is_coloured(image).sum(), 5000)

    def test_in_print_the_pictures_stand_and_the_tables_are_whole(self):
        pdf = self.folder / "report.pdf"
        browse(self.page, *WEBGL, f"--print-to-pdf={pdf}")
        text = subprocess.run(["pdftotext", "-layout", str(pdf), "-"], check=True, capture_output=True, text=True).stdout
        self.assertNotIn("Play", text)
        for column in ("leading", "overlap", "traced", "energy"):
            self.assertIn(column, text, "a column is missing")
        subprocess.run(["pdftoppm", "-r", "40", "-png", str(pdf), str(self.folder / "page")], check=True)
        pages = [np.asarray(Image.open(file).convert("RGB")) for file in sorted(self.folder.glob("page-*.png"))]
        self.assertGreater(len(pages), 3)
        self.assertGreater(sum(is_coloured(page).sum() for page in pages), 5000)
        for page in pages:
            self.assertTrue((page[:, -4:] > 250).all(), "something is cut off at the edge of a page")
        self.assertTrue(any(page.shape[1] > page.shape[0] for page in pages), "the wide table is not on a wide page")


if __name__ == "__main__":
    unittest.main(verbosity=2)
