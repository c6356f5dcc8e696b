#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pipes, folders, damaged and foreign files in the place of results: the Python package and the report say which, and end."""
from __future__ import annotations

import argparse
import contextlib
import html
import os
import re
import shutil
import signal
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Callable, Iterator
from unittest import mock

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "cli")]

import crackle  # noqa: E402
import in_process  # noqa: E402
import small_input  # noqa: E402
from crackle import checksum, files  # noqa: E402
from crackle_report import command, paraview  # noqa: E402
from synthetic_ensemble import seal  # noqa: E402

PROGRAM = Path()
SAMPLE = "samples/0001.h5"


@contextlib.contextmanager
def patience(seconds: int) -> Iterator[None]:
    """A reader that takes longer ends this process."""
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)


def read_all() -> None:
    """A program of a user of the package."""
    try:
        ensemble = crackle.open(sys.argv[1])
        ensemble.samples, ensemble.paths, ensemble.histories, [sample.frames for sample in ensemble]
    except crackle.ResultsError as error:
        sys.exit(f"refused: {error}")


class Folders(unittest.TestCase):
    """A folder of results of its own for each test."""

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.made = small_input.run(PROGRAM, small_input.small_input(), Path(cls.temporary.name) / "made")

    def setUp(self):
        self.folder = Path(self.temporary.name) / "out"
        shutil.copytree(self.made, self.folder)
        self.addCleanup(shutil.rmtree, self.folder)

    def refusals(self, file: Path, message: str, readers: tuple[str, ...] = ("package", "report")) -> None:
        """Each reader ends by itself, with status 1 and one line that names the file."""
        commands = {"package": (read_all, self.folder), "report": (command.main, self.folder, "--no-animation"),
                    "paraview": (paraview.main, self.folder, "--sample", "1")}
        for reader in readers:
            with self.subTest(file=file.name, reader=reader):
                with patience(60):
                    done = in_process.call(*commands[reader])
                self.assertEqual((done.returncode, done.stdout, done.stderr.count("\n")), (1, "", 1), done.stderr)
                self.assertIn(f"'{file}'", done.stderr)
                self.assertRegex(done.stderr, message)


class Places(Folders):
    """What is no regular file is not opened."""

    def test_a_pipe_does_not_make_them_wait(self):
        for place, readers in (("ensemble.h5", ("package", "report")), (SAMPLE, ("package", "report", "paraview")),
                               ("input.toml", ("report",))):
            file = self.folder / place
            kept = file.read_bytes()
            file.unlink()
            os.mkfifo(file)
            self.refusals(file, "is a named pipe", readers)
            file.unlink()
            file.write_bytes(kept)

    def test_folders_and_loops_are_no_files_either(self):
        (self.folder / SAMPLE).unlink()
        (self.folder / SAMPLE).mkdir()
        with self.assertRaisesRegex(crackle.ResultsError, "0001.h5' is a folder"):
            crackle.open(self.folder)
        (self.folder / SAMPLE).rmdir()
        (self.folder / "ensemble.h5").unlink()
        (self.folder / "ensemble.h5").symlink_to("ensemble.h5")
        with self.assertRaisesRegex(crackle.ResultsError, "ensemble.h5' is a broken link"):
            crackle.open(self.folder)

    def test_a_link_to_a_file_is_followed(self):
        for place in ("ensemble.h5", SAMPLE):
            (self.folder / place).rename(self.folder / "elsewhere")
            (self.folder / place).symlink_to(self.folder / "elsewhere")
            self.assertEqual(len(crackle.open(self.folder).histories.sample), 3)
            (self.folder / place).unlink()
            (self.folder / "elsewhere").rename(self.folder / place)

    def test_a_pipe_in_the_place_of_what_the_report_writes_is_replaced(self):
        os.mkfifo(self.folder / "report.html.partial")
        with patience(120):
            self.assertEqual(in_process.report(self.folder, "--no-animation", sections=()).returncode, 0)
        self.assertIn("</html>", (self.folder / "report.html").read_text())


