#!/usr/bin/python3
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

import command_lines  # noqa: E402
from crackle.files import SCHEMA_VERSIONS  # noqa: E402
from crackle_launch import environment  # noqa: E402
from effort import repetitions  # noqa: E402

OPTIONS = None
COMMANDS = ["init", "check", "mesh", "sample", "run", "watch", "stats", "compare", "match", "calibrate"]


def invoke(*arguments, ranks=0, cwd=None, stdin=None):
    """What a command line says, with `ranks` under mpirun, which gives standard input to rank 0."""
    return start(*arguments, ranks=ranks, cwd=cwd, stdin=stdin) if ranks else command_lines.crackle(OPTIONS.program, *arguments, cwd=cwd)


def start(*arguments, ranks=0, cwd=None, stdout=subprocess.PIPE, stdin=None):
    """The program itself."""
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
        self.assertRegex(result.stdout, rf"\nresults of model \d+, files of schema {SCHEMA_VERSIONS[-1]}\n$")
        for library in ("Open MPI", "PETSc", "METIS", "HDF5", "CGAL", "Eigen", "UDUNITS"):
            self.assertRegex(result.stdout, library + r" \d+\.\d+")

    def test_usage_errors(self):
        self.assert_usage_error(invoke("chek", OPTIONS.demo), 'there is no command "chek" (did you mean check?)')
        self.assert_usage_error(invoke(OPTIONS.demo), f'there is no command "{OPTIONS.demo}";')
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
                self.assert_usage_error(run(f"--part={part}"), f"'{part}' is not a part; give one such as 0/20")
            for part in ("3/3", "0/0", "7/3"):
                self.assert_usage_error(run("--part", part), f"there is no part {part}", "numbered from 0")
            self.assert_usage_error(run("--part", "0/3", "--samples", "0-1"), "--samples", "excludes", "--part")
            for ranks in (0, 2):
                result = run("--part", "0/10000", ranks=ranks)
                self.assertEqual((result.returncode, result.stdout), (1, ""))
                self.assertEqual(result.stderr.count("crackle: 10000 parts are more than ensemble.samples = "), 1,
                                 result.stderr)
            self.assertEqual(os.listdir(folder), [])
        self.assertIn("--part", invoke("run", "--help").stdout)

    def test_times(self):
        for option in ("--time-limit", "--checkpoint-interval"):
            for time in ("90", "90s", "0.5 h", "10m", "10 min", "2d", "0:01", "30:00", "00:10:00", "1-12", "1-12:30", "1-12:30:00"):
                result = invoke("run", "absent.toml", "-o", "out", option, time)
                self.assertIn("absent.toml: there is no such file", result.stderr, time)
            for time in ("0", "-1h", "00:00:00", "1:2:3:4", "1-2:3:4:5", "-1:00", "1:-1", "1:2x", "a:b", "1:", ":1", "1-", "8 hours",
                         "8h30m", "nan", "inf", "1e999"):
                result = invoke("run", OPTIONS.demo, "-o", "out", f"{option}={time}")
                self.assert_usage_error(result, option, f"'{time}' is not a time above 0", "30min", "8:00:00 (H:MM:SS)")

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

    def test_the_list_of_keys_has_every_key_of_the_demo(self):
        result = invoke("check", "--keys")
        self.assertEqual(result.returncode, 0)
        table = None
        keys = {}
        for line in filter(None, result.stdout.splitlines()):
            self.assertRegex(line, r"^(\*\*`\[.*\]`\*\*.*: .|- `[\w.]+`(, `[\w.]+`)* \(.+\): .+; .|- `\w.+ \(as in `.+`\)$)")
            names = re.findall(r"`\[*([^\]`]*)\]*`", line.split(" (")[0])
            if line.startswith("**"):
                table = names[0]
            else:
                keys.setdefault(table, []).extend(names)
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
                        r"memory +=  *\d+ MB", r"output += [\d.]+ MB per sample, [\d.]+ MB for 8 samples\n",
                        r"wave speeds += c_d 2288 m/s, c_s 1007 m/s, c_R 945\.6 m/s\n",
                        r"transit times += 61\.19 us along the length .*, 24\.34 us across the width",
                        r"arrest window += 83\.72 us", r"\ncore-hours +=  *[\d.e-]+ for 8 samples, with 2 dynamic phases each\n",
                        r"quasi-static part += [\d.e-]+ s: [\d.e-]+ s for the first equilibrium, [\d.e-]+ s for each of 4 "):
            self.assertRegex(result.stdout, pattern)
        self.assertEqual(result.stderr, "")
        least, median, greatest = map(float, re.search(
            r"toughness += min ([\d.]+), median ([\d.]+), max ([\d.]+) J/m\^2", result.stdout).groups())
        self.assertLess(least, median)
        self.assertLess(median, greatest)
        phase, step, rate = map(float, re.search(
            r"dynamic phase += ([\d.e+-]+) s for .*: ([\d.e+-]+) ms per step, ([\d.e+-]+) million tetrahedron updates",
            result.stdout).groups())
        steps, forces, tetrahedra = (int(re.search(rf"(?m)^{name} += (\d+)", result.stdout)[1])
                                     for name in ("steps", "force evaluations", "tetrahedra"))
        self.assertGreater(1.02 * phase, 1e-3 * step * steps)  # the phase has a start besides
        self.assertAlmostEqual(rate * 1e6 * 1e-3 * step / (tetrahedra * forces / steps), 1, delta=0.02)
        sample = float(re.search(r"(?m)^sample += ([\d.e+-]+) s", result.stdout)[1])
        hours = float(re.search(r"core-hours += ([\d.e-]+)", result.stdout)[1])
        self.assertAlmostEqual(8 * sample / 3600 / hours, 1, delta=0.02)
        self.assertGreater(sample, phase)

    def check(self, *arguments, **values):
        """The rows of `crackle check` for the demo with other values."""
        text = re.sub("(?m)^nucleation = .*\n", "", pathlib.Path(OPTIONS.demo).read_text())
        for key, value in {"spacing": '"5 mm"', "notch_spacing": '"1.5 mm"', **values}.items():
            text, n_replaced = re.subn(rf"(?m)^{key} = .*$", value if "=" in value else f"{key} = {value}", text)
            self.assertEqual(n_replaced, 1, key)
        with tempfile.TemporaryDirectory(prefix="crackle-cli-") as folder:
            (pathlib.Path(folder) / "plate.toml").write_text(text)
            result = invoke("check", "plate.toml", *arguments, cwd=folder)
        self.assertEqual((result.returncode, re.sub(r".* s so far\n", "", result.stderr)), (0, ""))
        rows = result.stdout.split("The mesh of sample 0", 1)[1]
        return dict(re.findall(r"(?m)^([\w -]+?) += (.*)$", rows)), rows

    def test_check_with_other_numbers_of_phases(self):
        rows, _ = self.check("--phases", "4")
        self.assertRegex(rows["core-hours"], "with 4 dynamic phases each")
        self.assertRegex(rows["sample"], "with 4 dynamic phases, of which 3 arrest$")
        rows, _ = self.check("--phases", "1")
        self.assertRegex(rows["core-hours"], "with 1 dynamic phase each$")

    def test_check_says_that_cracks_between_moved_grips_arrest(self):
        rows, _ = self.check(force='displacement = ["free", "free", "0 mm"]', rate='["0 mm/s", "0 mm/s", "0.01 mm/s"]')
        self.assertRegex(rows["core-hours"], r"with 2 dynamic phases each; up to [\d.e-]+ with 10: growing cracks relieve .* \(--phases\)$")
        self.assertRegex(rows["sample"], r"with 2 dynamic phases, of which 1 arrests; up to [\d.]+ \w+ with 10$")

    def test_check_of_a_body_that_starts_at_rest(self):
        rows, _ = self.check(start='"rest"')
        self.assertNotIn("quasi-static part", rows)
        self.assertRegex(rows["core-hours"], "with 1 dynamic phase each")
        self.assertRegex(rows["arrest window"], "none")

    def test_check_says_where_the_strength_has_no_effect(self):
        for strength, share in (("1 MPa", "100"), ("500 MPa", None)):
            rows, _ = self.check("--no-measure", strength=f'strength = "{strength}"\ntoughness = "100 J/m^2"\nnucleation = "own-stress"')
            self.assertEqual(re.findall(r"; in (\d+) % of the tetrahedra the strength at cracks is higher and holds everywhere", rows["strength"]),
                             [share] if share else [], rows["strength"])

    def test_check_says_that_no_load_breaks_the_body(self):
        rows, _ = self.check(rate='["0 N/s", "0 N/s", "0 N/s"]')
        self.assertRegex(rows["sample"], "the loads never break the body")
        self.assertRegex(rows["core-hours"], "with 0 dynamic phases each")

    def test_check_warns_of_locking(self):
        _, text = self.check("--no-measure", poisson_ratio="0.46")
        self.assertRegex(text, r"(?m)^Warning: at Poisson's ratio 0\.46 linear tetrahedra lock: .*; use a material\.poisson_ratio of at most 0\.4$")
        _, text = self.check("--no-measure", poisson_ratio="0.4")
        self.assertNotIn("lock", text)

    def test_check_without_measuring(self):
        rows, text = self.check("--no-measure", strength='toughness = "100 J/m^2"')
        self.assertNotIn("core-hours", rows)
        self.assertNotIn("dynamic phase", rows)
        self.assertIn("Not measured: the load of the first break, time and core-hours.", text)
        least, median, greatest = map(float, re.fullmatch(
            r"min ([\d.]+), median ([\d.]+), max ([\d.]+) MPa, from the toughness and the local spacing",
            rows["strength"]).groups())
        self.assertLess(least, median)
        self.assertLess(median, greatest)
        self.assertNotIn("toughness", rows)
        self.assert_usage_error(invoke("check", OPTIONS.demo, "--no-measure", "--ranks", "4"))

    def test_plans_reckon_with_what_was_measured(self):
        rows, text = self.check("--ranks", "5")
        plan = re.search(r"(?m)^ +1 +4 +(\d+) +\d+ MB +- +([\d.]+) s +100 % +([\d.]+) s$", text)
        self.assertEqual(plan[1], rows["tetrahedra"].split()[0])
        sample, alone, ensemble = float(rows["sample"].split()[0]), float(plan[2]), float(plan[3])
        self.assertLess(alone, 1.1 * sample)  # the mesh is not the group's; both are measured
        self.assertGreater(alone, 0.7 * sample)
        self.assertAlmostEqual(ensemble / alone, 2, delta=0.5)  # two rounds of four
        self.assertRegex(text, r"(?m)^recommended: ensemble\.ranks_per_sample = [124]$")
        self.assertRegex(text, r"(?m)^Plans for 5 ranks and 8 samples, on cores as this one with messages of 2 us and 1 GB/s per rank:$")
        shared = re.search(r"(?m)^ +4 +1 +(\d+) +(\d+) MB +(\d+) MB +([\d.]+) s +(\d+) % ", text)
        self.assertGreater(4 * int(shared[1]), int(plan[1]))
        self.assertGreater(int(shared[2]), int(shared[3]))
        self.assertLess(int(shared[5]), 100 * int(plan[1]) / (4 * int(shared[1])) + 1)

    def test_a_mesh_of_many_million_tetrahedra_is_not_made(self):
        """It is estimated from a coarser one: 20 million, and 100 million under tools/check --full."""
        spacing = repetitions(0.18, 0.105)  # [mm]
        rows, text = self.check("--no-measure", spacing=f'"{spacing} mm"', notch_spacing=f'"{spacing} mm"', step='"auto"')
        self.assertIn("takes minutes or more to make", text)
        n = float(rows["tetrahedra"].removeprefix("about "))
        self.assertAlmostEqual(n * (spacing / 0.105)**3, 1e8, delta=2e7)
        n_coarse, factor = re.match(r"from a mesh of (\d+) tetrahedra, with ([\d.]+) times the spacings; --samples 1 makes",
                                    rows["estimated"]).groups()
        self.assertAlmostEqual(float(factor), (n / int(n_coarse)) ** (1 / 3), delta=0.15 * float(factor))
        step = float(re.fullmatch(r"about ([\d.]+) ns", rows["stable step"])[1])
        self.assertGreater(step, 5)
        self.assertLess(step, 40)
        memory = float(rows["memory"].split()[0]) / (n / 1e6)
        self.assertGreater(memory, 400)
        self.assertLess(memory, 600)

    def test_step_over_the_stable_one_is_refused(self):
        with tempfile.TemporaryDirectory(prefix="crackle-cli-") as folder:
            text = re.sub(r"(?m)^step = .*$", 'step = "50 us"', pathlib.Path(OPTIONS.demo).read_text())
            (pathlib.Path(folder) / "long_step.toml").write_text(text)
            result = invoke("check", "long_step.toml", cwd=folder)
        self.assertEqual(result.returncode, 1)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        self.assertRegex(result.stderr, r"long_step\.toml: time\.step: .* exceeds the stable step.* [\d.]+ ns")

    def test_the_root_alone_reads_the_input(self):
        demo = pathlib.Path(OPTIONS.demo).read_text()
        result = invoke("check", "--no-measure", "/dev/stdin", ranks=2, stdin=demo)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        result = invoke("check", "--no-measure", "/dev/stdin", ranks=2, stdin=demo + "frmes = 3\n")
        self.assertEqual(result.returncode, 1)
        self.assertEqual(result.stderr.count("output.frmes"), 1, result.stderr)

    def test_init_writes_inputs_to_start_from(self):
        with tempfile.TemporaryDirectory() as folder:
            for source in ([], ["--from", "paper"], ["--from", "offset-notch"]):
                name = f"{source[-1] if source else 'template'}.toml"
                result = invoke("init", name, *source, cwd=folder)
                self.assertEqual((result.returncode, result.stderr), (0, ""))
                self.assertIn(f"crackle check {name} ", result.stdout)
                if source[1:] != ["paper"]:  # which is large
                    checked = invoke("check", "--no-measure", name, cwd=folder)
                    self.assertEqual(checked.returncode, 0, checked.stderr)
            jobs = pathlib.Path(OPTIONS.demo).parent
            self.assertEqual((pathlib.Path(folder) / "paper.toml").read_bytes(), (jobs / "paper.toml").read_bytes())
            self.assert_usage_error(invoke("init", "other.toml", "--from", "nothing", cwd=folder), "nothing", "demo", "ring")
            # A file that is there is not replaced, and what cannot be written is one message.
            again = invoke("init", "paper.toml", "--from", "demo", ranks=2, cwd=folder)
            self.assertEqual((again.returncode, again.stdout), (1, ""))
            self.assertEqual(again.stderr.count("crackle: paper.toml already exists; give another name\n"), 1)
            self.assertEqual((pathlib.Path(folder) / "paper.toml").read_bytes(), (jobs / "paper.toml").read_bytes())
            nowhere = invoke("init", "paper.toml/new.toml", cwd=folder)
            self.assertEqual(nowhere.returncode, 1)
            self.assertRegex(nowhere.stderr, r"\Acrackle: .*paper\.toml.*\n\Z")

    def test_full_output_device_is_an_error(self):
        if not os.path.exists("/dev/full"):
            self.skipTest("no /dev/full")
        with open("/dev/full", "w") as full:
            result = start("check", "--keys", stdout=full)
        self.assertEqual(result.returncode, 1)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)

    def test_petscrc_is_not_read(self):
        with tempfile.TemporaryDirectory(prefix="crackle-cli-") as folder:
            (pathlib.Path(folder) / ".petscrc").write_text("-help\n-log_view\n")
            result = start("run", "absent.toml", "-o", "out", cwd=folder)
        self.assertEqual((result.returncode, result.stdout), (1, ""))
        self.assertEqual(result.stderr, "absent.toml: there is no such file; give an input file in TOML\n")


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    parser.add_argument("--demo", required=True)
    parser.add_argument("--mpirun", default="mpirun")
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
