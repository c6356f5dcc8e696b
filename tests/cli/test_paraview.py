#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of tools/crackle-paraview, opened by VTK's own reader and drawn without a screen."""
from __future__ import annotations

import json
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

import in_process  # noqa: E402
from crackle_report import paraview  # noqa: E402
from crackle_report.choosing import samples_in_detail  # noqa: E402
from crackle_report.reading import read_ensemble  # noqa: E402
from crackle_report.sample_files import SampleFiles  # noqa: E402
from synthetic_ensemble import changed, write_ensemble  # noqa: E402

try:
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOHDF import vtkHDFReader
except ImportError:
    vtkHDFReader = None

# Draws the crack surface by time, and the displaced plate by stress; prints what the picture holds.
DRAW = """
import sys
from pathlib import Path
import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

def read(file):
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(file))
    reader.Update()
    return reader.GetOutput()

folder, picture = map(Path, sys.argv[1:])
renderer = vtk.vtkRenderer()
renderer.SetBackground(1, 1, 1)
for file, field, shift in (("crack.vtkhdf", "time", 0.0), ("frame-0002.vtkhdf", "principal_stress", 0.04)):
    grid = read(folder / file)
    grid.GetCellData().SetActiveScalars(field)
    mapper = vtk.vtkDataSetMapper()
    mapper.SetInputData(grid)
    mapper.SetScalarModeToUseCellData()
    mapper.SetScalarRange(0, grid.GetCellData().GetArray(field).GetRange()[1])
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.SetPosition(0, shift, 0)
    actor.GetProperty().LightingOff()
    renderer.AddActor(actor)
camera = renderer.GetActiveCamera()
camera.SetFocalPoint(0, 0.03, 0.07)
camera.SetPosition(1, 0.03, 0.07)
camera.SetViewUp(0, 0, 1)
camera.ParallelProjectionOn()
camera.SetParallelScale(0.03)
window = vtk.vtkRenderWindow()
window.SetOffScreenRendering(1)
window.SetSize(600, 500)
window.AddRenderer(renderer)
window.Render()
grab = vtk.vtkWindowToImageFilter()
grab.SetInput(window)
grab.Update()
writer = vtk.vtkPNGWriter()
writer.SetFileName(str(picture))
writer.SetInputConnection(grab.GetOutputPort())
writer.Write()
image = vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars())
drawn = (image != 255).any(axis=1)
print(int(drawn.sum()), len(np.unique(image[drawn], axis=0)))
"""


def start(*arguments: str) -> subprocess.CompletedProcess:
    """The command itself."""
    return subprocess.run([str(ROOT / "tools" / "crackle-paraview"), *arguments], capture_output=True, text=True,
                          check=False, env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})


def run(*arguments: str) -> subprocess.CompletedProcess:
    """What the command does, without a start of Python."""
    return in_process.call(paraview.main, *arguments)


