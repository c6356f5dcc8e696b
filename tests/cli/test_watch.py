#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of `crackle watch`: while an ensemble runs, when it has ended, and in folders that hold none."""
from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools")]

import command_lines  # noqa: E402
from crackle_launch import environment  # noqa: E402
from synthetic_ensemble import changed  # noqa: E402

PROGRAM = Path()


def state(folder: Path) -> dict:
    return {str(file): (file.stat().st_mtime_ns, file.stat().st_size) for file in folder.rglob("*")}


class Watch(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name) / "out"
        text = (ROOT / "tests" / "support" / "plate.toml").read_text()
        self.input = Path(temporary.name) / "plate.toml"
        self.input.write_text(text.replace("samples = 6", "samples = 3").replace('"20 ns"', '"8 ns"'))

    def watch(self, *arguments: str) -> subprocess.CompletedProcess:
        return command_lines.crackle(PROGRAM, "watch", self.folder, *arguments)

    def test_it_follows_a_run_to_its_end_and_reads_only(self):
        with subprocess.Popen([str(PROGRAM), "run", str(self.input), "-o", str(self.folder)], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, env=environment()) as run:
            until = time.monotonic() + 120
            while not list(self.folder.glob("samples/*.h5")) and time.monotonic() < until:
                time.sleep(0.05)
            running = self.watch("--once")
            followed = self.watch("--interval", "0.2")
            log = run.communicate()[0]
            self.assertEqual(run.returncode, 0, log)
        self.assertEqual(running.returncode, 0, running.stderr)
        self.assertRegex(running.stdout, rf"active: process {run.pid} on ")
        self.assertRegex(running.stdout, r"[12] done, 0 failed, [12] pending of 3")
        self.assertIn("3 of 3 samples to compute", running.stdout)
        self.assertEqual(followed.returncode, 0, followed.stderr)
        pictures = followed.stdout.split(f"{self.folder}: ")
        self.assertGreater(len(pictures), 2, "it looked once only")
        self.assertRegex(pictures[-1], r"^3 done, 0 failed, 0 pending of 3\nno run is active here\n")
        rows = re.findall(r"(?m)^ +(\d) +done +([\d.]+) ", pictures[-1])
        self.assertEqual([number for number, _ in rows], ["0", "1", "2"])
        for number, force in rows:
            self.assertIn(f"sample {number} done: separated, onset {float(force):.1f} N", log)
        self.assertIn("pictures and report: tools/crackle-report", pictures[-1])
        self.assertEqual(log.splitlines()[-1], (self.folder / "run.log").read_text().splitlines()[-1])

        before = state(self.folder)
        self.assertEqual(self.watch().returncode, 0, "it ends by itself")
        self.assertEqual(state(self.folder), before)

        # As if sample 1 had arrested and its load had risen until the loading ended.
        with changed(self.folder / "samples" / "0001.h5") as root:
            for name, value in {"outcome": 1, "held": 1, "onset_force": 100, "peak_load": 510}.items():
                root["summary"][name][()] = value
        self.assertRegex(self.watch("--once").stdout, r"(?m)^ +1 +done +> 510\.000 +> 510\.000 ")

    def test_it_ends_with_an_ensemble_that_needs_no_more_samples(self):
        stopped = self.input.read_text() + '\n[ensemble.stop]\nhalf_width = "1 m"\nmin_samples = 2\n'
        self.input.write_text(stopped)
        run = command_lines.crackle(PROGRAM, "run", self.input, "-o", self.folder)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        # As a killed run leaves it, on a host that is not asked whether the process lives.
        lock = self.folder / "lock-0-2"
        lock.write_text("process 1 on elsewhere\n")
        os.utime(lock, (time.time() - 3600,) * 2)
        watched = self.watch()
        self.assertEqual(watched.returncode, 0, watched.stderr)
        self.assertTrue(watched.stdout.startswith(f"{self.folder}: 2 done, 0 failed, 0 pending of 2\n"
                                                  "stopped early: these samples suffice, 3 were planned\nno run is active here\n"), watched.stdout)

    def test_of_no_ensemble_it_says_so(self):
        done = self.watch("--once")
        self.assertEqual(done.returncode, 1)
        self.assertIn("is not the folder of an ensemble", done.stderr)
        self.assertFalse(self.folder.exists())


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=Path, required=True)
    options, rest = parser.parse_known_args()
    PROGRAM = options.program.resolve()
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
