#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What README.md shows is what the program does."""
from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "cli"), str(ROOT / "tools")]

from crackle_launch import environment  # noqa: E402
from synthetic_ensemble import write_ensemble  # noqa: E402

TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
PROGRAM = ""


def run_program(*arguments: str) -> subprocess.CompletedProcess:
    return subprocess.run([PROGRAM, *arguments], env=environment(), capture_output=True, text=True, check=False)


class Readme(unittest.TestCase):
    maxDiff = None

    def test_the_table_of_keys_is_the_programs(self):
        (table,) = re.findall(r"<!-- keys:begin -->\n(.*?)<!-- keys:end -->", TEXT, re.DOTALL)
        result = run_program("check", "--keys")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(table, result.stdout)

    def test_the_table_of_results_is_the_programs(self):
        (table,) = re.findall(r"<!-- results:begin -->\n(.*?)<!-- results:end -->", TEXT, re.DOTALL)
        result = run_program("stats", "--columns")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(table, result.stdout)

    def test_the_input_example_is_valid(self):
        (example,) = re.findall(r"```toml\n(.*?)```", TEXT, re.DOTALL)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "plate.toml"
            file.write_text(example, encoding="utf-8")
            result = run_program("check", str(file))
        self.assertEqual((result.returncode, result.stderr), (0, ""))

    def test_every_command_shown_exists(self):
        commands = set(re.findall(r"`(?:mpirun -n \d+ )?crackle (\w+) ", TEXT))
        self.assertEqual(commands, {"check", "mesh", "sample", "run", "stats"})
        for command in commands:
            usage = run_program(command, "--help")
            self.assertEqual(usage.returncode, 0, command)
            for line in re.findall(rf"`[^`]*crackle {command} [^`]*`", TEXT):
                for option in re.findall(r"(?<!\S)(--?[a-z]+)", line.split(f"crackle {command}")[1]):
                    self.assertRegex(usage.stdout, rf"(?<![\w-]){option}\b", f"{command} {option}")

    def test_the_python_example_runs(self):
        (example,) = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
        with tempfile.TemporaryDirectory() as folder:
            write_ensemble(Path(folder) / "out" / "demo", 6, failed=(1,))
            result = subprocess.run(["/usr/bin/python3", "-c", example + "print(z.shape)"], check=False,
                                    capture_output=True, text=True, cwd=folder)
        self.assertEqual((result.stdout, result.stderr), ("(5, 2, 5)\n", ""))

    def test_the_tables_of_results_are_what_a_run_leaves(self):
        (example,) = re.findall(r"```toml\n(.*?)```", TEXT, re.DOTALL)
        for key, value in (("samples", "2"), ("spacing", '"5 mm"'), ("notch_spacing", '"1.5 mm"'),
                           ("duration", '"2 us"')):
            example, n_replaced = re.subn(rf"(?m)^{key} = \S+( \S+\")?", f"{key} = {value}", example)
            self.assertEqual(n_replaced, 1, key)
        lengths = {"N": 2, "K": 2, "S": 5, "Y": 5, "4": 4, "5": 5, "3": 3}
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "out"
            (Path(name) / "plate.toml").write_text(example, encoding="utf-8")
            result = run_program("run", str(Path(name) / "plate.toml"), "-o", str(folder))
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
            with h5py.File(folder / "ensemble.h5") as root:
                lengths["M"] = root["mother_points/spacing"].size
                described = set()
                for names, shape in re.findall(r"(?m)^\| (`/\w+/.*?) \| ([NKSYM345 ×]+|group) \|", TEXT):
                    group = names.split("/")[1]
                    for dataset in re.findall(r"`([^`]*)`", names):
                        path = dataset if dataset.startswith("/") else f"/{group}/{dataset}"
                        described.add(path)
                        if shape == "group":
                            self.assertIsInstance(root[path], h5py.Group, path)
                            continue
                        self.assertEqual(root[path].shape, tuple(lengths[n] for n in shape.split(" × ")), path)
                stored = {f"/{group}/{dataset}" for group in ("samples", "crack_path", "statistics", "mother_points")
                          for dataset in root[group]}
                self.assertEqual(stored, described)
            with h5py.File(folder / "samples" / "0001.h5") as root:
                groups = re.findall(r"(?m)^\| `/(\w+)` \|", TEXT)
                self.assertEqual(set(root), {*groups, "timing", "provenance"})
            report = subprocess.run([ROOT / "tools" / "crackle-report", folder], capture_output=True, text=True,
                                    env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}, check=False)
            self.assertEqual((report.returncode, report.stderr), (0, ""))
            self.assertIn("2 of 2", (folder / "report.html").read_text(encoding="utf-8"))

    def test_the_table_of_faults_has_commands_that_exist(self):
        rows = re.findall(r"(?m)^\| .* \| `([^`]*)` \|$", TEXT.split("## What an ensemble survives")[1].split("\n## ")[0])
        self.assertGreater(len(rows), 10)
        listed = subprocess.run(["ctest", "--test-dir", Path(PROGRAM).parents[1], "-N"], capture_output=True, text=True,
                                check=True).stdout
        for command in rows:
            program, *arguments = command.split()
            if program == "ctest":
                self.assertRegex(listed, rf"Test +#\d+: .*{arguments[1]}", command)
            else:
                self.assertTrue(os.access(ROOT / program, os.X_OK), command)

    def test_the_number_of_wrong_inputs(self):
        result = subprocess.run([sys.executable, "-B", ROOT / "tests/cli/test_wrong_inputs.py", "--program", PROGRAM,
                                 "--demo", ROOT / "jobs/demo.toml", "--count"], capture_output=True, text=True, check=True)
        self.assertIn(f"| {result.stdout.strip()} | all refused | `ctest -R cli.wrong_inputs` |", TEXT)

    def test_files_linked_to_are_there(self):
        links = re.findall(r"\]\(([^)#]+)\)", TEXT)
        self.assertIn("jobs/README.md", links)
        for link in links:
            self.assertTrue((ROOT / link).exists(), link)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    options, rest = parser.parse_known_args()
    PROGRAM = os.environ["CRACKLE"] = os.path.abspath(options.program)
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
