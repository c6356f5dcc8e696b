#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""jobs/ensemble.sbatch and jobs/array.sbatch under SLURM itself: a job whose time is too short suspends, goes back into
the queue and ends with the results of an undisturbed run; so does one of whose ranks one is killed. Status 77: this
machine has no SLURM.
"""
import argparse
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

import slurm_cluster
from survival_fixture import ROOT, TRIALS, environment, mpirun, slow_plate

OPTIONS = None
N_SAMPLES = 6
SAMPLE_SECONDS = 4.5  # in all three times what a job's first seconds, before SLURM's warning, suffice for
QUICK_SECONDS = 1  # where no warning is waited for


class Slurm(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.parent = pathlib.Path(tempfile.mkdtemp(prefix="crackle-slurm-"))
        shutil.copytree(ROOT / "jobs", cls.parent / "jobs", ignore=shutil.ignore_patterns("images"))
        cls.cluster = slurm_cluster.Cluster(cls.parent)
        cls.cluster.__enter__()
        cls.addClassCleanup(cls.cluster.__exit__)

    @classmethod
    def plate(cls, sample_seconds):
        """An input, whose samples take that much processor time, beside its undisturbed results."""
        setting = cls.parent / f"plate-{sample_seconds:g}.toml"
        if not setting.exists():
            setting.write_text(slow_plate(TRIALS.PLATE, OPTIONS.program, sample_seconds))
            start = time.monotonic()
            result = subprocess.run([*mpirun(3), OPTIONS.program, "run", setting, "-o", setting.with_suffix("")],
                                    env=environment(), capture_output=True, text=True, check=False)
            assert result.returncode == 0, result.stdout + result.stderr
            print(f"undisturbed: {time.monotonic() - start:.0f} s on 3 ranks")
        return setting

    @classmethod
    def tearDownClass(cls):
        if OPTIONS.keep:
            print(f"kept: {cls.parent}")

    def submit(self, script, setting, folder, *options, start="mpirun", submitted_from=None):
        return self.cluster.submit(
            submitted_from or self.parent, "--nodes=1", "--ntasks-per-node=2", "--mem-per-cpu=0", "--time=1", *options,
            self.parent / "jobs" / script, setting, folder, CRACKLE=OPTIONS.program, CRACKLE_MPI=start,
            **{key: value for key, value in environment().items() if key.startswith("OMPI")})

    def logs(self, job):
        """What a job has said, over all its starts and tasks."""
        return "\n".join(file.read_text(errors="replace") for file in sorted(self.parent.glob(f"**/crackle-{job}[-.]*log")))

    def assert_equal_results(self, setting, folder, job):
        faults = TRIALS.differences(setting.with_suffix(""), self.parent / folder)
        self.assertEqual([fault for fault in faults if "lock-" not in fault], [], self.logs(job))

    def test_a_job_suspends_and_is_requeued(self):
        # Other programs may leave the machine, and an ensemble be through before SLURM's warning.
        for sample_seconds in (SAMPLE_SECONDS, 2 * SAMPLE_SECONDS, 4 * SAMPLE_SECONDS):
            setting = self.plate(sample_seconds)
            folder = f"suspended-{sample_seconds:g}"
            job = self.submit("ensemble.sbatch", setting, folder, "--signal=B:USR1@52")
            states, restarts = self.cluster.wait(job, 300)
            print(f"ensemble.sbatch: {states}, started again {restarts} times")
            self.assertEqual(states, ["COMPLETED"], self.logs(job))
            self.assert_equal_results(setting, folder, job)
            if sum(restarts) > 0:
                break
        self.assertGreater(sum(restarts), 0)
        self.assertIn("SIGUSR1: stopping", self.logs(job))

    def test_a_killed_rank_is_no_end(self):
        setting = self.plate(QUICK_SECONDS)
        job = self.submit("ensemble.sbatch", setting, "killed", "--signal=B:USR1@1")
        end = time.monotonic() + 60
        while not list((self.parent / "killed" / "samples").glob("*.h5")) and time.monotonic() < end:
            time.sleep(0.1)
        for process in pathlib.Path("/proc").iterdir():
            try:
                words = (process / "cmdline").read_bytes().split(b"\0")
            except OSError:
                continue
            if process.name.isdigit() and words[0] == OPTIONS.program.encode() and b"killed" in words:
                os.kill(int(process.name), 9)
                break
        states, restarts = self.cluster.wait(job, 300)
        print(f"ensemble.sbatch with a killed rank: {states}, started again {restarts} times")
        self.assertEqual(states, ["COMPLETED"], self.logs(job))
        self.assertIn("start 2", self.logs(job))
        self.assert_equal_results(setting, "killed", job)

    def test_srun_from_another_folder(self):
        """Ranks by srun, with SLURM's own PMIx; script and input are elsewhere, results where the job was submitted."""
        if "pmix" not in self.cluster.call("srun", "--mpi=list"):
            self.skipTest("this SLURM has no PMIx")
        elsewhere = self.parent / "elsewhere"
        elsewhere.mkdir()
        setting = self.plate(QUICK_SECONDS)
        job = self.submit("ensemble.sbatch", setting, "out", "--signal=B:USR1@1", start="pmix", submitted_from=elsewhere)
        states, restarts = self.cluster.wait(job, 300)
        print(f"ensemble.sbatch with srun: {states}, started again {restarts} times")
        self.assertEqual(states, ["COMPLETED"], self.logs(job))
        self.assertIn("2 ranks: master on rank 0", self.logs(job))
        self.assert_equal_results(setting, "elsewhere/out", job)

    def test_array_of_ranges(self):
        setting = self.plate(SAMPLE_SECONDS)
        job = self.submit("array.sbatch", setting, "array", "--array=0-2", "--signal=B:USR1@54")
        states, restarts = self.cluster.wait(job, 300)
        print(f"array.sbatch: {states}, started again {restarts} times")
        self.assertEqual(states, 3 * ["COMPLETED"], self.logs(job))
        self.assertFalse((self.parent / "array" / "ensemble.h5").exists())
        result = subprocess.run([OPTIONS.program, "stats", self.parent / "array"], env=environment(),
                                capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn(f"{N_SAMPLES} samples: {N_SAMPLES} done", result.stdout)
        self.assert_equal_results(setting, "array", job)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", required=True, type=os.path.abspath)
    parser.add_argument("--keep", action="store_true", help="keep the folder of the cluster and the results")
    OPTIONS, rest = parser.parse_known_args()
    if reason := slurm_cluster.why_not():
        print(f"skipped: {reason}")
        sys.exit(77)
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
