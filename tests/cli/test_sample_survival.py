#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""crackle sample is suspended, killed and continued on other numbers of ranks, with the bits of an undisturbed one."""
import fcntl
import os
import pathlib
import pty
import re
import signal
import struct
import subprocess
import termios

import h5py
import numpy as np
import survival_fixture
from survival_fixture import SMALL, TRIALS, SurvivalCase, environment


class SampleSurvival(SurvivalCase):
    SLOW_SECONDS = 3

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.reference, cls.status, cls.shown = cls.undisturbed()

    @classmethod
    def undisturbed(cls):
        """The file of a sample that nothing disturbs, its exit status and what a terminal of 90 columns shows of it."""
        folder = cls.root / "undisturbed"
        arguments = tuple(map(str, ("sample", cls.slow, "--sample", 1, "-o", folder)))
        outer, inner = pty.openpty()
        fcntl.ioctl(inner, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 90, 0, 0))
        with subprocess.Popen([survival_fixture.PROGRAM, *arguments], stdout=inner, env=environment()) as process:
            os.close(inner)
            shown = b""
            try:
                while piece := os.read(outer, 4096):
                    shown += piece
            except OSError:  # the program has closed its end
                pass
            os.close(outer)
        return folder / "samples" / "0001.h5", process.returncode, shown.decode()

    def sample(self, *arguments):
        return ("sample", self.slow, "--sample", 1, "-o", self.out, "--checkpoint-interval", "0.05s", *arguments)

    def start_until_checkpoint(self, *arguments, n_ranks=1):
        """A run that has written a checkpoint of its own."""
        before = self.written(self.checkpoint)
        process = self.start(*self.sample(*arguments), n_ranks=n_ranks)
        self.wait_for(lambda: self.written(self.checkpoint) != before, process)
        return process

    def written(self, file):
        return file.stat().st_mtime_ns if file.exists() else None

    def assert_suspended(self, result):
        self.assertEqual(result.returncode, 3, result.stdout + result.stderr)
        self.assertIn("sample 1 suspended after", result.stdout)
        self.assertRegex(result.stdout, rf"\nto continue: {re.escape(survival_fixture.PROGRAM)} sample {self.slow} --sample 1 "
                                        rf"-o {self.out} .*--resume\n")
        self.assertEqual(result.stdout.count("--resume"), 1)
        self.assertTrue(self.checkpoint.exists())
        self.assertEqual(list(self.out.glob("lock-*")), [])

    def resumed_step(self, result):
        return int(re.search(r"continues at step (\d+)", result.stdout)[1])

    def suspended_at_a_time_limit(self, n_ranks):
        """A run that has run for a while before its time limit came."""
        for limit in (1, 2, 4, 8, 16, 32):  # a busy machine or a sanitizer may take seconds to start
            result = self.call(*self.sample("--resume", "--time-limit", f"0:{limit:02}"), n_ranks=n_ranks)
            self.assertIn(f"the time limit of {limit} s: stopping", result.stdout)
            self.assert_suspended(result)
            if "continues at step" in result.stdout:
                return result
        self.fail("no time limit was long enough to start")

    def assert_equal_sample(self, result):
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertFalse(self.checkpoint.exists())
        same = subprocess.run(["h5diff", *(f"--exclude-path={path}" for path in TRIALS.EXCLUDED), self.reference,
                               self.out / "samples" / "0001.h5"], capture_output=True, text=True, check=False)
        self.assertEqual(same.returncode, 0, same.stdout)

    def setUp(self):
        super().setUp()
        self.checkpoint = self.out / "samples" / "0001.checkpoint"
        self.assertEqual(self.status, 0, self.shown)

    def test_signals_and_time_limits_suspend_and_other_ranks_continue(self):
        for number in (signal.SIGUSR1, signal.SIGTERM, signal.SIGINT):
            process = self.start_until_checkpoint(*(["--resume"] if self.checkpoint.exists() else []))
            process.send_signal(number)
            out, err = process.communicate(timeout=survival_fixture.TIMEOUT)
            self.assertIn(f"{number.name}: stopping\n", out)
            self.assert_suspended(subprocess.CompletedProcess((), process.returncode, out, err))
        process = self.start_until_checkpoint("--resume", n_ranks=2)
        ranks = pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        os.kill(int(ranks[1]), signal.SIGUSR1)
        out, err = process.communicate(timeout=survival_fixture.TIMEOUT)
        self.assertIn("a signal to another rank: stopping\n", out)
        self.assert_suspended(subprocess.CompletedProcess((), process.returncode, out, err))
        steps = []
        for n_ranks in (2, 3):  # some steps only: where ranks share cores they wait for each other
            result = self.suspended_at_a_time_limit(n_ranks)
            steps.append(self.resumed_step(result))
        result = self.call(*self.sample("--resume"))
        steps.append(self.resumed_step(result))
        print(f"resumed at steps {steps}")
        self.assertEqual(steps, sorted(set(steps)), "each piece continues where the one before was suspended")
        self.assert_equal_sample(result)

    def test_a_kill_costs_what_came_after_the_checkpoint(self):
        process = self.start_until_checkpoint()
        self.freeze(process)
        self.assert_refused(self.call(*self.sample("--resume")), "another run is active", "lock-1-1")
        self.kill(process)
        self.assert_refused(self.call(*self.sample()), "is a checkpoint of this sample", "--resume")
        other = self.root / "other.toml"
        other.write_text(self.slow.read_text().replace("0.38", "0.37").replace("seed = 1", "seed = 2"))
        self.assert_refused(self.call("sample", other, "--sample", 1, "-o", self.out, "--resume"),
                            "ensemble.seed is 2, not 1", "material.poisson_ratio is 0.37, not 0.38")
        result = self.call(*self.sample("--resume"))
        self.assertIn("is taken over: process", result.stdout)
        self.resumed_step(result)
        self.assert_equal_sample(result)

    def test_whole_files_are_kept_and_damaged_ones_computed_again(self):
        arguments = ("sample", self.small, "--sample", 1, "-o", self.out)
        self.assertEqual(self.call(*arguments).returncode, 0)
        file = self.out / "samples" / "0001.h5"
        written = self.written(file)
        result = self.call(*arguments, "--resume")
        self.assertIn("sample 1 is already done; it is kept", result.stdout)
        self.assertEqual((result.returncode, self.written(file)), (0, written))
        data = file.read_bytes()
        file.write_bytes(data[:1000] + b"x" + data[1001:])
        result = self.call(*arguments, "--resume")
        self.assertRegex(result.stdout, "0001.h5.invalid-1 and the sample computed again: .*damaged file")
        self.assertEqual(result.returncode, 0)
        written = self.written(file)
        self.assert_refused(self.call(*arguments), f"{file} already holds this sample", "--resume", "--overwrite")
        self.assertEqual(self.written(file), written)
        self.assertEqual(self.call(*arguments, "--overwrite").returncode, 0)
        self.assertGreater(self.written(file), written)

    def test_a_terminal_shows_where_the_sample_stands(self):
        text = self.shown
        shown = re.findall(r"\rdynamic phase (\d+): (\d+) %, [^\r\n]* s left at most", text)
        shares = [[int(share) for phase, share in shown if phase == number] for number in {phase for phase, _ in shown}]
        self.assertTrue(all(of_phase == sorted(of_phase) for of_phase in shares), text)
        self.assertGreater(max(len(set(of_phase)) for of_phase in shares), 1, text)
        self.assertTrue(all(len(line) < 90 for line in re.findall(r"\rdynamic phase [^\r\n]*", text)))

    def test_numbers_out_of_bounds_are_found_soon(self):
        # Loads that tear everything apart at once: the sample fails long before its end, with the reason.
        wild = self.root / "wild.toml"
        wild.write_text(SMALL.replace('rate = ["0 N/s", "0 N/s", "5 N/s"]', 'rate = ["0 N/s", "0 N/s", "1e17 N/s"]')
                        .replace("[time]", '[time]\nstart = "rest"'))
        result = self.call("sample", wild, "--sample", 0, "-o", self.out)
        self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
        reason = re.search(r"sample 0 failed after .*", result.stdout)[0]
        print(reason)
        step = float(re.search(r"used ([\d.]+) ns", result.stdout)[1]) * 1e-3
        self.assertLess(float(re.search(r"\(([\d.]+) us after the start of the phase\)", reason)[1]), 32 * step)
        # What there is of it is kept, marked failed.
        with h5py.File(self.out / "samples" / "0000.h5") as root:
            self.assertEqual(root.attrs["status"], 2)
            self.assertRegex(root.attrs["error"], "^computation: ")
            self.assertGreater(root["mesh/tetrahedra"].shape[0], 100)
            self.assertGreater(root["frames/time"].size, 0)
            self.assertGreater(root["energy/time"].size, 0)
            self.assertIn("tetrahedron", root["breaks"])
            self.assertIn("corners", root["crack_surface"])
            self.assertTrue(np.isnan(root["summary/crack_area"][()]))


if __name__ == "__main__":
    survival_fixture.main(__doc__)
