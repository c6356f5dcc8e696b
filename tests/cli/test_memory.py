#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The memory and the files that crackle check predicts against what a sample takes, and bodies for which there is not
enough memory."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

import h5py
import numpy as np

import survival_fixture
from survival_fixture import ROOT, environment, mpirun

FACTOR = 1.2  # within which the estimate holds


def setting(name, spacing=None, **values):
    """An input of jobs/ with another spacing, and a duration of a few steps."""
    text = (ROOT / "jobs" / name).read_text()
    values = {"duration": '"3 us"', "step": '"auto"', **values}
    if spacing:
        values["spacing"], values["notch_spacing"] = (f'"{length}"' for length in spacing)
    text = text.replace("[ensemble]", f"[ensemble]\nranks_per_sample = {values.pop('ranks_per_sample', 1)}")
    for key, value in values.items():
        text, n = re.subn(rf"(?m)^{key} = .*$", f"{key} = {value}", text)
        assert n == 1, key
    return text


def with_raster(text, file):
    """With a raster of 150 MB of ones over the demo's plate."""
    rows, columns = 15000, 10000
    with h5py.File(file, "w") as made:
        made["ones"] = np.ones((rows, columns), np.uint8)
    return text + f"""
[material.map]
file = "{file.name}"
dataset = "ones"
of = "stiffness"
axes = ["z", "y"]
origin = ["{70 / rows} mm", "{12.25 / columns} mm"]
spacing = ["{140 / rows} mm", "{24.5 / columns} mm"]
"""


def peaks(command):
    """Largest resident set of each rank of a command [byte], without the launcher's."""
    process = subprocess.Popen(command, env=environment(), stdout=subprocess.DEVNULL)
    found = {}
    while process.poll() is None:
        for entry in pathlib.Path("/proc").iterdir():
            try:
                if entry.name.isdigit() and os.readlink(entry / "exe") == survival_fixture.PROGRAM:
                    parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
                    if process.pid in (int(entry.name), parent):
                        found[entry.name] = 1024 * int(re.search(r"VmHWM:\s*(\d+)", (entry / "status").read_text())[1])
            except (OSError, TypeError, IndexError):
                continue  # has ended meanwhile
        try:
            process.wait(0.05)
        except subprocess.TimeoutExpired:
            pass
    assert process.returncode == 0, command
    return list(found.values())


