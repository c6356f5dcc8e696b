#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Experiments in the report and in Python: a sample held out as if it had been photographed, and loads."""
from __future__ import annotations

import argparse
import html
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
sys.path[:0] = [str(ROOT / "tools"), str(Path(__file__).parent)]

import crackle  # noqa: E402
import in_process  # noqa: E402
from crackle import matching, weibull  # noqa: E402
from crackle.inference import Censored  # noqa: E402
from crackle_report import photographs  # noqa: E402
from crackle_report.figures import experiments, loads, posterior  # noqa: E402
from crackle_report.options import Options  # noqa: E402
from crackle_report.photoelasticity import Grid, Optics  # noqa: E402
from crackle_report.reading import read_ensemble  # noqa: E402
from crackle_report.sample_files import SampleFiles  # noqa: E402
from small_input import run, small_input  # noqa: E402
from test_report import overlapping_texts  # noqa: E402

PROGRAM = Path()
N = 8
HELD_OUT = 0  # the first sample whose crack has several points
SCALE = 0.13e-3  # of a pixel [m]
ORIGIN = (1e-3, 14e-3)  # of the experiment's axes in the body [m]
OTHER_ARM = ((8e-3, 15e-3), (12e-3, 18e-3))  # of the path, not compared [m]


def photograph(frames, k: int, file: Path, light_field: bool, is_reversed: bool, random: np.random.Generator) -> str:
    """Takes a picture, with noise and a brightness of its own, of a part of a sample; returns its table for an experiments file."""
    grid = Grid.over((2e-3, 12.5e-3), (8e-3, 22e-3), SCALE)
    fringes = photographs.fringes_at(frames, [k], grid, Optics())[0]
    image = 0.35 + 0.3 * np.nan_to_num(fringes.intensity(light_field, reverse=is_reversed)) + random.normal(0, 0.04, grid.shape)
    Image.fromarray(np.uint8(255 * image.clip(0, 1))[::-1]).save(file)
    return (f'[[experiment.picture]]\nfile = "{file.name}"\ntime = "{frames.time[k]} s"\nscale = "{1e3 * grid.pixel} mm"\n'
            f'origin = [{(ORIGIN[0] - 2e-3) / (grid.y[1] - grid.y[0])}, {(22e-3 - ORIGIN[1]) / grid.pixel}]\n'
            f'field = "{"light" if light_field else "dark"}"\nreversed = {str(is_reversed).lower()}\n')


