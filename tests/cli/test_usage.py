#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line itself: help, version, usage errors, one message on any number of ranks."""
import argparse
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))

from crackle_launch import environment  # noqa: E402

OPTIONS = None
COMMANDS = ["check", "mesh", "sample", "run", "stats"]


def invoke(*arguments, ranks=0, cwd=None, stdout=subprocess.PIPE, stdin=None):
    """Runs the program; with `ranks` under mpirun, which gives standard input to rank 0."""
    command = [os.path.abspath(OPTIONS.program), *arguments]
    if ranks:
        command = [*shlex.split(OPTIONS.mpirun), "-n", str(ranks), *command]
    return subprocess.run(command, cwd=cwd, env=environment(), timeout=300, check=False, stdout=stdout,
                          input=stdin, stderr=subprocess.PIPE, text=True)


class Usage(unittest.TestCase):
    def assert_usage_error(self, result, *parts):
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertEqual(result.stdout, "")
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        for part in ("crackle: ", "--help", *parts):
            self.assertIn(part, result.stderr)

    def test_no_arguments_print_the_help(self):
        result = invoke()
        self.assertEqual(result.returncode, 1)
        for command in COMMANDS:
            self.assertIn(command, result.stdout)

    def test_help_at_every_level(self):
        for arguments in ([], *([command] for command in COMMANDS)):
            for flag in ("--help", "-h"):
                result = invoke(*arguments, flag)
                self.assertEqual(result.returncode, 0, arguments)
                self.assertEqual(result.stderr, "")
                self.assertIn("Usage: crackle " + " ".join(arguments), result.stdout)

    def test_version_names_commit_and_libraries(self):
        result = invoke("--version")
        self.assertEqual(result.returncode, 0)
        self.assertRegex(result.stdout, r"^crackle \d+\.\d+\.\d+\n")
        self.assertRegex(result.stdout, r"\ngit commit ([0-9a-f]{40}(-dirty)?|unknown)\n")
        for library in ("Open MPI", "PETSc", "METIS", "HDF5", "CGAL", "Eigen", "UDUNITS"):
            self.assertRegex(result.stdout, library + r" \d+\.\d+")

    def test_usage_errors(self):
        self.assert_usage_error(invoke("chekc", OPTIONS.demo), "chekc")
        self.assert_usage_error(invoke("check"), "crackle check --help")
        self.assert_usage_error(invoke("check", "--keys", OPTIONS.demo), "crackle check --help")
        self.assert_usage_error(invoke("check", OPTIONS.demo, "another.toml"), "another.toml")
        self.assert_usage_error(invoke("check", "--frobnicate", OPTIONS.demo), "--frobnicate")
        self.assert_usage_error(invoke("--frobnicate"), "crackle --help")

    def test_overwriting_and_going_on_exclude_each_other(self):
        for option in ("--resume", "--retry-failed"):
            result = invoke("sample", OPTIONS.demo, "--sample", "0", "-o", "out", "--overwrite", option)
            self.assert_usage_error(result, "--overwrite", "excludes", option)

    def test_parts_of_the_samples(self):
        with tempfile.TemporaryDirectory(prefix="crackle-cli-") as folder:
            def run(*arguments, ranks=0):
                return invoke("run", os.path.abspath(OPTIONS.demo), "-o", "out", *arguments, cwd=folder, ranks=ranks)

            for part in ("3", "3/", "/3", "-1/3", "0x1/3", "1/3/5", "1 /3", "a/b", "1.0/3", "99999999999999999999/3"):
                self.assert_usage_error(run(f"--part={part}"), f"'{part}' is no part; give one such as 0/20")
            for part in ("3/3", "0/0", "7/3"):
                self.assert_usage_error(run("--part", part), f"there is no part {part}", "numbered from 0")
            self.assert_usage_error(run("--part", "0/3", "--samples", "0-1"), "--samples", "excludes", "--part")
            for ranks in (0, 2):
                result = run("--part", "0/10000", ranks=ranks)
                self.assertEqual((result.returncode, result.stdout), (1, ""))
                self.assertEqual(result.stderr.count("crackle: there are no 10000 parts: ensemble.samples = "), 1,
                                 result.stderr)
            self.assertEqual(os.listdir(folder), [])
        self.assertIn("--part", invoke("run", "--help").stdout)

    def test_one_message_from_many_ranks(self):
        with tempfile.TemporaryDirectory(prefix="crackle-cli-") as folder:
            text = pathlib.Path(OPTIONS.demo).read_text() + "frmes = 3\n"
            (pathlib.Path(folder) / "bad.toml").write_text(text)
            result = invoke("check", "bad.toml", ranks=3, cwd=folder)
            self.assertEqual(result.returncode, 1)
            self.assertEqual(result.stderr.count("output.frmes"), 1, result.stderr)
            self.assertEqual(os.listdir(folder), ["bad.toml"])
        result = invoke("check", "--frobnicate", ranks=3)
        self.assertEqual(result.returncode, 1)
        self.assertEqual(result.stderr.count("--frobnicate"), 1, result.stderr)
        result = invoke("--version", ranks=3)
        self.assertEqual(result.returncode, 0)
        self.assertEqual(result.stdout.count("git commit"), 1)

    def test_key_table_has_every_key_of_the_demo(self):
        result = invoke("check", "--keys")
        self.assertEqual(result.returncode, 0)
        rows = [line for line in result.stdout.splitlines() if line.startswith("|")]
        self.assertTrue(all(row.count("|") == 6 for row in rows))
        table = None
        keys = {}
        for row in rows[2:]:
            name = re.search(r"`\[*([^\]`]*)\]*`", row).group(1)
            if row.startswith("| **"):
                table = name
            else:
                keys.setdefault(table, []).append(name)
        for line in pathlib.Path(OPTIONS.demo).read_text().splitlines():
            line = line.split("#")[0].strip()
            if line.startswith("["):
                table = line.strip("[]")
                self.assertIn(table, keys)
            elif "=" in line:
                self.assertIn(line.split("=")[0].strip(), keys[table])

    def test_check_prints_the_resolved_input_and_the_estimate(self):
        with tempfile.TemporaryDirectory(prefix="crackle-cli-") as folder:
            result = invoke("check", os.path.abspath(OPTIONS.demo), cwd=folder)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(os.listdir(folder), [])
        for pattern in (r"mesh\.spacing +=", r"mesh\.growth +=", r"time\.arrest += auto",
                        r"nodes +=  *\d+", r"tetrahedra +=  *\d+", r"stable step +=  *[\d.]+ ns",
                        r"time step +=  *[\d.]+ ns", r"steps +=  *\d+", r"force evaluations +=  *\d+",
                        r"memory +=  *\d+ MB", r"core-hours +=  *[\d.e-]+"):
            self.assertRegex(result.stdout, pattern)

    def test_step_over_the_stable_one_is_refused(self):
        with tempfile.TemporaryDirectory(prefix="crackle-cli-") as folder:
            text = re.sub(r"(?m)^step = .*$", 'step = "50 us"', pathlib.Path(OPTIONS.demo).read_text())
            (pathlib.Path(folder) / "long_step.toml").write_text(text)
            result = invoke("check", "long_step.toml", cwd=folder)
        self.assertEqual(result.returncode, 1)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        self.assertRegex(result.stderr, r"long_step\.toml: time\.step: .* above the stable step.* [\d.]+ ns")

    def test_the_root_alone_reads_the_input(self):
        demo = pathlib.Path(OPTIONS.demo).read_text()
        result = invoke("check", "/dev/stdin", ranks=2, stdin=demo)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        result = invoke("check", "/dev/stdin", ranks=2, stdin=demo + "frmes = 3\n")
        self.assertEqual(result.returncode, 1)
        self.assertEqual(result.stderr.count("output.frmes"), 1, result.stderr)

    def test_full_output_device_is_an_error(self):
        if not os.path.exists("/dev/full"):
            self.skipTest("no /dev/full")
        with open("/dev/full", "w") as full:
            result = invoke("check", "--keys", stdout=full)
        self.assertEqual(result.returncode, 1)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)

    def test_petscrc_is_not_read(self):
        with tempfile.TemporaryDirectory(prefix="crackle-cli-") as folder:
            (pathlib.Path(folder) / ".petscrc").write_text("-help\n-log_view\n")
            result = invoke("check", "--keys", cwd=folder)
        self.assertEqual(result.returncode, 0)
        self.assertEqual(result.stderr, "")
        self.assertTrue(all(line.startswith("|") for line in result.stdout.splitlines()), result.stdout)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    parser.add_argument("--demo", required=True)
    parser.add_argument("--mpirun", default="mpirun")
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
