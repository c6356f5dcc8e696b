#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Commands that compute on one process, where MPI cannot start, as on many login nodes."""
from __future__ import annotations

import argparse
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "cli")]

import small_input  # noqa: E402
from command_lines import with_server  # noqa: E402
from crackle_launch import environment  # noqa: E402
from effort import repetitions  # noqa: E402

PROGRAM, MPIRUN = Path(), ""
# Open MPI finds no component of this name, and ends the program.
BROKEN = {"OMPI_MCA_pml": "none-such"}


def content(file: Path) -> dict[str, object]:
    """Everything in an HDF5 file but where and by how many ranks it was written."""
    found: dict[str, object] = {}

    def add(name: str, thing: h5py.HLObject) -> None:
        if name == "provenance":
            return
        for key, value in thing.attrs.items():
            if key not in ("DIMENSION_LIST", "REFERENCE_LIST"):
                found[f"{name}@{key}"] = np.asarray(value).tobytes() if np.asarray(value).dtype != object else str(value)
        if isinstance(thing, h5py.Dataset):
            values = thing[...]
            found[name] = values.tobytes() if values.dtype != object else values.tolist()

    with h5py.File(file) as root:
        add("/", root)
        root.visititems(add)
    return found


class WithoutMpi(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.root = Path(temporary.name)
        cls.out = small_input.run(PROGRAM, small_input.small_input(small_input.RANDOM, samples=8), cls.root / "out")
        cls.input = cls.root / "out.toml"
        (cls.root / "loads.csv").write_text("peak_load_N\n150\n160\n")
        (cls.root / "loads.toml").write_text('loads = "loads.csv"\n')

    def call(self, *arguments, launcher=(), **settings) -> subprocess.CompletedProcess:
        return subprocess.run([*launcher, PROGRAM, *map(str, arguments)], cwd=self.root, env=environment(**with_server(), **settings),
                              capture_output=True, text=True, check=False, timeout=300)

    def test_they_print_what_several_ranks_do(self):
        broken = self.call("sample", self.input, "--sample", "0", "-o", self.root / "none", **BROKEN)
        self.assertNotEqual(broken.returncode, 0)
        self.assertIn("none-such", broken.stderr)
        commands = (["--version"], ["--help"], ["run", "--help"], ["stats", "--columns"], ["check", "--keys"],
                    ["check", "--no-measure", self.input], ["stats", "--read-only", self.out], ["stats", self.out, "--json"],
                    ["stats", "--sections", "y=6 mm", self.out], ["compare", self.out, self.out],
                    ["match", self.out, "loads.toml"], *repetitions((), (["match", self.out, "--held-out", "each"],)),
                    ["calibrate", self.out, "loads.toml"], ["watch", "--once", self.out], ["mesh", self.input, "--sample", "1", "-o", "mesh.vtkhdf"])
        for arguments in commands:
            with self.subTest(arguments=arguments):
                found = self.call(*arguments, **BROKEN)
                self.assertEqual(found.returncode, 0, found.stderr)
                if "--help" in arguments or "--keys" in arguments:  # texts, as --version is
                    continue
                if arguments[0] in repetitions(("match", "calibrate"), ()):  # in Python on the first rank, as "compare" is
                    continue
                usual = self.call(*arguments, launcher=(*shlex.split(MPIRUN), "-n", "2"))
                self.assertEqual(usual.returncode, 0, usual.stderr)
                if arguments[0] not in ("mesh", "watch") and "--no-measure" not in arguments:  # which show times and free memory
                    self.assertEqual(found.stdout, usual.stdout)
        self.assertEqual(self.call("init", "new.toml", **BROKEN).returncode, 0)
        self.assertEqual(self.call("init", "experiments.toml", "--from-ensemble", self.out, **BROKEN).returncode, 0)

    def test_wrong_inputs_are_refused(self):
        (self.root / "wrong.toml").write_text(self.input.read_text() + "nonsense = 1\n")
        for arguments in (["check", "wrong.toml"], ["stats", self.root / "nowhere"], ["stats"], ["nonsense"]):
            found = self.call(*arguments, **BROKEN)
            self.assertEqual((found.returncode, found.stdout), (1, ""))
            self.assertEqual(found.stderr.count("\n"), 1, found.stderr)

    def test_results_have_the_bits_of_several_ranks(self):
        found = []
        for launcher, settings in (((), BROKEN), ((*shlex.split(MPIRUN), "-n", "3"), {})):
            folder = self.root / f"of-{len(found)}"
            shutil.copytree(self.out, folder)
            (folder / "ensemble.h5").unlink()
            done = self.call("stats", folder, launcher=launcher, **settings)
            self.assertEqual(done.returncode, 0, done.stderr)
            found.append(content(folder / "ensemble.h5"))
        self.assertGreater(len(found[0]), 100)
        self.assertEqual(found[0], found[1])
        self.assertEqual(found[0], content(self.out / "ensemble.h5"))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=Path, required=True)
    parser.add_argument("--mpirun", required=True)
    options, rest = parser.parse_known_args()
    PROGRAM, MPIRUN = options.program.resolve(), options.mpirun
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