class Memory(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="crackle-memory-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def call(self, *arguments):
        return subprocess.run([survival_fixture.PROGRAM, *map(str, arguments)], cwd=self.folder, text=True,
                              env=environment(), capture_output=True, check=False, timeout=300)

    def test_the_estimate_holds(self):
        for name, n_ranks, text in (
                ("demo", 1, setting("demo.toml")),
                ("demo, a raster", 1, with_raster(setting("demo.toml"), self.folder / "ones.h5")),
                ("between, many frames", 1, setting("demo.toml", ("1.6 mm", "0.5 mm"), frames=60, growth=0.05)),
                ("between, by PETSc", 1, setting("demo.toml", ("1.6 mm", "0.5 mm"), growth=0.05,
                                                 integrator='"bilateral4"\nengine = "petsc"')),
                ("between", 2, setting("demo.toml", ("1.6 mm", "0.5 mm"), growth=0.05, ranks_per_sample=2)),
                ("paper, with contact and a strength", 1,
                 setting("paper.toml", toughness='"57 J/m^2"\nstrength = "35 MPa"') + "\n[contact]\nfriction = 0.3\n")):
            with self.subTest(name, ranks=n_ranks):
                (self.folder / "plate.toml").write_text(text)
                check = self.call("check", "--no-measure", "plate.toml")
                estimate = 1e6 * float(re.search(r"memory +=  *(\d+) MB per sample", check.stdout)[1])
                found = peaks([*mpirun(n_ranks), survival_fixture.PROGRAM, "sample",
                               self.folder / "plate.toml", "--sample", "0", "-o", self.folder / f"{name}-{n_ranks}"])
                self.assertEqual(len(found), n_ranks)
                error = estimate / sum(found) - 1
                print(f"{name} on {n_ranks}: estimated {estimate / 1e6:.0f} MB, taken {sum(found) / 1e6:.0f} MB, "
                      f"error {100 * error:+.0f} %", flush=True)
                self.assertLess(estimate, FACTOR * sum(found))
                self.assertGreater(estimate, sum(found) / FACTOR)

    def test_the_size_of_the_output(self):
        """A sample of the demo, in its whole duration: the cracks count."""
        (self.folder / "plate.toml").write_text((ROOT / "jobs/demo.toml").read_text())
        check = self.call("check", "--no-measure", "plate.toml")
        output = re.search(r"(?m)^output += ([\d.]+) MB per sample, ([\d.]+) MB for 8 samples$", check.stdout)
        estimate, of_all = float(output[1]), float(output[2])
        self.assertGreater(of_all, 7.9 * estimate)
        result = self.call("sample", "plate.toml", "--sample", "2", "-o", "out")
        self.assertEqual(result.returncode, 0, result.stderr)
        size = (self.folder / "out/samples/0002.h5").stat().st_size / 1e6
        print(f"output of a sample: estimated {estimate:.2f} MB, written {size:.2f} MB", flush=True)
        self.assertLess(estimate, FACTOR * size)
        self.assertGreater(estimate, size / FACTOR)

    def test_check_says_what_does_not_fit_here(self):
        # All frames of a mesh that is soon made, terabytes, to be computed elsewhere.
        for n_ranks, whose in ((1, "a sample needs"), (8, "the 8 ranks of a sample need")):
            text = setting("demo.toml", ("0.8 mm", "0.5 mm"), frames=100000, ranks_per_sample=n_ranks)
            (self.folder / "plate.toml").write_text(text)
            result = self.call("check", "--no-measure", "plate.toml")
            self.assertEqual((result.returncode, result.stderr), (0, ""))
            estimate = float(re.search(r"memory +=  *(\d+) MB per sample", result.stdout)[1])
            warning = re.search(rf"\nWarning: .*memory: {whose} about ([\d.e+]+) GB, and [\d.]+ GB are available \(.*",
                                result.stdout)
            print(warning[0].strip(), flush=True)
            self.assertAlmostEqual(float(warning[1]), estimate / 1e3, delta=0.01 * float(warning[1]))
        (self.folder / "plate.toml").write_text(setting("demo.toml"))
        self.assertNotIn("Warning: cannot be computed on this machine", self.call("check", "--no-measure", "plate.toml").stdout)

    def test_what_cannot_fit_is_refused_before_anything_is_made(self):
        # All frames of a fine mesh, terabytes.
        for text in (setting("demo.toml", ("0.5 mm", "0.3 mm"), frames=100000),
                     setting("paper/clock-from-zero.toml", ("0.12 mm", "0.1 mm"), frames=100000)):
            (self.folder / "plate.toml").write_text(text)
            for command in (("sample", "--sample", "0", "-o", "out"), ("run", "-o", "out")):
                result = self.call(command[0], "plate.toml", *command[1:])
                self.assertEqual(result.returncode, 1, result.stdout + result.stderr)
                self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
                self.assertRegex(result.stderr, r"memory: .* needs about [\d.e+]+ GB, and [\d.]+ GB are available \(")
                self.assertFalse((self.folder / "out").exists())
            print(result.stderr.strip(), flush=True)
        many = subprocess.run([*mpirun(3), survival_fixture.PROGRAM, "run",
                               "plate.toml", "-o", "out"], cwd=self.folder, env=environment(), text=True,
                              capture_output=True, check=False, timeout=300)
        self.assertEqual(many.returncode, 1)
        self.assertEqual(many.stderr.count("crackle: memory: 3 ranks on "), 1, many.stderr)


if __name__ == "__main__":
    survival_fixture.main(__doc__)
