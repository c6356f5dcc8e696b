#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the READMEs show is what the program does, and their links lead somewhere."""
from __future__ import annotations

import argparse
import functools
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

import command_lines  # noqa: E402
from crackle_readme import BLOCKS, block, put_block, tests_with_keys  # noqa: E402
from synthetic_ensemble import write_ensemble  # noqa: E402

PROGRAM = ""
FRONT_PAGE_WORDS, HAND_WRITTEN_WORDS = 700, 11_000


@functools.cache
def pages() -> dict[str, str]:
    """Every page of the project, by its path from the root."""
    found = {}
    for folder, folders, files in os.walk(ROOT):
        folders[:] = [name for name in folders if not name.startswith((".", "build")) and name != "out"]
        for file in (Path(folder) / name for name in files if name.endswith(".md")):
            found[str(file.relative_to(ROOT))] = file.read_text(encoding="utf-8")
    return found


def hand_written(text: str) -> str:
    """A page without what programs print into it."""
    return re.sub(r"<!-- ([a-z-]+):begin -->.*?<!-- \1:end -->", "", text, flags=re.DOTALL)


def fenced(page: str, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", pages()[page], re.DOTALL)


def anchors(text: str) -> set[str]:
    """Of its headings, as GitHub makes them."""
    titles = re.findall(r"(?m)^#+ (.*)$", re.sub(r"```.*?```", "", text, flags=re.DOTALL))
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def dangling_links(page: str, text: str) -> list[str]:
    """Relative links of a page that lead to no file, or to no heading of a page."""
    found = []
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        if re.match(r"[a-z]+:", link):
            continue
        path, _, anchor = link.partition("#")
        target = (ROOT / page).parent / path if path else ROOT / page
        if not target.exists() or (anchor and anchor not in anchors(target.read_text(encoding="utf-8"))):
            found.append(f"{page}: {link}")
    return found


def run_program(*arguments: str) -> subprocess.CompletedProcess:
    return command_lines.crackle(PROGRAM, *arguments)


class Readme(unittest.TestCase):
    maxDiff = None

    def test_the_pages_are_short(self):
        self.assertLessEqual(len(pages()["README.md"].split()), FRONT_PAGE_WORDS)
        self.assertEqual(hand_written("a <!-- keys:begin --> b <!-- keys:end --> c"), "a  c")
        self.assertLessEqual(sum(len(hand_written(text).split()) for text in pages().values()), HAND_WRITTEN_WORDS)

    def test_every_link_leads_somewhere(self):
        self.assertEqual([link for page, text in pages().items() for link in dangling_links(page, text)], [])
        self.assertEqual(dangling_links("README.md", "[a](nowhere.md), [b](src/README.md#nothing), [c](#limits), "
                                        "[d](https://example.org/x), ![e](jobs/images/none.png)"),
                         ["README.md: nowhere.md", "README.md: src/README.md#nothing", "README.md: jobs/images/none.png"])

    def test_every_page_is_linked_to(self):
        linked = {os.path.normpath(Path(page).parent / link) for page, text in pages().items()
                  for link in re.findall(r"\]\(([^)#\s]+)", text)}
        unlinked = [page for page in pages() if page != "README.md" and not {page, str(Path(page).parent)} & linked]
        self.assertEqual(unlinked, [])

    def test_what_programs_print_stands_where_the_list_says(self):
        marked = {(name, page) for page, text in pages().items() for name in re.findall(r"<!-- ([\w -]+):begin -->", text)}
        self.assertEqual(marked, set(BLOCKS.items()))
        for name in BLOCKS:
            self.assertNotEqual(block(name), "", name)

    def test_a_block_is_replaced_and_nothing_else(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "README.md"
            file.write_text("a\n<!-- ranks:begin -->\nold\n<!-- ranks:end -->\nb\n", encoding="utf-8")
            put_block("ranks", "new \\1\n", file)
            self.assertEqual(file.read_text(encoding="utf-8"), "a\n<!-- ranks:begin -->\nnew \\1\n<!-- ranks:end -->\nb\n")
            for text in ("nothing\n", 2 * file.read_text(encoding="utf-8")):
                file.write_text(text, encoding="utf-8")
                with self.assertRaises(ValueError):
                    put_block("ranks", "new\n", file)
                self.assertEqual(file.read_text(encoding="utf-8"), text)

    def test_the_list_of_keys_is_the_programs(self):
        result = run_program("check", "--keys")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(block("keys"), result.stdout)

    def test_the_table_of_results_is_the_programs(self):
        result = run_program("stats", "--columns")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(block("results"), result.stdout)

    def test_the_keys_of_usual_tests_are_the_inputs(self):
        self.assertEqual(block("tests"), tests_with_keys())

    def test_the_inputs_shown_are_valid(self):
        examples = [(page, example) for page in pages() for example in fenced(page, "toml")]
        self.assertIn("README.md", {page for page, _ in examples})
        for page, example in examples:
            with self.subTest(page), tempfile.TemporaryDirectory() as folder:
                file = Path(folder) / "plate.toml"
                file.write_text(example, encoding="utf-8")
                result = run_program("check", "--no-measure", str(file))
                self.assertEqual((result.returncode, result.stderr), (0, ""))
        (minimal,) = fenced("README.md", "toml")
        self.assertEqual(len(minimal.splitlines()), 10)

    def test_every_command_shown_exists(self):
        text = "\n".join(pages().values())
        commands = set(re.findall(r"`(?:mpirun -n \d+ )?(?:build/bin/)?crackle (\w+) ", text))
        self.assertEqual(commands, {"init", "check", "mesh", "sample", "run", "watch", "stats", "compare", "match", "calibrate"})
        for command in commands:
            usage = run_program(command, "--help")
            self.assertEqual(usage.returncode, 0, command)
            for line in re.findall(rf"`[^`\n]*crackle {command} [^`\n]*`", text):
                for option in re.findall(r"(?<!\S)(--?[a-z]+)", line.split(f"crackle {command}")[1]):
                    self.assertRegex(usage.stdout, rf"(?<![\w-]){option}\b", f"{command} {option}")

    def test_one_version_everywhere(self):
        found = {file: re.search(pattern, (ROOT / file).read_text(), re.MULTILINE)[1] for file, pattern in (
            ("CMakeLists.txt", r"project\(crackle VERSION ([\d.]+)"), ("CITATION.cff", r"^version: (.+)$"),
            ("tools/pyproject.toml", r'^version = "(.+)"$'), ("tools/crackle/__init__.py", r'^__version__ = "(.+)"$'))}
        self.assertEqual(len(set(found.values())), 1, found)

    def test_every_tool_shown_exists(self):
        for page, text in pages().items():
            for tool in re.findall(r"(?<![\w/])tools/[\w-]+(?:\.\w+)?(?:/[\w.-]+)*", text):
                self.assertTrue((ROOT / tool).exists(), f"{page}: {tool}")

    def test_the_python_example_runs(self):
        (example,) = fenced("jobs/results.md", "python")
        with tempfile.TemporaryDirectory() as folder:
            write_ensemble(Path(folder) / "out" / "demo", 6, failed=(1,))
            result = subprocess.run(["/usr/bin/python3", "-c", example + "print(z.shape)"], check=False,
                                    capture_output=True, text=True, cwd=folder)
        self.assertEqual((result.stdout, result.stderr), ("(5, 2, 5)\n", ""))

    def test_the_tables_of_results_are_what_a_run_leaves(self):
        example = (ROOT / "jobs" / "demo.toml").read_text(encoding="utf-8")
        text = pages()["jobs/results.md"]
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
                for names, shape in re.findall(r"(?m)^\| (`/\w+/.*?) \| ([NKSYM345 ×]+|group) \|", text):
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
                groups = re.findall(r"(?m)^\| `/(\w+)` \|", text)
                self.assertEqual(set(root), {*groups, "timing", "provenance"})
            report = subprocess.run([ROOT / "tools" / "crackle-report", folder, "--no-animation", "--no-fringes"], capture_output=True, text=True,
                                    env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}, check=False)
            self.assertEqual((report.returncode, report.stderr), (0, ""))
            self.assertIn("2 of 2", (folder / "report.html").read_text(encoding="utf-8"))

    def test_the_table_of_faults_has_commands_that_exist(self):
        text = pages()["jobs/clusters.md"].split("## What an ensemble survives")[1].split("\n## ")[0]
        rows = re.findall(r"(?m)^\| .* \| `([^`]*)` \|$", text)
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
        self.assertIn(f"| {result.stdout.strip()} | all refused | `ctest -R cli.wrong_inputs` |",
                      pages()["jobs/clusters.md"])


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    options, rest = parser.parse_known_args()
    PROGRAM = os.environ["CRACKLE"] = os.path.abspath(options.program)
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
