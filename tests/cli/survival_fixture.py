# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of survival share: small plates, runs of the program that can be disturbed, equality of results."""
import argparse
import importlib.machinery
import importlib.util
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import command_lines  # noqa: E402
from crackle_launch import environment, mpirun  # noqa: E402

TIMEOUT = 240  # seconds that a run or a state may take on a busy machine


def load_kill_trials():
    loader = importlib.machinery.SourceFileLoader("kill_trials", str(ROOT / "tools" / "kill-trials"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("kill_trials", loader))
    loader.exec_module(module)
    return module


TRIALS = load_kill_trials()
PROGRAM = ""
SMALL = TRIALS.PLATE.replace("samples = 6", "samples = 3").replace('step = "20 ns"', 'step = "auto"')


def processor_seconds(*command):
    """Time that a command computes for, whatever else the machine does meanwhile."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, env=environment(), check=True, stdout=subprocess.DEVNULL, timeout=TIMEOUT)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before.ru_utime


def slow_plate(text, program, seconds):
    """The plate with a time step so small that each sample takes this machine about so long."""
    taken = {}
    with tempfile.TemporaryDirectory(prefix="crackle-slow-") as name:
        for step in (8, 2):
            setting = pathlib.Path(name) / f"{step}.toml"
            setting.write_text(text.replace('step = "20 ns"', f'step = "{step} ns"'))
            taken[step] = processor_seconds(program, "sample", setting, "--sample", "0", "-o", f"{name}/{step}")
    per_step = max(0.02, taken[2] - taken[8]) / 0.375  # of a sample at 1 ns
    step = per_step / seconds
    print(f"a sample takes {per_step:.2f} s with steps of 1 ns; slow: {step:.3g} ns, {seconds:g} s", flush=True)
    return text.replace('step = "20 ns"', f'step = "{step:.4g} ns"')


class SurvivalCase(unittest.TestCase):
    """`small` is an input that is computed at once, `slow` one of seconds for each sample."""
    SLOW_SECONDS = 0.4

    @classmethod
    def setUpClass(cls):
        cls.parent = tempfile.TemporaryDirectory(prefix="crackle-survival-")
        cls.addClassCleanup(cls.parent.cleanup)
        cls.root = pathlib.Path(cls.parent.name)
        cls.small, cls.slow = cls.root / "small.toml", cls.root / "slow.toml"
        cls.small.write_text(SMALL)
        cls.slow.write_text(slow_plate(TRIALS.PLATE.replace("samples = 6", "samples = 3"), PROGRAM, cls.SLOW_SECONDS))

    @classmethod
    def whole(cls, setting):
        """Folder of an undisturbed run of an input."""
        folder = cls.root / f"whole-{setting.stem}"
        if not folder.exists():
            result = cls.call("run", setting, "-o", folder)
            assert result.returncode == 0, result.stdout + result.stderr
        return folder

    @classmethod
    def start(cls, *arguments, n_ranks=1, extra_environment=None, memory_limit=None, launcher=None):
        launcher = launcher or ([] if n_ranks == 1 else mpirun(n_ranks))
        limits = (lambda: resource.setrlimit(resource.RLIMIT_AS, (memory_limit, -1))) if memory_limit else None
        return subprocess.Popen([*launcher, PROGRAM, *map(str, arguments)], text=True, stdout=subprocess.PIPE,
                                env=environment(**(extra_environment or {})), stderr=subprocess.PIPE,
                                preexec_fn=limits)

    @classmethod
    def call(cls, *arguments, timeout=TIMEOUT, **options):
        """What a command line gives: in a process of its own if it has its own ranks, launcher, environment or memory."""
        if not options:
            return command_lines.crackle(PROGRAM, *arguments, timeout=timeout)
        process = cls.start(*arguments, **options)
        try:
            out, err = process.communicate(timeout=timeout)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            raise
        return subprocess.CompletedProcess(arguments, process.returncode, out, err)

    def setUp(self):
        self.out = self.root / "out"
        shutil.rmtree(self.out, ignore_errors=True)

    def wait_for(self, condition, process):
        """Until the state is there that is to be disturbed; the process must not have ended before."""
        end = time.monotonic() + TIMEOUT
        while not condition():
            self.assertIsNone(process.poll(), "ended before it was disturbed")
            self.assertLess(time.monotonic(), end)
            time.sleep(0.005)

    def freeze(self, process):
        """Stops the process where it is, so that what follows takes as long as it likes."""
        process.send_signal(signal.SIGSTOP)
        self.assertIsNone(process.poll(), "ended before it was disturbed")

    def kill(self, process):
        process.kill()  # a frozen one too
        process.communicate()

    def assert_refused(self, result, *parts):
        self.assertEqual(result.returncode, 1, result.stdout + result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        for part in parts:
            self.assertIn(part, result.stderr)

    def assert_complete(self, setting, result):
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertEqual(TRIALS.differences(self.whole(setting), self.out), [])


def main(description):
    global PROGRAM
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--program", required=True, type=os.path.abspath)
    options, rest = parser.parse_known_args()
    PROGRAM = options.program
    unittest.main(module="__main__", argv=[sys.argv[0], *rest], verbosity=2)
