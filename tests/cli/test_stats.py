#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""crackle stats on a small ensemble: finished, unfinished, with files that do not belong to it."""
import argparse
import contextlib
import json
import os
import pathlib
import re
import shlex
import shutil
import socket
import subprocess
import sys
import tempfile
import unittest

import h5py
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "cli")]

import command_lines  # noqa: E402
import crackle  # noqa: E402
import in_process  # noqa: E402
from crackle_launch import environment  # noqa: E402
from crackle_report import reading  # noqa: E402
from synthetic_ensemble import seal  # noqa: E402

RANKS = ("leader", "leader/one_crack", "leader/two_cracks", "follower")
OPTIONS = None
INPUT = (ROOT / "tests/support/plate.toml").read_text()
for old, new in (("samples = 6", "samples = 3"), ('step = "20 ns"', 'step = "auto"'), ('"60 us"', '"20 us"'), ("frames = 4", "frames = 2"),
                 ("[time]", '[time]\nstart = "quasi-static"')):
    assert old in INPUT
    INPUT = INPUT.replace(old, new)


def invoke(*arguments, ranks=0):
    if not ranks:
        return command_lines.crackle(OPTIONS.program, *arguments)
    command = [*shlex.split(OPTIONS.mpirun), "-n", str(ranks), os.path.abspath(OPTIONS.program), *map(str, arguments)]
    result = subprocess.run(command, env=environment(), timeout=300, check=False, capture_output=True, text=True)
    # Without mpirun's own notice of a rank that ended with another status than 0.
    result.stderr = re.sub(r"(?s)-{20,}\n.*?-{20,}\n", "", result.stderr)
    return result


def content(file):
    """Everything in a file that must not differ between two runs."""
    found = {}

    def add(name, thing):
        if name.split("/")[0] in ("timing", "provenance"):
            return
        found.update({f"{name}@{key}": str(value) for key, value in thing.attrs.items()})
        if isinstance(thing, h5py.Dataset):
            values = thing[...]
            found[name] = values.tolist() if values.dtype == object else values.tobytes()

    with h5py.File(file) as root:
        root.visititems(add)
        found.update({f"@{key}": str(value) for key, value in root.attrs.items()})
    return found


@contextlib.contextmanager
def opened(file, sealed=True):
    """The file for a change; `sealed` gives it a check sum that fits the change."""
    with h5py.File(file, "r+") as root:
        yield root
    if sealed:
        seal(file)