class Contents(Folders):
    """Files are read when they are what they seem to be."""

    def flip(self, place: int) -> None:
        with open(self.folder / SAMPLE, "r+b") as stream:
            stream.seek(place)
            byte = stream.read(1)[0]
            stream.seek(place)
            stream.write(bytes([byte ^ 0x10]))

    def test_every_flipped_byte_of_a_sample_is_found(self):
        sample = self.folder / SAMPLE
        size = sample.stat().st_size
        with h5py.File(sample) as root:
            data = root["frames/displacement"].id.get_chunk_info(0)
        places = [8, 200, data.byte_offset + data.size // 2, size - 40, size - 33, size - 25, size - 1,
                  *np.random.Generator(np.random.PCG64(1)).integers(0, size, 40).tolist()]
        for place in places:
            self.flip(place)
            with self.subTest(place=place), self.assertRaisesRegex(crackle.ResultsError, "0001.h5' is damaged"):
                crackle.open(self.folder)[1]
            self.flip(place)
        self.assertEqual(crackle.open(self.folder)[1].number, 1)

    def test_readers_name_the_damaged_file(self):
        self.flip((self.folder / SAMPLE).stat().st_size // 2)
        self.refusals(self.folder / SAMPLE, "is damaged: its content does not match its checksum", ("package", "paraview"))
        self.report_goes_on(" is damaged: its content does not match its checksum")

    def report_goes_on(self, reason: str) -> None:
        """The rest is drawn, and the page says what is left out."""
        done = in_process.report(self.folder, "--no-animation")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        page = html.unescape((self.folder / "report.html").read_text())
        self.assertEqual(len(re.findall(f"Left out of the pictures: [^<]*{SAMPLE}'{reason}", page)), 1)
        self.assertEqual(page.count("Left out of the pictures"), 1)
        self.assertGreater(page.count("<figure>"), 3)

    def change(self, change: Callable[[h5py.File], None]) -> None:
        """One sample file, which is sealed again."""
        file = self.folder / SAMPLE
        file.write_bytes(file.read_bytes()[:-files.TRAILER])
        with h5py.File(file, "r+") as root:
            change(root)
        seal(file)

    def test_a_sample_of_another_model_is_refused(self):
        def other_model(root: h5py.File) -> None:
            root.attrs["model_version"] = 99
        self.change(other_model)
        self.refusals(self.folder / SAMPLE, "is of model 99, of version .*; the other samples are of model ", ("package", "paraview"))
        self.report_goes_on(" is of model 99")

    def test_a_file_of_an_unknown_format_is_refused(self):
        def other_format(root: h5py.File) -> None:
            root.attrs["schema_version"] = files.SCHEMA_VERSIONS[-1] + 1
        self.change(other_format)
        self.refusals(self.folder / SAMPLE, f"is of version {files.SCHEMA_VERSIONS[-1] + 1} of the file format", ("package", "paraview"))
        self.report_goes_on(" is of version")

    def test_the_known_formats_are_those_of_the_program(self):
        header = (ROOT / "src/io/sample_file.h").read_text()
        newest, oldest = (int(re.search(rf" {name}_schema_version = (\d+);", header)[1]) for name in ("sample", "oldest"))
        self.assertEqual(files.SCHEMA_VERSIONS, range(oldest, newest + 1))

    def test_corners_that_are_no_numbers_are_named(self):
        def no_corner(root: h5py.File) -> None:
            root["crack_surface/corners"][0, 0, 0] = np.nan
        self.change(no_corner)
        self.refusals(self.folder / SAMPLE, "corners of its crack are not numbers", ("paraview",))
        self.report_goes_on(", which may be damaged: corners of its crack are not numbers")

    def test_damage_after_the_first_reading_is_found(self):
        sample = crackle.open(self.folder)[1]
        self.flip(5000)
        with self.assertRaisesRegex(crackle.ResultsError, "is damaged"):
            sample.frames

    def test_a_cut_file_is_no_whole_one(self):
        content = (self.folder / SAMPLE).read_bytes()
        for length in (len(content) - 1, len(content) - 32, len(content) // 2, 100, 10, 0):
            (self.folder / SAMPLE).write_bytes(content[:length])
            with self.subTest(length=length), self.assertRaisesRegex(crackle.ResultsError, "0001.h5'(, which may be damaged| is damaged| is not an HDF5)"):
                crackle.open(self.folder)[1]

    def test_damage_in_the_results_of_all_names_them(self):
        with h5py.File(self.folder / "ensemble.h5", "r+") as root:
            del root["samples/status"]
        with self.assertRaisesRegex(crackle.ResultsError, "ensemble.h5' is incomplete: .*status"):
            crackle.open(self.folder).samples

    def test_files_of_other_programs_are_named_as_such(self):
        results = self.folder / "ensemble.h5"
        with h5py.File(results, "w") as root:
            root["temperature"] = [1.0, 2.0]
        self.refusals(results, "is not a crackle ensemble file", ("package",))
        for kind in ("something else", np.arange(3)):
            with h5py.File(results, "w") as root:
                root.attrs["kind"] = kind
            with self.assertRaisesRegex(crackle.ResultsError, "is not a crackle ensemble file, but of another program"):
                crackle.open(self.folder)
        shutil.copy(self.folder / SAMPLE, results)
        with self.assertRaisesRegex(crackle.ResultsError, "is not a crackle ensemble file, but a crackle sample file"):
            crackle.open(self.folder)
        results.write_text("temperature,1,2\n")
        with self.assertRaisesRegex(crackle.ResultsError, "ensemble.h5' is not an HDF5 file"):
            crackle.open(self.folder)
        results.unlink()
        with h5py.File(self.folder / SAMPLE, "w") as root:
            root.attrs["kind"] = "something else"
        with self.assertRaisesRegex(crackle.ResultsError, "0001.h5' is not a crackle sample file, but of another program"):
            crackle.open(self.folder).samples

    def test_a_sound_file_is_hashed_once(self):
        with mock.patch.object(files, "checksum", wraps=files.checksum) as hashing:
            first = crackle.open(self.folder)
            first.histories, first[1].frames, crackle.open(self.folder).histories, crackle.open(self.folder)[1].mesh
        sizes = [file.stat().st_size for file in (self.folder / "samples").iterdir()]
        self.assertEqual(sum(len(call.args[0]) for call in hashing.call_args_list), sum(sizes) - 32 * len(sizes))


class CheckSum(unittest.TestCase):
    def test_it_is_fnv_1a(self):
        # Of its authors' test vectors.
        for text, value in ((b"", 0xCBF29CE484222325), (b"a", 0xAF63DC4C8601EC8C), (b"foobar", 0x85944171F73967E8)):
            self.assertEqual(checksum.checksum(text), value)
        random = np.random.Generator(np.random.PCG64(2))
        for length in (63, 64, 65, 1000, checksum.BLOCK - 1, checksum.BLOCK, checksum.BLOCK + 77):
            for data in (random.bytes(length), b"\xff" * length):
                value = checksum.START
                for byte in data:
                    value = (value ^ byte) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
                self.assertEqual(checksum.checksum(data), value, length)
                self.assertEqual(checksum.checksum(data[length // 3:], checksum.checksum(data[:length // 3])), value)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=Path, required=True)
    options, rest = parser.parse_known_args()
    PROGRAM = options.program.resolve()
    os.environ["CRACKLE"] = str(PROGRAM)
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
