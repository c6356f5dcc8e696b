#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Mother points from a file: errors with line numbers, and an ensemble that holds on to its points."""
import argparse
import pathlib
import shutil
import sys
import tempfile
import unittest

import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))

import command_lines  # noqa: E402
import in_process  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
OPTIONS = None
SIZE = (3, 8, 16)
INPUT = """
[ensemble]
samples = 2
seed = 1
[specimen]
size = ["3 mm", "8 mm", "16 mm"]
[mesh]
spacing = "1.5 mm"
perturbation = 0.1
[material]
youngs_modulus = "3300 MPa"
poisson_ratio = 0.38
density = "1180 kg/m^3"
[fracture]
strength = "35 MPa"
impulse = "1e-8 MPa^2 s"
[[boundary]]
on = "z-min"
fix = ["x", "y", "z"]
[[boundary]]
on = "z-max"
force = ["0 N", "0 N", "100 N"]
rate = ["0 N/s", "0 N/s", "5 N/s"]
[time]
duration = "2 us"
[sections]
y = ["4 mm"]
[output]
frames = 0
"""
CORNERS = [f"{x} {y} {z}" for x in (0, 3) for y in (0, 8) for z in (0, 16)]


def invoke(*arguments):
    return command_lines.crackle(OPTIONS.program, *arguments)