class Stats(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.parent = tempfile.TemporaryDirectory(prefix="crackle-stats-")
        cls.finished = pathlib.Path(cls.parent.name) / "finished"
        setting = pathlib.Path(cls.parent.name) / "plate.toml"
        setting.write_text(INPUT)
        result = invoke("run", setting, "-o", cls.finished)
        assert result.returncode == 0, result.stdout + result.stderr
        cls.log = result.stdout

    @classmethod
    def tearDownClass(cls):
        cls.parent.cleanup()

    def setUp(self):
        self.folder = pathlib.Path(self.parent.name) / "copy"
        shutil.rmtree(self.folder, ignore_errors=True)
        shutil.copytree(self.finished, self.folder)
        self.sample = self.folder / "samples" / "0001.h5"

    def stats(self):
        result = invoke("stats", self.folder)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(sorted(entry.name for entry in self.folder.glob("*")),
                         [name for name in ("ensemble.h5", "input.toml", "run.log", "samples")
                          if name != "input.toml" or (self.folder / name).exists()])
        return result.stdout

    def assert_refused(self, reason):
        """Sample 1 counts as left, for this reason."""
        self.assertRegex(self.stats(), rf"(?s)3 samples: 2 done, 0 failed, 1 pending.*pending sample 1: .*{reason}")
        with h5py.File(self.folder / "ensemble.h5") as root:
            self.assertEqual(root["samples/status"][...].tolist(), [1, 0, 1])

    def test_it_writes_the_file_of_the_run(self):
        (self.folder / "ensemble.h5").unlink()  # on any number of ranks: cli.without_mpi
        self.assertIn("3 samples: 3 done, 0 failed, 0 pending\n", self.stats())
        self.assertEqual(content(self.folder / "ensemble.h5"), content(self.finished / "ensemble.h5"))

    def test_table_shows_what_the_file_holds(self):
        text = self.stats()
        with h5py.File(self.folder / "ensemble.h5") as root:
            mean, reached = root["statistics/z_mean"][0, 0], root["statistics/reached"][0, 0]
            onset = root["samples/onset_force"][...]
            counts = {label: root["samples"][name][...]
                      for label, name in (("branching projected", "bifurcations_projected"), ("kinks", "kinks"))}
        for label, of_samples in counts.items():
            self.assertRegex(text, rf"\n{label} +{of_samples.mean():.2f} +{100 * (of_samples > 0).mean():.1f} +[0-9.]+ to [0-9.]+\n")
        self.assertRegex(text, rf"\nleader +notch 0 +notch 0 +y = 3 mm +z +{reached} +{mean * 1e3:.3f} ")
        median = re.search(r"\nonset force \[N\] +\S+ +\S+ +(\S+) +\S+ +\S+ +3 +too few samples\n", text)[1]
        # As many digits as the scatter deserves.
        self.assertAlmostEqual(float(median), np.median(onset), delta=np.ptp(onset) / 190)
        self.assertLess(len(median), len(f"{np.median(onset):.3f}"))
        self.assertRegex(text, r"\nleading crack start: notch 0 in \d samples?")
        self.assertRegex(text, r"\ntraced area \[mm\^2\] ")

    def test_what_the_master_merged_is_what_the_files_say(self):
        text = self.stats()
        mean = re.search(r"\nleader +notch 0 +notch 0 +y = 3 mm +z +\d+ +(\S+) ", text)[1]
        with h5py.File(self.folder / "ensemble.h5") as root:
            median = np.median(root["samples/onset_force"][...])
        self.assertIn(f"\nmean z of leading cracks at y = 3 mm: {mean} mm, median onset {median:.3f} N\n", self.log)

    def test_ranks_shares_and_the_scope_of_intervals_are_in_the_file(self):
        text = self.stats()
        with h5py.File(self.folder / "ensemble.h5") as root:
            group = root["statistics"]
            self.assertIn(group.attrs["interval_scope"], text)
            leading = root["samples/leading_notch"][...]
            z = root["crack_path/z"][...]
            self.assertEqual(group["leader/notch"][...].tolist(), [0])
            self.assertEqual(group["follower/notch"].shape, (0,))
            self.assertEqual(group["leader/running_mean"].shape, (3, 1, 2))
            np.testing.assert_array_equal(group["leader/counted"][0], [np.count_nonzero(leading == 0)] * 2)
            np.testing.assert_allclose(group["leader/z_mean"][0], np.nanmean(z[leading == 0, 0], axis=0), rtol=1e-14)
            lower, upper = group["pattern_lower"][...], group["pattern_upper"][...]
            share, width = group["pattern_share"][...], group["pattern_half_width"][...]
            np.testing.assert_allclose(upper - lower, 2 * width, rtol=1e-12)
            self.assertTrue(((lower <= share) & (share <= upper)).all())
            one = [f"{100 * values[1]:.1f}" for values in (share, lower, upper)]
        self.assertRegex(text, rf"\none crack +{one[0]} +{one[1]} to {one[2]}\n")
        ensemble = reading.read_ensemble(self.folder)
        for i in ensemble.done:
            self.assertEqual(ensemble.files.branching(i).in_space.sum(), ensemble.samples.bifurcations[i])

    def assert_json_is_what_the_files_hold(self, document, folder):
        """@return the names of the members of groups, which are datasets of the files"""
        compared = set()
        with h5py.File(folder / "ensemble.h5") as root, h5py.File(folder / "samples" / "0000.h5") as sample:
            for group in ("samples", "crack_path", "specimen", "statistics", *RANKS):
                members = document["statistics"][group] if group in RANKS else document[group]
                for name, dataset in root[f"statistics/{group}" if group in RANKS else group].items():
                    if isinstance(dataset, h5py.Group) or name == "z":
                        continue
                    if h5py.check_string_dtype(dataset.dtype):
                        self.assertEqual(members[name], [text.decode() for text in dataset[...]])
                    else:
                        expected = dataset[...]
                        found = np.array(members[name], expected.dtype).reshape(expected.shape)
                        np.testing.assert_array_equal(found, expected, f"{group}/{name}")
                    compared.add(f"{group}/{name}")
            for name, dataset in sample["specimen"].items():
                np.testing.assert_array_equal(dataset.asstr() if dataset.dtype.kind == "O" else dataset, document["specimen"][name])
            attributes = root["statistics"].attrs
            for name in ("confidence", "interval_scope", "n_looks"):
                self.assertEqual(document["statistics"][name], attributes[name])
            self.assertEqual(document["n_needed"], attributes["n_needed"])
        return compared

    def test_json_is_one_document_with_all_that_the_files_hold(self):
        result = invoke("stats", self.folder, "--json")
        self.assertEqual((result.returncode, result.stderr, result.stdout.count("\n")), (0, "", 1))
        document = json.loads(result.stdout)
        compared = self.assert_json_is_what_the_files_hold(document, self.folder)
        self.assertGreater(len(compared), 70)
        self.assertEqual([document[name] for name in ("n_samples", "n_needed", "n_done", "n_failed", "n_left")], [3, 3, 3, 0, 0])
        self.assertEqual(document["input"], INPUT)
        self.assertEqual((document["notes"], document["warnings"]), ([], []))
        self.assertEqual(document["crack_path"]["section_name"], ["y = 3 mm", "y = 4 mm"])
        # The quantiles are those of the text, the units those that say so.
        text = self.stats()
        for result in document["results"]:
            is_place = result["name"] in ("first_break_x", "first_break_y", "first_break_z")  # without notches only
            if "quantiles" in result and not is_place:
                label = re.escape(result["label"] + (f" [{result['shown_units']}]" if result["shown_units"] else ""))
                shown = " +".join(re.escape(format(value * result["shown_factor"], result["format"])) for value in result["quantiles"])
                self.assertRegex(text, rf"\n{label} +{shown} +3 +too few samples\n")
            if "counts" in result:
                for word, count in zip(result["categories"], result["counts"]):
                    self.assertRegex(text, rf"\n{word} +{count}\n")
            if "share" in result:
                numbers = (100 * result[name] for name in ("share", "lower", "upper"))
                self.assertRegex(text, "\n{} +{:.2f} +{:.1f} +{:.1f} to {:.1f}\n".format(result["label"], result["mean"], *numbers))

    def test_json_at_other_sections(self):
        result = invoke("stats", self.folder, "--json", "--sections", "y=2.5 mm, 4 mm")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        found, own = json.loads(result.stdout), json.loads(invoke("stats", self.folder, "--json").stdout)
        self.assertEqual(found["notes"], ["crossings computed again from the sample files; ensemble.h5 is not changed"])
        self.assertEqual(found["crack_path"]["section"], [0.0025, 0.004])
        self.assertEqual(found["statistics"]["leader"]["z_mean"][0][1], own["statistics"]["leader"]["z_mean"][0][1])
        self.assertEqual(found["samples"], own["samples"])

    def test_a_line_measures_from_its_start(self):
        # Along y = 4 mm, from its other end; a part of it that the crack misses; and a slanted one.
        lines = ("4 mm, 15 mm; 4 mm, 1 mm", "4 mm, 1 mm; 4 mm, 2 mm", "3 mm, 1 mm; 5 mm, 15 mm")
        options = [option for line in lines for option in ("--sections", f"line={line}")]
        result = invoke("stats", self.folder, "--json", "--sections", "y=4 mm", *options)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        found = json.loads(result.stdout)["crack_path"]
        self.assertEqual(found["section_axis"], [1, 0, 0, 0])
        self.assertEqual(found["section_coordinate"], ["z"] + 3 * ["distance"])
        self.assertEqual(found["section_line"][0], [[0.004, 0.015], [0.004, 0.001]])
        position = np.array(found["position"], float)[:, 0]
        self.assertTrue(np.isfinite(position[:, 0]).any())
        np.testing.assert_allclose(position[:, 1], 0.015 - position[:, 0], atol=1e-12)
        self.assertTrue(np.isnan(position[:, 2]).all())
        self.assertEqual(np.array(found["branches"])[:, 0, 2].tolist(), [0, 0, 0])
        self.assertTrue(np.isfinite(position[:, 3]).any())
        text = invoke("stats", self.folder, *options).stdout
        self.assertRegex(text, r"\nleader +notch 0 +notch 0 +line from \(4 mm, 15 mm\) to \(4 mm, 1 mm\) +distance +\d+ +\d+\.\d{3} ")

    def test_read_only_leaves_everything_as_it_is(self):
        self.sample.unlink()
        before = {file: (file.stat().st_mtime_ns, file.read_bytes()) for file in self.folder.rglob("*.*")}
        # ensemble.h5 still has the row of the sample whose file is gone; without it there are two.
        for expected in ("3 samples: 3 done", "3 samples: 2 done"):
            result = invoke("stats", self.folder, "--read-only")
            self.assertEqual((result.returncode, result.stderr), (0, ""))
            self.assertIn(expected, result.stdout)
            self.assertEqual({file: (file.stat().st_mtime_ns, file.read_bytes()) for file in self.folder.rglob("*.*")}, before)
            (self.folder / "ensemble.h5").unlink(missing_ok=True)
            before = {file: content for file, content in before.items() if file.exists()}
        result = invoke("stats", "--columns", "--json")
        self.assertEqual((result.returncode, result.stdout), (1, ""))

    def test_samples_without_an_ensemble_are_shown(self):
        """What crackle sample leaves has no copy of the input."""
        for name in ("ensemble.h5", "input.toml", "samples/0002.h5"):
            (self.folder / name).unlink()
        result = invoke("stats", self.folder)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertIn("3 samples: 2 done, 0 failed, 1 pending", result.stdout)
        self.assertEqual(sorted(file.name for file in self.folder.iterdir()), ["run.log", "samples"])

    def test_more_samples_than_the_input_has_are_refused(self):
        given = self.folder / "input.toml"
        given.write_text(given.read_text().replace("samples = 3", "samples = 2"))
        result = invoke("stats", "--read-only", self.folder)
        self.assertEqual((result.returncode, result.stdout), (1, ""))
        self.assertIn(f"{self.folder / 'ensemble.h5'} holds 3 samples, but ensemble.samples of {given} is 2; give at least 3 there", result.stderr)

    def test_an_ensemble_that_stopped_early_stays_as_it_is(self):
        setting = pathlib.Path(self.parent.name) / "stop.toml"
        setting.write_text(INPUT.replace("samples = 3", "samples = 9").replace(
            "[specimen]", '[ensemble.stop]\nhalf_width = "100 mm"\nmin_samples = 2\n[specimen]'))
        shutil.rmtree(self.folder)
        for ranks in (3, 1):
            stopped = self.folder.with_name(f"stopped-{ranks}")
            result = invoke("run", setting, "-o", stopped, ranks=ranks)
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
            self.assertIn("stopped early: samples 0 to 1 suffice, 9 were planned\n", result.stdout)
            self.assertEqual(sorted(file.name for file in (stopped / "samples").iterdir()), ["0000.h5", "0001.h5"])
        before = content(stopped / "ensemble.h5")
        document = json.loads(invoke("stats", stopped, "--json", "--read-only").stdout)
        self.assert_json_is_what_the_files_hold(document, stopped)
        self.assertEqual((document["n_samples"], document["n_needed"], document["statistics"]["looks"]), (9, 2, [2, 3, 5, 8, 9]))
        self.assertEqual(before, content(self.folder.with_name("stopped-3") / "ensemble.h5"))
        # A sample that was under way when the run was killed does not count either.
        shutil.copy(self.finished / "samples" / "0002.h5", stopped / "samples" / "0002.h5")
        result = invoke("stats", stopped)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("2 samples: 2 done, 0 failed, 0 pending\nstopped early: these samples suffice, 9 were planned\n", result.stdout)
        self.assertEqual(before, content(stopped / "ensemble.h5"))
        # It is another run's, which does not take away what it has not computed.
        result = invoke("run", setting, "-o", stopped, "--resume")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertIn("6 of 9 samples to compute", result.stdout)
        self.assertTrue((stopped / "samples" / "0002.h5").is_file())
        # At a section that no crack reaches the rule would ask for more samples; they are the ensemble all the same.
        result = invoke("stats", stopped, "--sections", "y=7.95 mm")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertIn("2 samples: 2 done, 0 failed, 0 pending\nstopped early: these samples suffice, 9 were planned\n", result.stdout)

    def test_other_sections_are_as_if_the_ensemble_had_been_run_with_them(self):
        setting, other = (pathlib.Path(self.parent.name) / name for name in ("other.toml", "other"))
        setting.write_text(INPUT.replace('["3 mm", "4 mm"]', '["2.5 mm", "4 mm", "6 mm"]'))
        result = invoke("run", setting, "-o", other)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        expected = invoke("stats", other).stdout
        self.assertRegex(expected, r"\nleader +notch 0 +notch 0 +y = 2\.5 mm +z +3 ")
        before = {file: file.read_bytes() for file in self.folder.rglob("*.*")}
        for ranks in (0, 4):
            result = invoke("stats", self.folder, "--sections", "y=2.5 mm, 4 mm", "--sections", "y=0.6 cm", ranks=ranks)
            self.assertEqual((result.returncode, result.stderr), (0, ""))
            note, table = result.stdout.split("\n\n", 1)
            self.assertEqual(note, "crossings computed again from the sample files; ensemble.h5 is not changed")
            self.assertEqual(table, expected)
            self.assertEqual({file: file.read_bytes() for file in self.folder.rglob("*.*")}, before)

    def test_other_sections_of_files_of_an_older_version(self):
        expected = self.older().stdout
        result = invoke("stats", self.folder, "--sections", "y=3 mm, 4 mm")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertEqual(result.stdout.split("\n\n", 1)[1], expected)

    def test_other_sections_of_unfinished_ensembles(self):
        self.sample.write_bytes(b"no sample")
        result = invoke("stats", self.folder, "--sections", "y=3 mm", ranks=2)
        self.assertRegex(result.stdout, "(?s)3 samples: 2 done, 0 failed, 1 pending.*pending sample 1: .*no checksum at its end")
        shutil.rmtree(self.folder / "samples")
        for ranks in (0, 2):
            result = invoke("stats", self.folder, "--sections", "y=3 mm", ranks=ranks)
            self.assertEqual((result.returncode, result.stdout), (1, ""))
            self.assertEqual(result.stderr, f"crackle: '{self.folder}' holds no sample files, from which crossings at other "
                             "sections are computed; ensemble.h5 has only its own sections\n")

    def test_wrong_sections_are_refused(self):
        for given, reason in (("y=1 mm", r"sections.y\[0\]: no crack can reach 1 mm; .*between 2 mm and 8 mm"),
                              ("y=3 mm,3 kg", r"sections.y\[1\]: \"3 kg\" does not have the dimension of a length"),
                              ("y=4 mm,3 mm", r"sections.y\[1\]: 3 mm is not above 4 mm"),
                              ("z=9 mm", r"sections.z: no crack can reach them, since no notch is cut into a z-face"),
                              ("x=1 mm", r"\"x=1 mm\" is not known"), ("3 mm", r"\"3 mm\" is not known")):
            for ranks in (0, 2) if given == "y=1 mm" else (0,):
                result = invoke("stats", self.folder, "--sections", given, ranks=ranks)
                self.assertEqual((result.returncode, result.stdout), (1, ""))
                self.assertRegex(result.stderr, f"^--sections: {reason}")
                self.assertEqual(len(result.stderr.splitlines()), 1)
        result = invoke("stats", "--columns", "--sections", "y=3 mm")
        self.assertEqual((result.returncode, result.stdout), (1, ""))

    def test_notches_in_z_faces_have_sections_across_z(self):
        text = INPUT.replace("samples = 3", "samples = 1").replace('"8 mm", "16 mm"', '"16 mm", "8 mm"')
        for old, new in (('"y-min"', '"z-min"'), ('on = "z-min"', 'on = "y-min"'), ('on = "z-max"', 'on = "y-max"'),
                         ('"0 N", "100 N"', '"100 N", "0 N"'), ('"0 N/s", "5 N/s"', '"5 N/s", "0 N/s"'),
                         ('"quasi-static"', '"equilibrium"'), ('"20 us"', '"40 us"'),
                         ('y = ["3 mm", "4 mm"]', 'z = ["3 mm", "4 mm"]')):
            self.assertIn(old, text)
            text = text.replace(old, new, 1)
        setting, out = (pathlib.Path(self.parent.name) / name for name in ("along-z.toml", "along-z"))
        setting.write_text(text)
        result = invoke("run", setting, "-o", out)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        with h5py.File(out / "ensemble.h5") as root, h5py.File(out / "samples" / "0000.h5") as sample:
            paths = root["crack_path"]
            self.assertEqual(paths["section_axis"][...].tolist(), [2, 2])
            self.assertEqual(paths["section_axis"].attrs["categories"], "1 y, 2 z")
            self.assertEqual(paths["z"].shape, (1, 1, 0))
            position = paths["position"][0, 0]
            self.assertEqual(position.tobytes(), sample["summary/position"][0].tobytes())
            self.assertTrue(np.all(np.abs(position - 7e-3) < 2e-3), position)  # near the notch's plane
        result = invoke("stats", out)
        self.assertRegex(result.stdout, rf"\nleader +notch 0 +notch 0 +z = 3 mm +y +1 +{position[0] * 1e3:.3f} ")
        again = invoke("stats", out, "--sections", "z=3 mm, 4 mm")
        self.assertEqual((again.returncode, again.stderr), (0, ""))
        self.assertEqual(again.stdout.split("\n\n", 1)[1], result.stdout)

    def test_samples_that_are_missing_are_left(self):
        self.sample.unlink()
        self.assertIn("3 samples: 2 done, 0 failed, 1 pending\n", self.stats())
        with h5py.File(self.folder / "ensemble.h5") as root, h5py.File(self.finished / "ensemble.h5") as whole:
            self.assertEqual(root["samples/status"][...].tolist(), [1, 0, 1])
            z = whole["crack_path/z"][...][[0, 2]]
            np.testing.assert_allclose(root["statistics/z_mean"][0, 0], z[:, 0, 0].mean(), rtol=1e-15)

    def test_rows_of_files_that_were_moved_away_stay(self):
        whole = self.stats()
        self.sample.unlink()
        copy = self.folder / "input.toml"
        copy.write_text("# Comments do not matter.\n" + copy.read_text())
        for ranks in (0, 3):
            result = invoke("stats", "--keep-rows", self.folder, ranks=ranks)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(result.stdout, whole)
            with h5py.File(self.folder / "ensemble.h5") as root, h5py.File(self.finished / "ensemble.h5") as before:
                names = []
                before.visititems(lambda name, one: names.append(name) if isinstance(one, h5py.Dataset) else None)
                names = [name for name in names if name.split("/")[0] in ("samples", "crack_path", "statistics")]
                self.assertGreater(len(names), 60)
                for name in names:
                    np.testing.assert_array_equal(root[name][...], before[name][...], name)
        copy.write_text(re.sub("samples *= *3", "samples = 5", copy.read_text()))
        result = invoke("stats", "--keep-rows", self.folder)
        self.assertIn("5 samples: 3 done, 0 failed, 2 pending\n", result.stdout, result.stderr)

    def test_rows_do_not_hide_damaged_files(self):
        self.sample.write_bytes(self.sample.read_bytes()[:-100])
        result = invoke("stats", "--keep-rows", self.folder)
        self.assertIn("3 samples: 2 done, 0 failed, 1 pending\n", result.stdout, result.stderr)
        self.assertIn(f"pending sample {int(self.sample.stem)}: ", result.stdout)

    def test_rows_that_stay_are_at_the_ensembles_own_sections(self):
        result = invoke("stats", "--keep-rows", "--sections", "y=9 mm", self.folder)
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertIn("--keep-rows excludes --sections", result.stderr)

    def test_rows_of_another_input_do_not_stay(self):
        self.sample.unlink()
        copy = self.folder / "input.toml"
        copy.write_text(copy.read_text().replace("seed = 1", "seed = 2"))
        for sample in (self.folder / "samples").glob("*.h5"):
            sample.unlink()
        before = (self.folder / "ensemble.h5").read_bytes()
        result = invoke("stats", "--keep-rows", self.folder)
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertIn("ensemble.h5': was made from another input", result.stderr)
        self.assertEqual((self.folder / "ensemble.h5").read_bytes(), before)

    def test_input_comes_from_the_results_without_its_copy(self):
        (self.folder / "input.toml").unlink()
        self.assertIn("3 samples: 3 done", self.stats())

    def test_results_without_sample_files_are_shown_and_stay_as_they_are(self):
        whole = self.stats()
        shutil.rmtree(self.folder / "samples")
        results = self.folder / "ensemble.h5"
        before = results.read_bytes()
        for ranks in (0, 3):
            result = invoke("stats", self.folder, ranks=ranks)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(result.stdout, whole)
            self.assertEqual(results.read_bytes(), before)
        results.write_bytes(before[:-1])
        result = invoke("stats", self.folder)
        self.assertEqual(result.returncode, 1)
        self.assertEqual(len(re.findall("crackle: ", result.stderr)), 1, result.stderr)

    def test_cracks_faster_than_usual_are_warned_of(self):
        for ratio in (0.84, 0.99, 1.25):
            with opened(self.sample) as root:
                root["summary/crack_speed_max"][()] = 1234
                root["summary/crack_speed_ratio"][()] = ratio
            fast = [line for line in self.stats().splitlines()
                    if line.startswith("warning: in 1 sample a crack runs at more than 0.85 times the Rayleigh speed")]
            self.assertEqual(len(fast), 1 if ratio > 0.85 else 0)

    def test_files_of_another_schema_are_refused(self):
        with opened(self.sample) as root:
            root.attrs["schema_version"] = 99
        self.assert_refused("version 99 of the file format; this program reads versions up to 8")

    def older(self, version=4):
        """Makes the folder one of an older version of the format, with the names that this version had; what stats prints."""
        for file in (self.folder / "ensemble.h5", *(self.folder / "samples").glob("*.h5")):
            with opened(file, sealed=file.parent.name == "samples") as root:
                root.attrs["schema_version"] = version
                for name in ("first_break_x", "first_break_y", "first_break_z"):
                    del root["summary" if "summary" in root else "samples"][name]
                if "crack_surface" in root:
                    root["crack_surface"].move("branch", "arm")
        return invoke("stats", self.folder)

    def test_an_ensemble_of_an_older_version_is_shown_and_stays_as_it_is(self):
        def words(text: str) -> list[list[str]]:
            return [line.split() for line in text.splitlines() if not line.startswith("long branches")]
        before = invoke("stats", self.folder).stdout
        self.older()
        files = {file: file.read_bytes() for file in self.folder.rglob("*.*")}
        result = invoke("stats", self.folder)
        self.assertEqual((result.returncode, result.stderr, words(result.stdout)), (0, "", words(before)))
        refused = invoke("run", self.folder / "input.toml", "-o", self.folder, "--resume")
        self.assertEqual(refused.returncode, 1, refused.stdout)
        self.assertIn("version 4 of the file format, written by version", refused.stderr)
        self.assertIn("continue with the program that started this ensemble", refused.stderr)
        self.assertEqual({file: file.read_bytes() for file in self.folder.rglob("*.*")}, files)
        report = in_process.report(self.folder, "--program", OPTIONS.program)
        self.assertEqual((report.returncode, report.stderr), (0, ""))

    def test_versions_before_the_first_release_are_refused(self):
        result = self.older(version=3)
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertIn("version 3 of the file format", result.stderr)

    def test_the_papers_stored_ensemble_is_shown(self):
        with h5py.File(ROOT / "jobs/paper/shared-base/ensemble.h5") as root:
            status = root["samples/status"][...]
        result = invoke("stats", ROOT / "jobs/paper/shared-base")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        n_done = int((status == 1).sum())
        self.assertIn(f"200 samples: {n_done} done, 0 failed, {200 - n_done} pending", result.stdout)
        self.assertIn("Intervals hold for this base (one set of mother points), not for the material", result.stdout)
        self.assertRegex(result.stdout, r"\nfollower +notch 0 +notch 1 +y = 12.25 mm +y = 15.5 mm +45 .* < 0\.001 +- +- +143 +80\n")

    def test_files_of_another_kind_are_refused(self):
        shutil.copy(self.folder / "ensemble.h5", self.sample)
        with opened(self.sample):
            pass
        self.assert_refused("not a crackle sample file")

    def test_truncated_files_are_refused(self):
        with open(self.sample, "r+b") as file:
            file.truncate(self.sample.stat().st_size - 1)
        self.assert_refused("damaged or truncated file")

    def test_samples_of_another_input_are_refused(self):
        with opened(self.sample) as root:
            root.attrs["input_identity"] = "FNV-1a 0123456789abcdef"
        self.assert_refused("was made from another input")

    def test_samples_that_were_changed_are_refused(self):
        with opened(self.sample, sealed=False) as root:
            root["energy/strain"][0] *= 2
        self.assert_refused("damaged or truncated file|damaged file")

    def test_another_writer_is_waited_for_and_newer_rows_stay(self):
        results, lock = self.folder / "ensemble.h5", self.folder / "lock-ensemble.h5"
        newer = self.sample.read_bytes()
        self.sample.unlink()
        self.stats()
        older = results.read_bytes()
        start = pathlib.Path(f"/proc/{os.getpid()}/stat").read_text().rpartition(")")[2].split()[19]
        lock.write_text(f"host {socket.gethostname()}\nprocess {os.getpid()}\nstart {start}\njob -\n")
        partial = self.folder / "ensemble.h5.elsewhere-12.partial"
        partial.write_bytes(b"half of a file, another's")
        process = subprocess.Popen([os.path.abspath(OPTIONS.program), "stats", self.folder], env=environment(),
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        with self.assertRaises(subprocess.TimeoutExpired):
            process.wait(5)
        self.assertEqual(results.read_bytes(), older)
        self.assertTrue(partial.exists())
        self.sample.write_bytes(newer)
        lock.unlink()
        out, err = process.communicate(timeout=300)
        self.assertEqual((process.returncode, err), (0, ""))
        self.assertIn("3 samples: 3 done", out)
        self.assertEqual(content(results), content(self.finished / "ensemble.h5"))
        # One that was killed is not waited for, and what it left is removed.
        partial.write_bytes(b"half of a file")
        lock.write_text(f"host {socket.gethostname()}\nprocess {os.getpid()}\nstart 1\njob -\n")
        self.assertIn("3 samples: 3 done", self.stats())

    def test_statistics_are_shown_where_they_cannot_be_written(self):
        results = self.folder / "ensemble.h5"
        results.unlink()
        (results / "in-the-way").mkdir(parents=True)
        for ranks in (0, 2):
            result = invoke("stats", self.folder, ranks=ranks)
            self.assertEqual(result.returncode, 1)
            self.assertIn("3 samples: 3 done", result.stdout)
            self.assertEqual(len(re.findall("crackle: cannot write '.*ensemble.h5'", result.stderr)), 1, result.stderr)
            self.assertEqual(sorted(file.name for file in self.folder.iterdir()), ["ensemble.h5", "input.toml", "run.log", "samples"])

    def test_a_body_of_micrometres_has_the_same_table_in_small_units(self):
        """A body of 1/1024 of the size breaks at 1/1024^2 of the load, in 1/1024 of the time; to the last bit."""
        small = re.sub(r'"([\d.]+) mm"', lambda length: f'"{float(length[1]) * 1e-3 / 1024!r} m"', INPUT)
        small = re.sub(r'"(\d+) N("|/s")', lambda force: f'"{float(force[1]) / 1024**2!r} N{force[2]}', small)
        small = small.replace('"20 us"', f'"{20e-6 / 1024!r} s"').replace("1e-8 MPa", f"{1e-8 / 1024!r} MPa")
        setting = self.folder.parent / "small.toml"
        setting.write_text(small)
        ran = invoke("run", setting, "-o", self.folder.parent / "small")
        self.assertEqual(ran.returncode, 0, ran.stderr)
        big, small = self.stats(), invoke("stats", self.folder.parent / "small").stdout
        self.assertIn("mean [um];", small)
        for row, units, ratio in (("onset force", ("N", "uN"), 1.024**2), ("rough crack area", ("mm^2", "um^2"), 1.024**2),
                                  ("displacement at peak", ("mm", "nm"), 1.024e-3)):
            values = [re.search(rf"\n{row} \[{re.escape(unit)}\] +(.*)", text)[1].split()
                      for text, unit in zip((big, small), units)]
            # Three samples give no interval of the median; unit.statistics has one in small units.
            self.assertEqual(*(cells[5:] for cells in values))
            for one, other in zip(*(cells[:5] for cells in values)):
                self.assertAlmostEqual(float(one) / float(other) / ratio, 1, delta=2e-2, msg=f"{row}: {values}")  # two digits
        self.assertRegex(ran.stdout, r"onset \d{2,3}\.\d uN, .* \d+\.\d um\^2 of rough crack")

    def test_several_materials_have_their_shares_and_their_own_waves(self):
        """A corner of glass that no crack comes near, and a stiff layer across the crack's way."""
        single = INPUT[INPUT.index("[material]"):INPUT.index("[fracture]")]
        epoxy, stiff = (single.replace("[material]", f'[[material]]\nname = "{name}"').replace("3300 MPa", modulus)
                        for name, modulus in (("epoxy", "3300 MPa"), ("stiff", "6600 MPa")))
        for name, place in (("corner", 'y = ["6 mm", "8 mm"]\nz = ["0 mm", "2 mm"]'), ("layer", 'y = ["3 mm", "8 mm"]\nz = ["0 mm", "16 mm"]')):
            text = INPUT.replace(single, epoxy + stiff + '[[interface]]\nbetween = ["epoxy", "stiff"]\nstrength = "35 MPa"\n')
            text = text.replace("[mesh]", f'[[specimen.region]]\nmaterial = "stiff"\n{place}\n[mesh]')
            setting, out = (self.folder.parent / f"{name}{end}" for end in (".toml", ""))
            setting.write_text(text)
            ran = invoke("run", setting, "-o", out)
            self.assertEqual(ran.returncode, 0, ran.stderr)
            samples, shown = crackle.open(out).samples, json.loads(invoke("stats", out, "--json").stdout)["samples"]
            parts = ["epoxy", "stiff", "interface epoxy-stiff"]
            areas = np.array([samples[f"crack_area_in: {part}"] for part in parts])
            np.testing.assert_allclose(areas.sum(axis=0), samples["crack_area"], rtol=1e-12)
            for part, area in zip(parts, areas):
                self.assertEqual(shown["crack_area_in"][part], area.tolist())
                self.assertEqual(crackle.open(out)[1].summary[f"crack_area_in: {part}"], area[1])
            mean = 100 * (areas / samples["crack_area"].values).mean(axis=1)
            self.assertEqual(mean[1] > 0, name == "layer", mean)
            text = invoke("stats", out).stdout
            for part, value in zip(parts, mean):
                self.assertRegex(text, rf"\n{part} +{value:.1f} +[0-9.]+ +[0-9.]+ +[0-3] of 3\n")
            history = crackle.open(out)[0].history
            rayleigh = history.attrs["rayleigh_speed"]
            if name == "corner":
                # As in epoxy alone.
                self.assertAlmostEqual(rayleigh, crackle.open(self.folder)[0].history.attrs["rayleigh_speed"], delta=1e-9 * rayleigh)
                np.testing.assert_allclose(samples["crack_speed_ratio"] * rayleigh, samples["crack_speed_max"])
                np.testing.assert_allclose(history.tip_speed_ratio * rayleigh, history.tip_speed)
            else:
                self.assertGreater(rayleigh, 1.01 * crackle.open(self.folder)[0].history.attrs["rayleigh_speed"])

    def test_a_body_without_notch_says_where_it_broke(self):
        plain = re.sub(r"(?s)\[\[specimen.notch\]\].*?\[mesh\]", "[mesh]", INPUT).replace('notch_spacing = "0.6 mm"\n', "")
        setting = self.folder.parent / "plain.toml"
        setting.write_text(plain.replace('"100 N"', '"0 N"'))
        out = self.folder.parent / "plain"
        ran = invoke("run", setting, "-o", out)
        self.assertEqual(ran.returncode, 0, ran.stderr)
        self.assertRegex(ran.stdout, r"sample 0 done: separated, .*, from y = [\d.]+ mm, z = [\d.]+ mm, ")
        text = invoke("stats", out).stdout
        self.assertRegex(text, r"first break at y \[mm\] +\d")
        for empty in ("crack speed", "pattern ", " -\n"):
            self.assertNotIn(empty, text)
        with h5py.File(out / "ensemble.h5") as results, h5py.File(out / "samples/0000.h5") as sample:
            place = [results[f"samples/first_break_{axis}"][0] for axis in "xyz"]
            self.assertEqual(place, [sample[f"summary/first_break_{axis}"][()] for axis in "xyz"])
            for coordinate, length in zip(place, (0.003, 0.008, 0.016)):
                self.assertTrue(0 < coordinate < length, place)

    def test_rows_that_no_sample_has_are_left_out(self):
        text = invoke("stats", self.folder, "--sections", "y=3 mm, 7.9 mm").stdout
        self.assertRegex(text, r"\nleader +notch 0 +notch 0 +y = 3 mm +z +3 ")
        self.assertEqual(text.count("7.9 mm"), 1, text)
        self.assertIn("\nno crack reaches y = 7.9 mm\n", text)

    def test_other_folders_are_an_error(self):
        for folder, ranks in ((self.folder / "samples", 0), (self.folder / "missing", 0), (self.folder / "missing", 2)):
            result = invoke("stats", folder, ranks=ranks)
            self.assertEqual((result.returncode, result.stdout), (1, ""))
            self.assertEqual(len(re.findall("crackle: ", result.stderr)), 1, result.stderr)
            self.assertIn("neither input.toml nor ensemble.h5 nor samples", result.stderr)
            self.assertIn(str(folder), result.stderr)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", required=True)
    parser.add_argument("--mpirun", required=True)
    OPTIONS, rest = parser.parse_known_args()
    os.environ["CRACKLE"] = os.path.abspath(OPTIONS.program)
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