class ParaView(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls._folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls._folder.cleanup)
        cls.folder = Path(cls._folder.name) / "out"
        write_ensemble(cls.folder, 3, failed=(2,))
        cls.result = start(str(cls.folder), "--sample", "1")
        cls.files = cls.folder / "paraview" / "0001"

    def read(self, name: str):
        if vtkHDFReader is None:
            self.skipTest("python3-vtk9 is not installed")
        reader = vtkHDFReader()
        self.assertTrue(reader.CanReadFile(str(self.files / name)))
        reader.SetFileName(str(self.files / name))
        reader.Update()
        return reader.GetOutput()

    def test_files_for_each_frame_and_for_the_whole_crack(self):
        self.assertEqual((self.result.returncode, self.result.stderr), (0, ""))
        self.assertEqual(self.result.stdout, f"12 files in {self.files}\n")
        self.assertEqual(sorted(file.name for file in self.files.iterdir()),
                         [*(f"crack-{k:04d}.vtkhdf" for k in range(4)), "crack.hdf.series", "crack.vtkhdf",
                          *(f"frame-{k:04d}.vtkhdf" for k in range(4)), "frame.hdf.series", "view.py"])
        times = SampleFiles(self.folder).frames(1).time.tolist()
        for kind in ("frame", "crack"):
            series = json.loads((self.files / f"{kind}.hdf.series").read_text())
            self.assertEqual(series["file-series-version"], "1.0")
            self.assertEqual([(entry["name"], entry["time"]) for entry in series["files"]],
                             [(f"{kind}-{k:04d}.vtkhdf", time) for k, time in enumerate(times)])

    def test_without_a_number_it_is_a_sample_of_the_report(self):
        result = run(str(self.folder), "-o", str(self.folder / "typical"))
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        number = samples_in_detail(read_ensemble(self.folder))[0]
        self.assertEqual(result.stdout, f"sample {number}, a typical one: 12 files in {self.folder / 'typical'}\n")

    def test_the_crack_opens_and_moves_with_the_body(self):
        files = SampleFiles(self.folder)
        crack, frames = files.crack(1), files.frames(1)
        counts = []
        for k, time in enumerate(frames.time):
            grid = self.read(f"crack-{k:04d}.vtkhdf")
            opened = crack.time <= time
            counts.append(grid.GetNumberOfCells())
            self.assertEqual(counts[-1], opened.sum())
            if not opened.any():
                continue
            moved = vtk_to_numpy(grid.GetPointData().GetArray("displacement")).reshape(-1, 4, 3)
            nodes = frames.tetrahedra[crack.tetrahedron[opened]]
            corner, values = frames.nodes[nodes], frames.displacement[k][nodes]
            # Barycentric coordinates of the facets' corners.
            system = np.concatenate([corner.transpose(0, 2, 1), np.ones((len(nodes), 1, 4))], axis=1)
            points = np.concatenate([crack.corner[opened].astype(float), np.ones((len(nodes), 4, 1))], axis=2)
            share = np.linalg.solve(system, points.transpose(0, 2, 1)).transpose(0, 2, 1)
            np.testing.assert_allclose(moved, share @ values, rtol=1e-4, atol=1e-5 * np.abs(values).max())
        self.assertEqual(counts, sorted(counts))
        self.assertLess(counts[0], counts[-1])

    @unittest.skipUnless(shutil.which("pvpython") and shutil.which("xvfb-run"), "ParaView is not installed")
    def test_paraview_runs_the_script(self):
        picture = self.folder / "view.png"
        drawn = subprocess.run(["xvfb-run", "-a", "pvpython", str(self.files / "view.py"), str(picture)], capture_output=True,
                               text=True, check=False, timeout=300)
        self.assertEqual(drawn.returncode, 0, drawn.stderr)
        with Image.open(picture) as image:
            pixels = np.asarray(image.convert("RGB")).reshape(-1, 3)
        self.assertGreater(len(np.unique(pixels, axis=0)), 50)
        self.assertGreater((pixels != 255).any(axis=1).mean(), 0.05)

    def test_vtk_reads_the_frames(self):
        frames = SampleFiles(self.folder).frames(1)
        for k, factor in enumerate((1, 1.1, 1.2, 1.3)):
            grid = self.read(f"frame-{k:04d}.vtkhdf")
            self.assertEqual(grid.GetNumberOfPoints(), len(frames.nodes))
            self.assertEqual(grid.GetNumberOfCells(), len(frames.tetrahedra))
            self.assertEqual(grid.GetCellType(0), 10)
            fields = {name: vtk_to_numpy(grid.GetCellData().GetArray(name))
                      for name in ("stress", "broken", "principal_stress")}
            np.testing.assert_array_equal(vtk_to_numpy(grid.GetPointData().GetArray("displacement")),
                                          frames.displacement[k])
            np.testing.assert_array_equal(vtk_to_numpy(grid.GetPointData().GetArray("velocity")), frames.velocity[k])
            np.testing.assert_array_equal(np.flatnonzero(fields["broken"]), np.sort(frames.broken[k]))
            whole = fields["broken"] == 0
            expected = 3300e6 * 1e-3 * factor
            found = fields["principal_stress"][whole]
            print(f"frame {k}: principal stress {found.min():.4e} to {found.max():.4e} Pa, exact {expected:.4e}")
            np.testing.assert_allclose(found, expected, rtol=1e-3)
            np.testing.assert_allclose(fields["stress"][whole], np.outer(np.ones(whole.sum()), [0, 0, expected, 0, 0, 0]),
                                       atol=1e-3 * expected)
            self.assertEqual(np.abs(fields["stress"][~whole]).sum(), 0)
            time = vtk_to_numpy(grid.GetFieldData().GetArray("TimeValue"))
            self.assertEqual(time[0], frames.time[k])

    def test_softened_tetrahedra_have_the_stiffness_that_is_left(self):
        frames = SampleFiles(self.folder).frames(0)
        whole = np.setdiff1d(np.arange(len(frames.tetrahedra)), frames.broken[-1])
        early, late = (int(t) for t in whole[:2])
        with changed(self.folder / "samples" / "0000.h5") as root:
            start = 1.0
            root["summary/phase_start"] = start
            teeth = root.create_group("softening")
            teeth["tetrahedron"] = [early, late, early]
            teeth["load_time"] = [0.5 * start, start, start]
            teeth["phase_time"] = [0, frames.time[2], frames.time[2]]
            teeth["share"] = [0.75, 0.5, 0.25]
        self.assertEqual(run(str(self.folder), "--sample", "0").returncode, 0)
        self.files = self.folder / "paraview" / "0000"
        for k, shares in ((0, (0.75, 1)), (1, (0.75, 1)), (2, (0.25, 0.5)), (3, (0.25, 0.5))):
            stiffness = vtk_to_numpy(self.read(f"frame-{k:04d}.vtkhdf").GetCellData().GetArray("stiffness"))
            self.assertEqual((stiffness[early], stiffness[late]), shares, k)
            np.testing.assert_array_equal(np.flatnonzero(stiffness == 0), np.sort(frames.broken[k]))

    def test_vtk_reads_tools_where_they_move(self):
        shapes = {"a ball": ("sphere", {"radius": 2e-3}), "a box": ("box", {"size": [4e-3, 6e-3, 8e-3]}), "a die": ("box", {"size": [4e-3, 6e-3, 8e-3], "rounding": 1e-3}),
                  "a pin": ("cylinder", {"radius": 2e-3, "size": [6e-3], "axis": [0, 1, 1]}),
                  "a punch": ("cylinder", {"radius": 2e-3, "size": [6e-3], "axis": [3, 0, 0], "rounding": 2e-3}),
                  "a roller": ("cylinder", {"radius": 2e-3, "axis": [0, 0, -1]}), "a wall": ("plane", {"axis": [0, 1, 0]})}
        frames, at, speed = SampleFiles(self.folder).frames(0), np.array([1e-3, -2e-3, 3e-3]), np.array([5.0, 0, -7.0])
        with changed(self.folder / "samples" / "0000.h5") as root:
            history = root.require_group("history")
            for name, values in (("phase", np.ones(2, "i4")), ("phase_time", frames.time[[0, -1]])):
                if name in history:
                    del history[name]
                history[name] = values
            for name, (shape, keys) in shapes.items():
                root.create_group(f"tools/{name}").attrs.update({"shape": shape, "at": at, "radius": 0.0, "rounding": 0.0, **keys})
                history[f"tools/{name}/position"] = at + frames.time[[0, -1], None] * speed
            history["tools/a pin/orientation"] = np.tile([np.sqrt(0.5), 0, 0, np.sqrt(0.5)], (2, 1))
        self.assertEqual(run(str(self.folder), "--sample", "0").returncode, 0)
        self.files = self.folder / "paraview" / "0000"
        reach = np.linalg.norm(np.ptp(frames.nodes, axis=0))
        areas = {"a ball": 16e-6 * np.pi, "a box": 208e-6, "a roller": 2e-3 * np.pi * 4 * reach, "a wall": reach ** 2,
                 # Flat sides, quarters of cylinders at the edges, and a sphere of the corners.
                 "a die": (2 * (2 * 4 + 4 * 6 + 2 * 6) + 2 * np.pi * (2 + 4 + 6) + 4 * np.pi) * 1e-6,
                 "a pin": (2 * 4 + 2 * 2 * 6) * np.pi * 1e-6, "a punch": (16 + 4 * 2) * np.pi * 1e-6}
        for k, time in enumerate(frames.time):
            grid = self.read(f"tools-{k:04d}.vtkhdf")
            points = vtk_to_numpy(grid.GetPoints().GetData())
            cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4)
            corners = points[cells]
            number = vtk_to_numpy(grid.GetCellData().GetArray("tool"))
            moved = vtk_to_numpy(grid.GetPointData().GetArray("displacement"))
            way, of_pin = np.tile(time * speed, (len(moved), 1)), np.unique(cells[number == sorted(shapes).index("a pin")])
            way[of_pin] += (points[of_pin] - at) @ np.array([(-1, 1, 0), (-1, -1, 0), (0, 0, 0)])  # a quarter of a turn about z
            np.testing.assert_allclose(moved, way, rtol=1e-5, atol=1e-9)
            outward = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]) / 2
            for tool, name in enumerate(sorted(shapes)):
                own = number == tool
                self.assertAlmostEqual(np.linalg.norm(outward[own], axis=1).sum() / areas[name], 1, delta=0.01, msg=name)
                if name not in ("a wall", "a roller"):  # closed, and all of it seen from outside
                    middle = corners[own].mean(axis=1) - at
                    self.assertGreater((outward[own] * middle).sum(axis=1).min(), -1e-15, name)
                    np.testing.assert_allclose(outward[own].sum(axis=0), 0, atol=1e-12)

    def test_vtk_reads_the_crack_with_its_time(self):
        crack = SampleFiles(self.folder).crack(1)
        grid = self.read("crack.vtkhdf")
        self.assertEqual(grid.GetNumberOfCells(), len(crack.time))
        self.assertEqual(grid.GetCellType(0), 9)
        np.testing.assert_array_equal(vtk_to_numpy(grid.GetCellData().GetArray("time")), crack.time)
        np.testing.assert_array_equal(vtk_to_numpy(grid.GetCellData().GetArray("notch")), crack.notch)
        last = [grid.GetCell(len(crack.time) - 1).GetPoints().GetPoint(i) for i in range(4)]
        np.testing.assert_allclose(last, crack.corner[-1], rtol=1e-6)

    def test_vtk_draws_them_without_a_screen(self):
        if vtkHDFReader is None or shutil.which("xvfb-run") is None:
            self.skipTest("python3-vtk9 or xvfb is not installed")
        picture = Path(self._folder.name) / "picture.png"
        result = subprocess.run(["xvfb-run", "-a", "/usr/bin/python3", "-c", DRAW, str(self.files), str(picture)],
                                capture_output=True, text=True, check=False, timeout=120)
        self.assertEqual(result.returncode, 0, result.stderr)
        n_drawn, n_colours = map(int, result.stdout.split())
        print(f"{n_drawn} of 300000 pixels drawn in {n_colours} colours")
        # The plate covers 24.5 of 72 mm in width; the crack's facets have many times, hence colours.
        self.assertGreater(n_drawn, 0.3 * 300000)
        self.assertGreater(n_colours, 50)
        self.assertTrue(picture.read_bytes().startswith(b"\x89PNG"))

    def test_what_is_not_there_ends_with_one_line(self):
        for arguments, message in (((str(self.folder), "--sample", "2"), "sample 2 is not done"),
                                   ((str(self.folder), "--sample", "7"), "sample 7 is not done"),
                                   ((str(self.folder / "no"), "--sample", "1"), "there is no folder")):
            result = run(*arguments)
            self.assertEqual(result.returncode, 1)
            self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
            self.assertIn(message, result.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