class Points(unittest.TestCase):
    def setUp(self):
        self.parent = tempfile.TemporaryDirectory(prefix="crackle-points-")
        self.folder = pathlib.Path(self.parent.name)
        self.plate, self.cloud, self.out = (self.folder / name for name in ("plate.toml", "cloud.txt", "out"))
        self.plate.write_text(INPUT.replace("[mesh]", '[mesh]\npoints = "cloud.txt"'))

    def tearDown(self):
        self.parent.cleanup()

    def write_generated_points(self):
        """The base points that the program itself makes for this body."""
        base, mesh = self.folder / "base.toml", self.folder / "base.vtkhdf"
        base.write_text(INPUT.replace("perturbation = 0.1", "perturbation = 0"))
        result = invoke("mesh", base, "-o", mesh)
        self.assertEqual(result.returncode, 0, result.stderr)
        with h5py.File(mesh) as root:
            np.savetxt(self.cloud, root["VTKHDF/Points"][...] * 1e3, fmt="%.17g")

    def assert_refused(self, *expected, commands=("check", "run")):
        """With one line for each error and nothing written."""
        options = {"check": (), "mesh": ("-o", self.folder / "mesh.vtkhdf"), "run": ("-o", self.out),
                   "sample": ("--sample", 0, "-o", self.out)}
        for command in commands:
            arguments = (command, self.plate, *options[command])
            result = invoke(*arguments)
            self.assertEqual(result.returncode, 1, arguments)
            self.assertNotIn("is valid", result.stdout, arguments)
            lines = result.stderr.splitlines()
            self.assertEqual(len(lines), len(expected), result.stderr)
            for line, (number, reason) in zip(lines, expected):
                place = f"{self.cloud}:{number}: " if number else f"{self.cloud}: "
                self.assertIn(place + reason, line, arguments)
            self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["cloud.txt", "plate.toml"])

    def test_every_bad_line_is_named(self):
        self.cloud.write_text("\n".join(["# a cloud", *CORNERS, "1 2", "1 2 3 4", "1 two 3", "", "1 1 1  # fine",
                                         "nan 1 1", "3.1 1 1", "1, 1, 1", "1e400 0 0"]))
        self.assert_refused((10, "not a point"), (11, "not a point"), (12, "not a point"), (15, "not a point"),
                            (16, "the point (3.1, 1, 1) mm lies outside the body"), (18, "not a point"),
                            (17, "the same point as in line 14"), commands=("check", "mesh", "run", "sample"))

    def test_missing_corner(self):
        self.cloud.write_text("\n".join([*CORNERS[:3], *CORNERS[4:], "1 1 1"]))
        self.assert_refused((0, "the corner (0, 8, 16) mm of the body is not among the points"))

    def test_empty_and_binary_files(self):
        self.cloud.write_text("# nothing\n")
        self.assert_refused((0, "the corner (0, 0, 0) mm"))
        self.cloud.write_bytes(b"\x89HDF\r\n\x1a\n\0\0\n")
        self.assert_refused((1, "not a point"), (2, "not a point"), (3, "not a point"))

    def test_samples_with_points_of_their_own(self):
        self.plate.write_text(INPUT.replace("[mesh]", '[mesh]\nbase = "own"'))
        result = invoke("run", self.plate, "-o", self.out)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertIn("base mesh: one for each sample", result.stdout)
        with h5py.File(self.out / "ensemble.h5") as root:
            self.assertNotIn("mother_points", root)
            scope = root["statistics"].attrs["interval_scope"]
        self.assertIn("independent samples", scope)
        nodes = []
        for sample in (0, 1):
            mesh = self.folder / "mesh.vtkhdf"
            result = invoke("mesh", self.plate, "--sample", sample, "-o", mesh)
            self.assertEqual(result.returncode, 0, result.stderr)
            with h5py.File(mesh) as root, h5py.File(self.out / "samples" / f"000{sample}.h5") as stored:
                nodes.append(root["VTKHDF/Points"][...])
                np.testing.assert_array_equal(nodes[-1], stored["mesh/nodes"][...])
        # Another sample of the same base would have a node within a tenth of the spacing of each, or near its mirror image.
        images = np.concatenate([np.where(axes, np.array(SIZE) * 1e-3 - nodes[1], nodes[1])
                                 for axes in np.ndindex(2, 2, 2)])
        inner = nodes[0][((nodes[0] > 0) & (nodes[0] < np.array(SIZE) * 1e-3)).all(axis=1)]
        nearest = np.linalg.norm(inner[:, None] - images.reshape(8, 1, -1, 3), axis=3).min(axis=2)
        self.assertGreater(nearest.max(axis=1).min(), 0.3e-3)

        (self.out / "ensemble.h5").unlink()
        result = invoke("stats", self.out)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn(scope, result.stdout)
        with h5py.File(self.out / "ensemble.h5") as root:
            self.assertNotIn("mother_points", root)
        (self.out / "samples" / "0001.h5").unlink()
        result = invoke("run", self.plate, "-o", self.out, "--resume")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        for kept in (True, False):  # a report of the files that a run leaves, and of one that has not come to its end
            if not kept:
                (self.out / "ensemble.h5").unlink()
            report = in_process.report(self.out, "--program", OPTIONS.program, "--no-animation")
            self.assertEqual((report.returncode, report.stderr), (0, ""))
            self.assertIn(scope, (self.out / "report.html").read_text())

    def test_an_ensemble_keeps_to_its_points(self):
        self.write_generated_points()
        result = invoke("run", self.plate, "-o", self.out)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertEqual((self.out / "points.txt").read_bytes(), self.cloud.read_bytes())
        with h5py.File(self.out / "ensemble.h5") as root:
            stored = root["mother_points/position"][...]
            self.assertIn("FNV-1a", root.attrs["points"])
        written = np.loadtxt(self.cloud)
        np.testing.assert_allclose(sorted(stored.tolist()), sorted((written * 1e-3).tolist()), atol=1e-12)

        # The statistics need the original no more.
        self.cloud.rename(self.folder / "elsewhere.txt")
        (self.out / "ensemble.h5").unlink()
        result = invoke("stats", self.out)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("2 samples: 2 done", result.stdout)
        with h5py.File(self.out / "ensemble.h5") as root:
            np.testing.assert_array_equal(root["mother_points/position"][...], stored)

        # The same points go on; others are refused, and nothing is touched.
        shutil.copy(self.folder / "elsewhere.txt", self.cloud)
        (self.out / "samples" / "0001.h5").unlink()
        result = invoke("run", self.plate, "-o", self.out, "--resume")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertIn("1 of 2 samples to compute", result.stdout)
        before = {path: path.stat().st_mtime_ns for path in self.out.rglob("*")}
        lines = self.cloud.read_text().splitlines(keepends=True)
        inner = next(i for i, point in enumerate(written)
                     if all(1 < coordinate < size - 1 for coordinate, size in zip(point, SIZE)))
        lines[inner] = "1.25 " + " ".join(lines[inner].split()[1:]) + "\n"
        self.cloud.write_text("".join(lines))
        for arguments in (("run", self.plate, "-o", self.out, "--resume"),
                          ("sample", self.plate, "--sample", 1, "-o", self.out)):
            result = invoke(*arguments)
            self.assertEqual(result.returncode, 1, result.stdout)
            self.assertIn(f"another input: compared with {self.out / 'points.txt'}, line {inner + 1} is '1.25 ",
                          result.stderr)
            self.assertEqual({path: path.stat().st_mtime_ns for path in self.out.rglob("*")}, before)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", required=True)
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
