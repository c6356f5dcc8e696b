#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Command lines in one process are those of the program, whatever came before: one real start of each command, and what must not leak."""
from __future__ import annotations

import argparse
import os
import re
import signal
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools")]

import command_lines  # noqa: E402
import small_input  # noqa: E402
from crackle_launch import environment  # noqa: E402

PROGRAM = Path()


def comparable(text: str) -> str:
    """Without what two runs of the program may print differently: times, speeds and free memory."""
    return re.sub(r"[\d.]+(e[+-]\d+)? (s|ms|min|h|GB|MB|element updates)\b|core-hours.*|dynamic phase +=.*|^sample +=.*|\"wall_time\":[^]]*", "#", text, flags=re.MULTILINE)


class CommandLines(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = Path(temporary.name)
        (cls.folder / "loads.csv").write_text("peak_load_N\n150\n160\n")
        (cls.folder / "loads.toml").write_text('loads = "loads.csv"\n')
        (cls.folder / "plate.toml").write_text(small_input.small_input(small_input.RANDOM, samples=8))
        (cls.folder / "wrong.toml").write_text("[mesh\n")

    def here(self, *words: str, **variables: str) -> subprocess.CompletedProcess:
        return command_lines.crackle(PROGRAM, *words, cwd=self.folder, **variables)

    def start(self, *words: str) -> subprocess.CompletedProcess:
        return subprocess.run([PROGRAM, *words], cwd=self.folder, env=environment(), capture_output=True, text=True, check=False,
                              timeout=command_lines.TIMEOUT)

    def test_each_command_says_what_the_program_says(self):
        """Faults lie between the command lines that work, since a fault is what might leave something behind."""
        lines = (("run", "plate.toml", "-o", "{}"), ("run", "wrong.toml", "-o", "none"), ("run", "plate.toml", "-o", "{}"),
                 ("sample", "plate.toml", "--sample", "1", "-o", "{}-alone"), ("sample", "plate.toml"), ("check", "plate.toml"),
                 ("check", "--no-measure", "wrong.toml"), ("mesh", "plate.toml", "--sample", "1", "-o", "{}.vtkhdf"),
                 ("stats", "nowhere"), ("stats", "{}"), ("stats", "--json", "{}"), ("compare", "{}", "{}"), ("compare", "{}"),
                 ("match", "{}", "loads.toml"), ("match", "{}", "none.toml"), ("calibrate", "{}", "loads.toml"), ("watch", "--once", "{}"),
                 ("init", "{}.toml"), ("init", "{}.toml"), ("nonsense",), ("--help",), ("--version",), ())
        statuses = set()
        for line in lines:
            with self.subTest(line):
                outcomes = []
                for name, call in (("in-one", self.here), ("of-own", self.start)):
                    found = call(*(word.format(name) for word in line))
                    outcomes.append((found.returncode, *(comparable(text.replace(name, "out")) for text in (found.stdout, found.stderr))))
                self.assertEqual(*outcomes)
                statuses.add((line[:1], outcomes[0][0]))
        self.assertLessEqual({((command,), 0) for command in ("run", "sample", "check", "mesh", "stats", "compare", "match", "calibrate",
                                                             "watch", "init")}, statuses)

    def test_nothing_is_left_of_a_command_line(self):
        usual = self.here("--version")
        driver = command_lines._drivers[PROGRAM]
        whole, driver.folder = driver.folder, self.folder / "full"
        driver.folder.mkdir()
        (driver.folder / "out").symlink_to("/dev/full")
        self.assertEqual(driver.answer(["--version"], self.folder, {}, 60), 1, "standard output cannot be written")
        driver.folder = whole
        again = self.here("--version")
        self.assertEqual((again.returncode, again.stdout, again.stderr), (0, usual.stdout, ""))
        suspended = self.here("run", "plate.toml", "-o", "no-time", SLURM_JOB_END_TIME="1")
        self.assertEqual(suspended.returncode, 3, suspended.stderr)
        self.assertEqual(self.here("run", "plate.toml", "-o", "no-time", "--resume").returncode, 0)

    def test_a_driver_that_dies_tells_what_was_said(self):
        pid = command_lines._drivers[PROGRAM].process.pid if self.here("--version").returncode == 0 else 0
        killer = subprocess.Popen(["sh", "-c", f"sleep 1; kill -KILL {pid}"])
        (self.folder / "slow.toml").write_text((ROOT / "tests/support/plate.toml").read_text().replace("20 ns", "1 ns"))
        killed = self.here("run", "slow.toml", "-o", "killed")
        killer.wait()
        self.assertEqual(killed.returncode, -signal.SIGKILL)
        self.assertIn("6 of 6 samples to compute", killed.stdout)
        self.assertEqual(self.here("--version").returncode, 0, "another driver goes on")


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=os.path.abspath, required=True)
    options, rest = parser.parse_known_args()
    PROGRAM = Path(options.program)
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
