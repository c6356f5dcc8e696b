#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies from files: what is refused, runs on several ranks and after a restart, a cube beside the box, and a disk between platens."""
import argparse
import os
import pathlib
import random
import shlex
import subprocess
import sys
import tempfile
import unittest

import h5py
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "jobs" / "gallery")]

import command_lines  # noqa: E402
import crackle  # noqa: E402
import in_process  # noqa: E402
from effort import repetitions  # noqa: E402
import solid  # noqa: E402
import solid_files  # noqa: E402
from crackle_launch import environment  # noqa: E402
from solid_files import SIDES, stl  # noqa: E402

OPTIONS = None
BODY = """[ensemble]
samples = {samples}
seed = 3
[specimen]
{specimen}
[mesh]
spacing = "{spacing} mm"
growth = 0.2
[material]
youngs_modulus = "3300 MPa"
poisson_ratio = {poisson}
density = "1180 kg/m^3"
[fracture]
strength = "{strength} MPa"
toughness = "{toughness} J/m^2"
"""
PULLED = """[[boundary]]
on = "z-min"
fix = ["x", "y", "z"]
[[boundary]]
on = "z-max"
force = ["0 N", "0 N", "10 N"]
rate = ["0 N/s", "0 N/s", "10 N/s"]
[time]
duration = "20 us"
integrator = "verlet"
"""
FROM_FILE = 'solid = "cube.stl"\nunit = "mm"'
CORNERS = np.array(solid_files.CORNERS, float)


def invoke(*arguments):
    return command_lines.crackle(OPTIONS.program, *arguments)


def body(specimen=FROM_FILE, samples=2, spacing=1.25, poisson=0.3, strength=35, toughness=200, rest=PULLED):
    return BODY.format(specimen=specimen, samples=samples, spacing=spacing, poisson=poisson, strength=strength, toughness=toughness) + rest


def prism(n, radius, thickness):
    """Along x, with flat sides at the ends of z."""
    turn = 2 * np.pi * (np.arange(n) + 0.5) / n
    corners = np.array([(x, radius * np.sin(angle), radius * np.cos(angle)) for x in (0, thickness) for angle in turn])
    sides = [(i, n + i, n + (i + 1) % n, (i + 1) % n) for i in range(n)]
    return corners, [*sides, tuple(range(n)), tuple(range(2 * n - 1, n - 1, -1))]


def results_of(folder):
    """Everything in its sample files but times and places."""
    found = {}

    def keep(name, one):
        if isinstance(one, h5py.Dataset) and not name.startswith(("timing", "provenance")):
            values = one[...]
            found[f"{file.name}/{name}"] = values.tolist() if values.dtype == object else values.tobytes()

    for file in sorted((folder / "samples").glob("*.h5")):
        with h5py.File(file) as root:
            root.visititems(keep)
    return found