class Experiments(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = Path(cls.temporary.name)
        cls.out = run(PROGRAM, small_input(samples=N).replace('base = "shared"', 'base = "own"'), cls.folder / "out")
        global HELD_OUT
        files = SampleFiles(cls.out)
        HELD_OUT = next(sample for sample in range(N) if len(files.lines(sample)[0].points) >= 3)
        frames, line = files.frames(HELD_OUT), files.lines(HELD_OUT)[0].points
        arms = ["".join(f"{1e3 * (y - ORIGIN[0])},{1e3 * (z - ORIGIN[1])}\n" for y, z in arm) for arm in (line, OTHER_ARM)]
        (cls.folder / "path.csv").write_text("y_mm,z_mm\n" + "\n".join(arms))
        random = np.random.default_rng(1)
        pictures = [photograph(frames, k, cls.folder / f"{k}.png", k == 1, k == 2, random) for k in (0, 1, 2)]
        cls.file = cls.folder / "experiments.toml"
        cls.file.write_text(f'[[experiment]]\nname = "held out"\npath = "path.csv"\norigin = ["{ORIGIN[0]} m", "{ORIGIN[1]} m"]\n'
                                   + "".join(pictures))
        (cls.folder / "strengths.csv").write_text("peak_load_N\n" + "".join(f"{load}\n" for load in (95, 103.5, 88, 110, 99)))
        (cls.folder / "loads.toml").write_text('loads = "strengths.csv"\n')

    def test_pictures_find_the_sample_that_was_photographed(self):
        document, told = matching.match(self.out, self.file, PROGRAM).document, []
        ensemble = read_ensemble(self.out, PROGRAM)
        photographs.add_pictures(document, ensemble, progress=told.append)
        experiment = document["experiments"][0]
        found = experiment["by"]["pictures"]
        nearest = found["nearest"]
        self.assertEqual(nearest[0]["sample"], HELD_OUT)
        self.assertLess(2 * nearest[0]["distance"], nearest[1]["distance"])
        used = len(document["samples"]["loads"])
        self.assertEqual((found["n_samples"], found["least_p_value"]), (used, 1 / (used + 1)))
        self.assertEqual(told[-1], f"fringes of {used} of {used} samples")
        self.assertAlmostEqual(found["p_value"] * (used + 1) % 1, 0)
        section = experiments.section(ensemble, Options(match=document))
        self.assertEqual(len(section.pictures), 3)
        for picture in section.pictures:
            self.assertEqual(overlapping_texts(picture.figure), [], picture.name)
        body = section.pictures[0].figure.axes[0]
        self.assertEqual([text.get_text() for text in body.get_legend().get_texts()], ["other arms"])
        np.testing.assert_allclose(body.get_legend_handles_labels()[0][0].get_xydata(), 1e3 * np.array(OTHER_ARM))
        self.assertNotIn("later than the last frame", " ".join(document["warnings"]))
        late = {**document, "warnings": [], "experiments": [{**experiment, "by": {}, "observed": {"pictures": [
            {**picture, "time": time} for picture, time in zip(experiment["observed"]["pictures"], (1e-6, 30e-6, 120e-6))]}}]}
        photographs.add_pictures(late, ensemble)
        self.assertEqual(late["warnings"], [f"the photograph of held out at {time} us is later than the last frame of {used} of {used} samples: it is compared "
                                            "with that frame" for time in ("30", "120")])
        # Wrong by 2 mm in its place, or of the other field, a picture is not that of the sample.
        for change in ({"corner": np.array(experiment["observed"]["pictures"][0]["corner"]) + 2e-3}, {"light_field": True}):
            one = {**experiment, "observed": {"pictures": [{**experiment["observed"]["pictures"][0], **change}]}, "by": {}}
            photographs.add_pictures({**document, "experiments": [one]}, ensemble)
            distances = {each["sample"]: each["distance"] for each in one["by"]["pictures"]["nearest"]}
            self.assertGreater(distances.get(HELD_OUT, 1), 3 * nearest[0]["distance"], change)

    def test_report(self):
        def report(of: str = "experiments.toml", kind: str | None = None) -> subprocess.CompletedProcess:
            return in_process.report(self.out, "--program", PROGRAM, "--no-animation", "--experiments", self.folder / of, kind=kind,
                                     sections=(experiments.section,))

        done = report(kind="png")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        names = {file.stem for file in (self.out / "report").glob("experiment*.png")}
        self.assertEqual(names, {"experiment-0-path", f"experiment-0-growth-{HELD_OUT:04d}", "experiment-0-overlay"})
        page = (self.out / "report.html").read_text()
        self.assertTrue("<td>pictures</td>" in page)
        self.assertTrue("no random inputs" in page)
        kept, = (self.out / "report").glob("fringes-*.npz")
        before = kept.stat().st_mtime_ns
        self.assertEqual(report(of="loads.toml").returncode, 0)
        page = (self.out / "report.html").read_text()
        self.assertTrue("together by" in page)
        self.assertTrue("By peak load: " in page)
        self.assertTrue((self.out / "report" / "experiments-peak-load.png").is_file())
        # Fringes are made once.
        document = matching.match(self.out, self.file, PROGRAM).document
        photographs.add_pictures(document, read_ensemble(self.out, PROGRAM), progress=self.fail)
        self.assertEqual(document["experiments"][0]["by"]["pictures"]["nearest"][0]["sample"], HELD_OUT)
        self.assertEqual(kept.stat().st_mtime_ns, before)
        # A photograph that cannot be read is left out, and named.
        picture = self.folder / "1.png"
        whole = picture.read_bytes()
        self.addCleanup(picture.write_bytes, whole)
        picture.write_bytes(whole[:len(whole) // 2])
        done = report()
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        page = html.unescape((self.out / "report.html").read_text())
        self.assertIn(f"Left out of the pictures: cannot read '{picture}'", page)
        self.assertTrue("<td>pictures</td>" in page)
        shutil.rmtree(self.out / "report")
        missing = report(of="none.toml")
        self.assertEqual(missing.returncode, 1)
        self.assertRegex(missing.stderr, r"^crackle-report: .*none.toml.*there is no such file")

    def test_tables_in_python(self):
        ensemble = crackle.open(self.out)
        found = ensemble.match(self.file, program=PROGRAM)
        self.assertEqual(list(found.experiments.index), [("held out", "path")])
        self.assertEqual(found.experiments.loc[("held out", "path"), "nearest"][0], HELD_OUT)
        self.assertIsNone(found.together)
        self.assertTrue(found.ways["taken"].any())
        measured = [line for line in found.plot_path("held out").lines if line.get_label() == "held out"]
        np.testing.assert_allclose(measured[0].get_xydata(), 1e3 * np.array(found.document["experiments"][0]["observed"]["lines"][0]))
        found = ensemble.match(self.file, pictures=True, program=PROGRAM)
        self.assertEqual(found.experiments.loc[("held out", "pictures"), "nearest"][0], HELD_OUT)
        loads = ensemble.match(self.folder / "loads.toml", program=PROGRAM)
        self.assertEqual(len(loads.experiments), 5)
        self.assertEqual(loads.together.loc["peak_load", "n_experiments"], 5)
        with self.assertRaisesRegex(crackle.ResultsError, "there is no such file"):
            ensemble.match("none.toml", program=PROGRAM)
        with self.assertRaises(crackle.ResultsError):
            ensemble.calibrate(self.file, program=PROGRAM)

    def test_posterior(self):
        """Drawn from a made-up document of crackle calibrate."""
        def spread(mean: float, deviation: float) -> dict:
            return {"mean": mean, "standard_deviation": deviation, "lower": mean - 1.64 * deviation, "upper": mean + 1.64 * deviation}

        random = np.random.default_rng(3)
        values = np.stack([random.normal(3.2e9, 1e8, 200), random.normal(0.36, 0.01, 200)], axis=1)
        found = {"inputs": [{"key": "material.youngs_modulus", "unit": "Pa", "prior": spread(3.3e9, 4e8), "posterior": spread(3.2e9, 1e8)},
                            {"key": "material.poisson_ratio", "unit": "", "prior": spread(0.35, 0.05), "posterior": spread(0.36, 0.01)}],
                 "draws": {"values": values.tolist(), "weights": [1] * 200}}
        picture, = posterior.pictures(found, [{"key": "material.youngs_modulus", "values": random.normal(3.3e9, 4e8, 50).tolist()}])
        self.assertEqual([axes.get_xlabel() for axes in picture.figure.axes], ["material.youngs_modulus", "material.poisson_ratio"])
        self.assertEqual(overlapping_texts(picture.figure), [])
        self.assertEqual(posterior.pictures(None, []), [])


class Weibull(unittest.TestCase):
    def test_factors_of_astm_c1239(self):
        """Factors against bias and ends of 90 % intervals, of the most likely modulus: ASTM C1239, Thoman, Bain and Antle (1969)."""
        random = np.random.default_rng(7)
        for n, unbiasing, lower, upper in ((5, 0.700, 2.779, 0.683), (10, 0.859, 1.807, 0.742), (20, 0.931, 1.449, 0.791), (30, 0.953, 1.334, 0.820)):
            values = 100 * random.weibull(10, n)
            found = weibull.fit(values, np.array([1 - np.exp(-1)]), 0.9)
            likely = self.most_likely(values)
            self.assertAlmostEqual(found.modulus / likely, unbiasing, delta=0.01)
            self.assertAlmostEqual(likely / found.lower, lower, delta=0.03 * lower)
            self.assertAlmostEqual(likely / found.upper, upper, delta=0.02)
            self.assertAlmostEqual(found.quantile[0], found.scale, places=6)
            self.assertLess(found.quantile_lower[0], found.scale)
            self.assertGreater(found.quantile_upper[0], found.scale)

    @staticmethod
    def most_likely(values: np.ndarray) -> float:
        """The modulus, by halving."""
        low, high = 0.1, 1000.0
        logarithm = np.log(values / values.max())
        while high - low > 1e-9 * high:
            middle = (low + high) / 2
            weight = np.exp(middle * logarithm)
            below = (weight * logarithm).sum() / weight.sum() - logarithm.mean() < 1 / middle
            low, high = (middle, high) if below else (low, middle)
        return low

    def test_the_picture_says_of_which_load_the_modulus_is(self):
        """Here 8 of the onset, 18 of the peak load."""
        onset, peak = (np.random.default_rng(1).weibull(modulus, 400) for modulus in (8, 18))
        each = [{"onset_load": a, "peak_load": b} for a, b in zip(onset, peak)]
        found = {"samples": {"loads": each[:200]}, "experiments": [{"observed": one} for one in each[200:]]}
        for picture, what, modulus in zip(loads.pictures(found), ("onset load", "peak load"), (8, 18), strict=True):
            legend = picture.figure.axes[1].get_legend()
            self.assertEqual(legend.get_title().get_text(), f"Weibull's modulus of the {what}")
            for text, whose in zip(legend.get_texts(), ("samples", "experiments"), strict=True):
                self.assertRegex(text.get_text(), rf"^{whose}: [\d.]+ \([\d.]+ to [\d.]+\)$")
                self.assertAlmostEqual(float(text.get_text().split()[1]), modulus, delta=0.15 * modulus)
            self.assertEqual(overlapping_texts(picture.figure), [])

    def test_what_did_not_break_counts_in_the_picture(self):
        """As bounds: 40 values, and the same values of which the greater 16 are censored."""
        strengths = np.sort(100 * np.random.default_rng(4).weibull(8, 40))
        limit = strengths[24]
        each = [{"onset_load": None, "peak_load": min(one, limit), "is_unbroken": bool(one >= limit)} for one in strengths]
        found = {"samples": {"loads": each}, "experiments": [{"observed": {"onset_load": None, "peak_load": one}} for one in strengths]}
        picture, = loads.pictures(found)
        empirical, straight = picture.figure.axes
        censored, whole = (line.get_xydata() for line in straight.lines if line.get_marker() == "o")
        np.testing.assert_allclose(censored, whole[:24])
        fit = weibull.document(np.minimum(strengths, limit), strengths < limit)["modulus"]
        texts = [text.get_text() for text in straight.get_legend().get_texts()]
        self.assertEqual(texts[0], f"samples: {fit['value']:.3g} ({fit['lower']:.3g} to {fit['upper']:.3g})")
        self.assertEqual(texts[1].split()[1], f"{weibull.document(strengths, strengths > 0)['modulus']['value']:.3g}")
        self.assertEqual([text.get_text() for text in empirical.get_legend().get_texts()], ["40 samples, 16 bore more", "40 experiments"])
        self.assertAlmostEqual(empirical.lines[0].get_ydata()[-1], 24 / 40)
        self.assertEqual(overlapping_texts(picture.figure), [])
        # A bound among the values: two of the three above it share its place.
        mixed = Censored(np.array([1.0, 2, 3, 4]), np.array([False, True, False, False]), np.arange(4))
        np.testing.assert_allclose(mixed.shares_below, [[0, 1 / 4, 5 / 8], [1 / 4, 5 / 8, 1]])

    def test_where_there_is_no_fit(self):
        for values in ([1.0, 2.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 2.0]):
            self.assertIsNone(weibull.fit(np.array(values), np.array([0.5])))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=Path, required=True)
    known, rest = parser.parse_known_args()
    PROGRAM = known.program.resolve()
    unittest.main(argv=[sys.argv[0], *rest])
