#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""crackle run under adversity: signals, time limits, a second run, changed inputs, damaged files, full and vanished
disks.
"""
import argparse
import os
import pathlib
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

from test_slurm import load_kill_trials

OPTIONS = None
TRIALS = load_kill_trials()
SMALL = TRIALS.PLATE.replace("samples = 6", "samples = 3").replace('step = "20 ns"', 'step = "auto"')
SLOW = SMALL.replace('step = "auto"', 'step = "2 ns"')  # some seconds for each sample
PARK_SECONDS = 10  # within which a run of this size has parked


class Survival(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.parent = tempfile.TemporaryDirectory(prefix="crackle-survival-")
        cls.addClassCleanup(cls.parent.cleanup)
        cls.root = pathlib.Path(cls.parent.name)
        cls.small, cls.slow = cls.root / "small.toml", cls.root / "slow.toml"
        cls.small.write_text(SMALL)
        cls.slow.write_text(SLOW)
        cls.whole, cls.whole_slow = cls.root / "whole", cls.root / "whole-slow"
        for setting, folder in ((cls.small, cls.whole), (cls.slow, cls.whole_slow)):
            result = cls.call("run", setting, "-o", folder)
            assert result.returncode == 0, result.stdout + result.stderr

    @classmethod
    def start(cls, *arguments, **options):
        return subprocess.Popen([OPTIONS.program, *map(str, arguments)], env=TRIALS.environment(), text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)

    @classmethod
    def call(cls, *arguments, **options):
        process = cls.start(*arguments, **options)
        out, err = process.communicate(timeout=120)
        return subprocess.CompletedProcess(arguments, process.returncode, out, err)

    def setUp(self):
        self.out = self.root / "out"
        shutil.rmtree(self.out, ignore_errors=True)

    def wait_for(self, condition):
        end = time.monotonic() + 60
        while not condition():
            self.assertLess(time.monotonic(), end)
            time.sleep(0.02)

    def assert_refused(self, result, *parts):
        self.assertEqual(result.returncode, 1, result.stdout + result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        for part in parts:
            self.assertIn(part, result.stderr)

    def assert_complete(self, reference, result):
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertEqual(TRIALS.differences(reference, self.out), [])

    # Signals and time.

    def test_signals_park_and_a_second_one_ends_at_once(self):
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGUSR1):
            with self.subTest(number):
                shutil.rmtree(self.out, ignore_errors=True)
                process = self.start("run", self.slow, "-o", self.out)
                self.wait_for(lambda: (self.out / "samples" / "0000.h5").exists())
                time.sleep(0.3)
                start = time.monotonic()
                process.send_signal(number)
                out, err = process.communicate(timeout=PARK_SECONDS)
                print(f"{number.name}: parked in {time.monotonic() - start:.2f} s")
                self.assertEqual(process.returncode, 3, out + err)
                self.assertIn(f"{number.name}: stopping\n", out)
                self.assertFalse(list(self.out.glob("lock-*")))
                self.assert_complete(self.whole_slow, self.call("run", self.slow, "-o", self.out, "--resume"))
        process = self.start("run", self.slow, "-o", self.out.with_name("twice"))
        self.wait_for(lambda: (self.out.with_name("twice") / "input.toml").exists())
        for _ in range(2):
            process.send_signal(signal.SIGTERM)
            time.sleep(0.01)
        process.communicate(timeout=2)
        self.assertEqual(process.returncode, 3)

    def test_time_limits_park(self):
        result = self.call("run", self.slow, "-o", self.out, "--time-limit", "2s")
        self.assertEqual(result.returncode, 3, result.stdout + result.stderr)
        self.assertIn("the time limit of 2 s: stopping", result.stdout)
        environment = dict(TRIALS.environment(), SLURM_JOB_END_TIME=str(int(time.time()) + 2))
        process = subprocess.run([OPTIONS.program, "run", self.slow, "-o", self.out, "--resume"], env=environment,
                                 capture_output=True, text=True, check=False, timeout=60)
        self.assertEqual(process.returncode, 3, process.stdout + process.stderr)
        self.assert_complete(self.whole_slow, self.call("run", self.slow, "-o", self.out, "--resume"))

    # What a folder holds.

    def test_a_second_run_is_refused(self):
        process = self.start("run", self.slow, "-o", self.out)
        self.wait_for(lambda: (self.out / "input.toml").exists())
        self.assert_refused(self.call("run", self.slow, "-o", self.out, "--resume"), "another run is at work",
                            f"process {process.pid} on ", "lock-0-2")
        self.assert_refused(self.call("run", self.slow, "-o", self.out, "--resume", "--samples", "1-2"),
                            "another run is at work on some of these samples")
        process.kill()
        process.communicate()
        result = self.call("run", self.slow, "-o", self.out, "--resume")
        self.assertIn("is taken over: process", result.stdout)
        self.assert_complete(self.whole_slow, result)

    def test_locks_of_other_hosts_and_of_the_same_job(self):
        shutil.copytree(self.whole, self.out)
        lock = self.out / "lock-0-2"
        lock.write_text("host elsewhere\nprocess 12\nstart 34\njob 56\n")
        self.assert_refused(self.call("run", self.small, "-o", self.out, "--resume"),
                            "process 12 on elsewhere, SLURM job 56")
        os.utime(lock, (time.time() - 3600, time.time() - 3600))
        self.assert_complete(self.whole, self.call("run", self.small, "-o", self.out, "--resume"))
        lock.write_text("host elsewhere\nprocess 12\nstart 34\njob 56\n")
        result = subprocess.run([OPTIONS.program, "run", self.small, "-o", self.out, "--resume"], check=False,
                                env=dict(TRIALS.environment(), SLURM_JOB_ID="56"), capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("was an earlier start of this job", result.stdout)
        # Of this host, but of a process number that another process has now.
        lock.write_text(f"host {socket.gethostname()}\nprocess {os.getpid()}\nstart 1\njob -\n")
        self.assert_complete(self.whole, self.call("run", self.small, "-o", self.out, "--resume"))

    def test_other_inputs_are_refused_with_the_differences(self):
        shutil.copytree(self.whole, self.out)
        self.assert_refused(self.call("run", self.small, "-o", self.out), "holds an ensemble already", "--resume")
        other = self.root / "other.toml"
        other.write_text(SMALL.replace("0.38", "0.37").replace("seed = 1", "seed = 2"))
        self.assert_refused(self.call("run", other, "-o", self.out, "--resume"), "ensemble.seed is 2, not 1",
                            "material.poisson_ratio is 0.37, not 0.38")
        other.write_text(SMALL.replace("samples = 3", "samples = 2"))
        self.assert_refused(self.call("run", other, "-o", self.out, "--resume"), "ensemble.samples is 2, fewer than 3")

    def test_more_samples_extend_the_ensemble(self):
        more = self.root / "more.toml"
        more.write_text("# more\n" + SMALL.replace("samples = 3", "samples = 5"))
        shutil.copytree(self.whole, self.out)
        result = self.call("run", more, "-o", self.out, "--resume")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertIn("2 of 5 samples to do", result.stdout)
        at_once = self.root / "at-once"
        self.assertEqual(self.call("run", more, "-o", at_once).returncode, 0)
        # Only the text of the input differs, in the files of the first samples.
        different = TRIALS.differences(at_once, self.out)
        self.assertEqual(different, [f"samples/{i:04}.h5" for i in range(3)])

    def test_damaged_files_are_set_aside_and_computed_again(self):
        generator = random.Random(7)
        shutil.copytree(self.whole, self.out)
        files = sorted((self.out / "samples").iterdir())
        data = [bytearray(file.read_bytes()) for file in files]
        data[0][generator.randrange(len(data[0]))] ^= 1 << generator.randrange(8)
        files[0].write_bytes(data[0])
        files[1].write_bytes(data[1][:generator.randrange(len(data[1]))])
        shutil.copy(self.whole / "samples" / "0000.h5", files[2])
        (self.out / "samples" / "0001.checkpoint").write_bytes(b"rubbish")
        result = self.call("run", self.small, "-o", self.out, "--resume")
        self.assertIn("0000.h5.invalid-1 and computed again", result.stdout)
        self.assertIn("0001.h5.invalid-1 and computed again", result.stdout)
        self.assertIn("holds sample 0 instead of 2", result.stdout)
        self.assertIn("0001.checkpoint.invalid-1", result.stdout)
        aside = sorted((self.out / "samples").glob("*.invalid-1"))
        self.assertEqual(len(aside), 4)
        for file in aside:
            file.unlink()
        self.assert_complete(self.whole, result)

    # Disks.

    def test_a_full_tmpfs(self):
        mount = self.root / "tmpfs"
        mount.mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=120k", "none", mount], check=False,
                          stderr=subprocess.DEVNULL).returncode != 0:
            self.skipTest("no tmpfs can be mounted here")
        try:
            result = self.call("run", self.small, "-o", mount / "out")
            self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
            self.assertIn("No space left on device", result.stdout)
            subprocess.run(["mount", "-o", "remount,size=20m", mount], check=True)
            result = self.call("run", self.small, "-o", mount / "out", "--resume")
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
            self.assertEqual(TRIALS.differences(self.whole, mount / "out"), [])
            subprocess.run(["mount", "-o", "remount,ro", mount], check=True)
            self.assert_refused(self.call("run", self.small, "-o", mount / "new"), "Read-only file system")
            self.assert_refused(self.call("run", self.small, "-o", mount / "out", "--resume"), "Read-only file system")
        finally:
            subprocess.run(["umount", mount], check=True)

    def test_folders_that_cannot_be(self):
        (self.root / "plain").write_text("a file")
        self.assert_refused(self.call("run", self.small, "-o", self.root / "plain"), "is no folder")
        self.assert_refused(self.call("run", self.small, "-o", self.root / "plain" / "out"), "cannot be made")
        self.assert_refused(self.call("run", self.small, "-o", "/proc/crackle"), "cannot be made")

    def test_a_folder_that_vanishes(self):
        process = self.start("run", self.slow, "-o", self.out)
        self.wait_for(lambda: (self.out / "samples" / "0000.h5").exists())
        shutil.rmtree(self.out)
        out, err = process.communicate(timeout=120)
        # The folder is made again for the next file; what was in it is pending.
        self.assertEqual(process.returncode, 2, out + err)
        self.assert_complete(self.whole_slow, self.call("run", self.slow, "-o", self.out, "--resume"))

    # Failures and ranges.

    def test_ranges_are_merged_by_stats(self):
        for part in ("0-0", "1-2"):
            result = self.call("run", self.small, "-o", self.out, "--resume", "--samples", part)
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
            self.assertFalse((self.out / "ensemble.h5").exists())
        self.assert_complete(self.whole, self.call("stats", self.out))
        for part in ("3", "2-1", "1-", "-1", "x"):
            result = self.call("run", self.small, "-o", self.out, "--resume", f"--samples={part}")
            self.assertEqual(result.returncode, 1, part)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", required=True, type=os.path.abspath)
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