class Solids(unittest.TestCase):
    def setUp(self):
        parent = tempfile.TemporaryDirectory(prefix="crackle-solid-")
        self.addCleanup(parent.cleanup)
        self.folder = pathlib.Path(parent.name)
        self.input, self.cube, self.out = (self.folder / name for name in ("cube.toml", "cube.stl", "out"))
        self.cube.write_text(stl(5 * CORNERS, SIDES))
        self.input.write_text(body())

    def refused(self, text, *parts):
        self.input.write_text(text)
        before = sorted(self.folder.rglob("*"))
        for words in (("check", self.input), ("run", self.input, "-o", self.out)):
            result = invoke(*words)
            self.assertEqual(result.returncode, 1, result.stdout)
            self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
            for part in (str(self.input), *parts):
                self.assertIn(part, result.stderr)
        self.assertEqual(sorted(self.folder.rglob("*")), before)

    def test_what_is_refused(self):
        self.refused(body('solid = "none.stl"\nunit = "mm"'), ":5: specimen.solid: there is no file", "give the name of a file with a closed surface")
        self.refused(body('solid = "cube.stl"'), ":4: specimen.unit: the key is missing, but solid requires it")
        self.refused(body('solid = "cube.stl"\nunit = "N"'), ":6: specimen.unit: ", '"N" is no unit of length; give one such as "mm"')
        self.refused(body('solid = "cube.stl"\nunit = "1 mm"'), ":6: specimen.unit: ", '"1 mm" is no unit of length')
        self.refused(body('size = ["5 mm", "5 mm", "5 mm"]\nunit = "mm"', rest=PULLED + '[sections]\ny = ["2 mm"]\n'),
                     ":6: specimen.unit: requires solid")
        self.refused(body(FROM_FILE + '\nsize = ["5 mm", "5 mm", "5 mm"]'), ":7: specimen.size: cannot be combined with solid")
        self.refused(body().replace('"z-max"', '"top"'), ':21: boundary[1].on: "top" is not known; give one of "face-0", ')
        self.refused(body().replace("rate", 'region = { x = ["6 mm", "7 mm"] }\nrate'), ':23: boundary[1].region: misses "z-max", which has x from 0 mm to 5 mm')
        self.refused(body(rest=PULLED + '[sections]\ny = ["2 mm"]\n'), "sections: needs a plate")
        self.refused(body(FROM_FILE + '\n[[specimen.hole]]\ncenter = ["2 mm", "2 mm"]\nradius = "1 mm"'), ":7: specimen.hole: requires a plate")
        self.refused(body(rest=PULLED + '[[output.probe]]\nname = "a"\nat = ["2 mm", "2 mm", "6 mm"]\n'), "output.probe[0].at: z = 6 mm is outside the body")
        self.cube.write_text(stl(5 * CORNERS, SIDES, skip=(5,)))
        self.refused(body(), 'cube.stl" is not closed: the edge from (0, 0, 5) mm to ')
        self.cube.write_text(stl([5, 5, 5] * CORNERS * [1, 1, 0.01], SIDES))
        self.refused(body(spacing=4), ":5: specimen.solid: has an edge of 0.05 mm at (0 mm, 0 mm, 0 mm), less than a fiftieth of the spacing there, 4 mm")
        leaning = 5 * CORNERS
        leaning[4:, 0] += 95
        self.cube.write_text(stl(leaning, SIDES))
        self.refused(body(), "mesh.min_quality: ", " has 3.01 degrees")

    def check(self, extension, content):
        (self.folder / f"cube{extension}").write_bytes(content)
        self.input.write_text(body(FROM_FILE.replace(".stl", extension)))
        return invoke("check", "--no-measure", self.input)

    def test_damaged_files_are_refused_or_read(self):
        stream = random.Random(2)
        formats = solid_files.every_format()
        for extension, content in formats:
            self.assertEqual(self.check(extension, content).returncode, 0, extension)
        n_read = 0
        for extension, content in OPTIONS.damaged // len(formats) * formats:
            damaged = solid_files.damaged(stream, content)
            result = self.check(extension, damaged)
            self.assertIn(result.returncode, (0, 1), damaged)
            n_read += result.returncode == 0
            if result.returncode == 1:
                messages = result.stderr.splitlines()
                self.assertTrue(all(str(self.input) in message for message in messages), messages)
                self.assertTrue(len(messages) == 1 or "specimen.solid" not in result.stderr, messages)  # others are about what was read
        print(f"{n_read} of {OPTIONS.damaged} damaged files are read")
        self.assertLess(n_read, OPTIONS.damaged // 4)

    def test_formats_that_are_not_read_say_how_to_convert_them(self):
        gmsh = dict(solid_files.every_format())[".msh"]
        for extension, content, way in ((".vtu", b"<VTKFile/>", "save it as .vtk in ASCII"), (".step", b"", "gmsh -2 FILE -o body.msh"),
                                        (".msh", gmsh.replace(b" 0 8", b" 1 8"), "gmsh FILE -save -o body.msh"),
                                        (".vtk", b"# vtk DataFile Version 3.0\n\nBINARY\n", "meshio convert")):
            result = self.check(extension, content)
            self.assertEqual((result.returncode, len(result.stderr.splitlines())), (1, 1), result.stderr)
            self.assertIn(way, result.stderr)

    def test_check_and_mesh_list_the_faces(self):
        for words in (("check", "--no-measure", self.input), ("mesh", self.input, "-o", self.folder / "mesh.vtkhdf")):
            result = invoke(*words)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertRegex(result.stdout, r"face-0 +=? *1 plane, 25 mm\^2 about \(0, 2.5, 2.5\) mm, normal \(-1, 0, 0\)")
            self.assertRegex(result.stdout, r"z-max +=? *1 plane, 25 mm\^2 about \(2.5, 2.5, 5\) mm, normal \(0, 0, 1\)")
        with h5py.File(self.folder / "mesh.vtkhdf") as root:
            face, points = root["VTKHDF/PointData/face"][...], root["VTKHDF/Points"][...]
        np.testing.assert_array_equal(face >= 0, ((points == 0) | (points == points.max())).any(axis=1))

    def test_ranks_restart_and_pictures(self):
        middle = "2.5 mm"
        self.input.write_text(body(rest=PULLED + f"""[[sections.plane]]
point = ["{middle}", "{middle}", "{middle}"]
normal = [0, 1, 0]
[[sections.plane]]
point = ["-1 mm", "{middle}", "{middle}"]
normal = [1, 0, 0]
"""))
        self.assertEqual(invoke("run", self.input, "-o", self.out).returncode, 0)
        wanted = results_of(self.out)
        self.assertEqual((self.out / "solid.stl").read_bytes(), self.cube.read_bytes())
        there = self.folder / "three"
        command = [*shlex.split(OPTIONS.mpirun), "-n", "3", os.path.abspath(OPTIONS.program), "run", self.input, "-o", there]
        subprocess.run([*map(str, command)], env=environment(), check=True, capture_output=True)
        self.assertTrue(results_of(there) == wanted)
        # Another file under the same name is another body; without the file the folder's copy is enough.
        (self.out / "samples/0001.h5").unlink()
        self.cube.write_text(stl(5 * CORNERS + [0, 0, 1e-9], SIDES))
        result = invoke("run", self.input, "-o", self.out, "--resume")
        self.assertEqual(result.returncode, 1)
        self.assertIn("holds an ensemble of another input", result.stderr)
        self.cube.write_text(stl(5 * CORNERS, SIDES))
        self.assertEqual(invoke("run", self.input, "-o", self.out, "--resume").returncode, 0)
        self.assertTrue(results_of(self.out) == wanted)
        self.cube.unlink()
        result = invoke("stats", self.out)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("first break at x [mm]", result.stdout)
        self.assertRegex(result.stdout, r"plane 0 through \(2.5, 2.5, 2.5\) mm, normal \(0, 1, 0\): crossed by 2 of 2 samples")
        self.assertRegex(result.stdout, r"plane 1 .*: crossed by 0 of 2 samples")
        with h5py.File(self.out / "samples/0001.h5") as root:
            area, reach, speed = (root[f"history/cracks/{name}"][...] for name in ("area", "reach", "speed"))
            lower, upper, of_crack = (root[f"crack_surface/cracks/{name}"][...] for name in ("lower", "upper", "area"))
            largest = np.argmax(of_crack)
            np.testing.assert_allclose(area[-1], of_crack, rtol=1e-12)
            self.assertLess(reach[-1, largest], np.linalg.norm(upper[largest] - lower[largest]))
            self.assertGreater(reach[-1, largest], 0.002)
            running = speed[np.isfinite(speed[:, largest]), largest]
            self.assertTrue((running < 960).all(), running)  # Rayleigh waves: 956 m/s
            self.assertTrue((lower >= 0).all() and (upper <= 0.005).all())
        for file in ("ensemble.h5", "samples/0001.h5"):
            with h5py.File(self.out / file) as one, h5py.File(there / file) as other:
                for name in ("plane_traces", "statistics/traces") if file == "ensemble.h5" else ("summary/traces",):
                    for column in one[name]:
                        np.testing.assert_array_equal(one[name][column][...], other[name][column][...], column)
        with h5py.File(self.out / "ensemble.h5") as root:
            length, mean = root["plane_traces/length"][...], root["statistics/traces/length_mean"][...]
            np.testing.assert_allclose(length[:, 0].mean(axis=0), mean[0], rtol=1e-14)
            self.assertTrue((length[:, 0, -1] > 0.005).all() and (length[:, 1] == 0).all(), length)
        for absent in ("branching projected", "kinks", "traced area", "crack speed"):
            self.assertNotIn(absent, result.stdout)
        result = in_process.report(self.out, "--program", OPTIONS.program)
        self.assertEqual(result.returncode, 0, result.stderr)
        pictures = {path.stem for path in (self.out / "report").glob("*.png")}
        self.assertTrue({"crack-0000", "places", "load", "surface-0000"} <= pictures, pictures)

    def test_a_cube_from_a_file_breaks_as_the_box_does(self):
        loads = {}
        for name, specimen in (("file", FROM_FILE), ("box", 'size = ["5 mm", "5 mm", "5 mm"]')):
            sections = "" if name == "file" else '[sections]\ny = ["2.5 mm"]\n'
            self.input.write_text(body(specimen, samples=24, rest=PULLED + sections))
            result = invoke("run", self.input, "-o", self.folder / name)
            self.assertEqual(result.returncode, 0, result.stderr)
            with h5py.File(self.folder / name / "ensemble.h5") as root:
                loads[name] = root["samples/first_break_load"][...]
        mean, error = ([np.mean(one) for one in loads.values()], np.hypot(*(np.std(one) / np.sqrt(one.size) for one in loads.values())))
        print(f"first break of a cube: {mean[0]:.1f} N from a file, {mean[1]:.1f} N of the box, standard error {error:.1f} N")
        self.assertLess(abs(mean[0] - mean[1]), 3 * error)

    def stresses_at_centre(self) -> list:
        """At the start, by sample, of a run of the input with a probe there."""
        result = invoke("run", self.input, "-o", self.out)
        self.assertEqual(result.returncode, 0, result.stderr)
        found = []
        for file in sorted((self.out / "samples").glob("*.h5")):
            with h5py.File(file) as root:
                found.append(root["history/probes/centre/stress"][0])
        return found

    def test_a_disk_between_platens_has_hondros_tension(self):
        n, radius, thickness, force = 40, 6.0, 2.0, 100.0
        (self.folder / "disk.stl").write_text(stl(*prism(n, radius, thickness)))
        place = [f'"{value} mm"' for value in (thickness / 2, 0, 0)]
        self.input.write_text(body('solid = "disk.stl"\nunit = "mm"', samples=6, spacing=0.5, poisson=0.2, strength=500, toughness=5000, rest=f"""[[boundary]]
on = "z-min"
fix = ["z"]
[[boundary]]
on = "z-min"
region = {{ y = ["0 mm", "0 mm"] }}
fix = ["y"]
[[boundary]]
on = "z-min"
region = {{ x = ["1 mm", "1 mm"] }}
fix = ["x"]
[[boundary]]
on = "z-max"
force = ["0 N", "0 N", "-{force} N"]
[time]
start = "equilibrium"
duration = "1 us"
[[output.probe]]
name = "centre"
at = [{", ".join(place)}]
"""))
        found = self.stresses_at_centre()
        half = np.pi / n  # of the arc, on which the load is spread
        tension = 2 * force / (np.pi * 2 * radius * thickness) * (np.sin(2 * half) / half - 1)
        stress = np.mean(found, axis=0) / 1e6
        print(f"in the middle of the disk: {stress[1]:.3f} and {stress[2]:.3f} MPa; Hondros: {tension:.3f} and {-3 * tension:.3f} MPa")
        self.assertAlmostEqual(stress[1] / tension, 1, delta=0.06)
        self.assertAlmostEqual(stress[2] / (-3 * tension), 1, delta=0.06)

    def test_a_sphere_between_caps_has_hiramatsus_and_okas_stress(self):
        """At the centre only the terms of degrees 0 and 2 of the pressure make stress, (7 + 2 nu) / (7 + 5 nu) times the latter. For
        forces in points that is 21 / (28 + 20 nu) F / (pi R^2) across the axis (Hiramatsu and Oka 1966; Sternberg and Rosenthal 1952)."""
        radius, pressure, poisson, n = 5.0, 10.0, 0.25, 24
        angles = np.radians(np.arange(6, 175, 12))[::-1]  # from below
        profile = [(radius * np.cos(angle), radius * np.sin(angle)) for angle in angles]
        n_cap = 2  # rings of each cap: up to 30 degrees
        groups = ["lower"] * n_cap + ["side"] * (len(angles) - 1 - 2 * n_cap) + ["upper"] * n_cap
        points, polygons = solid.bands(n, profile, groups)
        polygons += [("lower", list(range(n))[::-1]), ("upper", list(range(len(points) - n, len(points))))]
        (self.folder / "sphere.obj").write_text(solid.text(points, polygons))
        held = "".join(f'''[[boundary]]
on = "side"
region = {{ {axis} = ["0 mm", "0 mm"] }}
fix = ["{axis}"]
''' for axis in "xyz")
        pressed = "".join(f'''[[boundary]]
on = "{cap}"
pressure = "{pressure} MPa"
''' for cap in ("lower", "upper"))
        self.input.write_text(body('solid = "sphere.obj"\nunit = "mm"', samples=2, spacing=0.45, poisson=poisson, strength=500, toughness=5000, rest=held + pressed + """[time]
start = "equilibrium"
duration = "1 us"
[[output.probe]]
name = "centre"
at = ["0 mm", "0 mm", "0 mm"]
"""))
        found = self.stresses_at_centre()
        stress = np.mean(found, axis=0) / 1e6
        edge = np.cos(np.radians(30))
        mean = pressure * (1 - edge)  # over the sphere
        second = 5 * mean * edge * (1 + edge) / 2 * (7 + 2 * poisson) / (7 + 5 * poisson)
        across, along = second / 2 - mean, -second - mean
        print(f"in the middle of the sphere: {stress[0]:.3f}, {stress[1]:.3f} and {stress[2]:.3f} MPa; exact: {across:.3f} and {along:.3f} MPa")
        self.assertAlmostEqual(stress[0] / across, 1, delta=0.06)
        self.assertAlmostEqual(stress[1] / across, 1, delta=0.06)
        self.assertAlmostEqual(stress[2] / along, 1, delta=0.04)

    def test_a_crack_forks_where_the_load_is_high(self):
        """In a thin block whose long faces are moved apart; forks are results as those of plates are."""
        self.cube.write_text(stl(CORNERS * (1.2, 16, 10), SIDES))
        crack = FROM_FILE + """
[[specimen.crack]]
center = ["0 mm", "0 mm", "5 mm"]
semi_axes = ["9 mm", "4 mm"]
normal = [0, 0, 1]"""
        for pull, has_forks in ((0.06, True), (0.02, False)):
            moved = "".join(f'[[boundary]]\non = "{face}"\ndisplacement = ["0 mm", "0 mm", "{sign}{pull} mm"]\n' for face, sign in (("z-min", "-"), ("z-max", "")))
            self.input.write_text(body(crack, spacing=0.4, poisson=0.35, strength=300, toughness=300, rest='release_speed = "1670 m/s"\n' + moved + """[time]
start = "equilibrium"
duration = "25 us"
integrator = "verlet"
[output]
branch_length = "3 mm"
"""))
            out = self.folder / f"out-{pull}"
            result = invoke("run", self.input, "-o", out)
            self.assertEqual(result.returncode, 0, result.stderr)
            ensemble = crackle.open(out)
            forks = [sample.forks for sample in ensemble]
            print(f"pulled apart by {pull} mm to both sides:", *(f"{len(one)} forks at y = {np.round(one.y * 1e3, 1).tolist()} mm, lengths "
                                                               f"{np.round(one.length * 1e3, 1).tolist()} mm;" for one in forks))
            self.assertEqual([bool(len(one)) for one in forks], [has_forks] * 2)
            self.assertEqual(ensemble.samples.bifurcations.tolist(), [len(one) for one in forks])
            self.assertEqual(ensemble.samples.long_bifurcations.tolist(), [(one.length >= 3e-3).sum() for one in forks])
            self.assertTrue(ensemble.samples.bifurcations_projected.isna().all())
            for one in forks:
                self.assertTrue(one.x.between(0, 1.2e-3).all() and one.y.between(4e-3, 16e-3).all() and one.length.gt(1e-3).all(), one)
                self.assertTrue(one.in_space.all() and not one.in_projection.any() and one.share.isna().all(), one)
            if has_forks and repetitions(False, True):
                there = self.folder / "on two ranks"
                self.input.write_text(self.input.read_text().replace("[ensemble]", "[ensemble]\nranks_per_sample = 2"))
                command = [*shlex.split(OPTIONS.mpirun), "-n", "3", os.path.abspath(OPTIONS.program), "run", self.input, "-o", there]
                subprocess.run([*map(str, command)], env=environment(), check=True, capture_output=True)
                self.assertTrue(results_of(there) == results_of(out))
            mean, share = np.mean([len(one) for one in forks]), 100.0 * has_forks
            self.assertRegex(invoke("stats", out).stdout, rf"\nbranching in space +{mean:.2f} +{share:.1f} ")

    def test_the_gallerys_files_are_what_their_script_writes(self):
        for name, bar in solid.FILES.items():
            self.assertEqual((ROOT / "jobs/gallery" / name).read_text(), solid.text(*bar(24)), name)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", required=True)
    parser.add_argument("--mpirun", required=True)
    parser.add_argument("--damaged", type=int, default=110, help="number of damaged files to try")
    OPTIONS, remaining = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0], *remaining])
