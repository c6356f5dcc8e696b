#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What jobs/ensemble.sbatch and jobs/array.sbatch do with the program's statuses and with SLURM's numbers of an array;
srun and scontrol are stand-ins that note how they are called.
"""
import argparse
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from crackle_launch import environment, mpirun  # noqa: E402

OPTIONS = None


class Jobs(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="crackle jobs-"))
        self.addCleanup(shutil.rmtree, self.folder)
        shutil.copytree(ROOT / "jobs", self.folder / "jobs", ignore=shutil.ignore_patterns("images"))

    def stand_in(self, name, text):
        file = self.folder / name
        file.write_text(f'#!/bin/bash\necho "$@" >>"{self.folder}/{name}.calls"\n{text}\n')
        file.chmod(0o755)

    def calls(self, name):
        file = self.folder / f"{name}.calls"
        return file.read_text().splitlines() if file.exists() else []

    def job(self, script, ranks, copy=None, **settings):
        """Runs a script, or a copy of it, whose ranks do what the shell's words `ranks` say."""
        for name in ("srun", "scontrol"):
            (self.folder / f"{name}.calls").unlink(missing_ok=True)
        self.stand_in("srun", ranks)
        # Only what changes something is noted: where the script lies is asked for as well.
        (self.folder / "scontrol").write_text(
            f'#!/bin/bash\nif [[ $1 == show ]]; then echo "   Command={self.folder}/jobs/{script} plate.toml out"; exit; fi\n'
            f'echo "$@" >>"{self.folder}/scontrol.calls"\n')
        (self.folder / "scontrol").chmod(0o755)
        inherited = {name: value for name, value in os.environ.items() if not name.startswith(("SLURM_", "CRACKLE_"))}
        return subprocess.run(["bash", str(copy or f"jobs/{script}"), "plate.toml", "out"], cwd=self.folder, text=True, timeout=60,
                              env={**inherited, "PATH": f"{self.folder}:{os.environ['PATH']}", "SLURM_JOB_ID": "7",
                                   **{name: str(value) for name, value in settings.items()}},
                              capture_output=True, check=False)

    def array(self, number, numbers, ranks="exit 0", **settings):
        return self.job("array.sbatch", ranks, SLURM_ARRAY_TASK_ID=number, SLURM_ARRAY_TASK_COUNT=len(numbers),
                        SLURM_ARRAY_TASK_MIN=min(numbers), SLURM_ARRAY_TASK_MAX=max(numbers), **settings)

    def test_jobs_of_a_whole_array_compute_their_parts(self):
        for number in range(3):
            result = self.array(number, range(3))
            self.assertEqual((result.returncode, result.stderr), (0, ""))
            self.assertEqual(self.calls("srun"),
                             [f"--mpi=pmix {self.folder}/build/bin/crackle run plate.toml -o out --resume --part {number}/3"])

    def test_scripts_are_submitted_from_any_folder(self):
        elsewhere = self.folder / "elsewhere"
        elsewhere.mkdir()
        for script, numbers in (("ensemble.sbatch", {}), ("array.sbatch", {"SLURM_ARRAY_TASK_ID": 1, "SLURM_ARRAY_TASK_COUNT": 2,
                                                                           "SLURM_ARRAY_TASK_MIN": 0, "SLURM_ARRAY_TASK_MAX": 1})):
            # As SLURM does, from a copy of the script.
            copy = self.folder / "spool" / "slurm_script"
            copy.parent.mkdir(exist_ok=True)
            shutil.copy(self.folder / "jobs" / script, copy)
            result = self.job(script, "exit 0", copy=copy, SLURM_SUBMIT_DIR=elsewhere, **numbers)
            self.assertEqual((result.returncode, result.stderr), (0, ""))
            self.assertIn(f"{self.folder}/build/bin/crackle run plate.toml -o out --resume", self.calls("srun")[0])

    def test_a_task_of_an_array_goes_back_alone(self):
        """Also the last one, whose job number is that of the whole array."""
        for job in (7, 9):
            result = self.array(1, range(2), "exit 3", SLURM_JOB_ID=job, SLURM_ARRAY_JOB_ID=7)
            self.assertEqual(result.returncode, 3, result.stderr)
            self.assertEqual(self.calls("scontrol"), ["requeue 7_1"])

    def test_modules_are_loaded_before_the_ranks_start(self):
        start = self.folder / "modules" / "init"
        start.mkdir(parents=True)
        (start / "bash").write_text(f'module() {{ echo "$@" >>"{self.folder}/module.calls"; }}\n')
        result = self.job("ensemble.sbatch", "exit 0", CRACKLE_MODULES="gcc/12 openmpi", MODULESHOME=self.folder / "modules")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertEqual(self.calls("module"), ["load gcc/12 openmpi"])

    def test_other_arrays_need_the_number_of_parts(self):
        for numbers in ([3], [0], [3, 7], range(0, 19, 2), range(1, 11), [0, 2]):
            result = self.array(numbers[-1], numbers)
            self.assertEqual(result.returncode, 1, numbers)
            self.assertIn("CRACKLE_PARTS=N", result.stderr)
            self.assertEqual(self.calls("srun"), [])
            result = self.array(numbers[-1], numbers, CRACKLE_PARTS=20)
            self.assertEqual((result.returncode, result.stderr), (0, ""))
            self.assertTrue(self.calls("srun")[0].endswith(f"--resume --part {numbers[-1]}/20"))

    def test_the_programs_refusal_is_the_jobs_end(self):
        result = self.job("ensemble.sbatch", "exit 1")
        self.assertEqual((result.returncode, len(self.calls("srun")), self.calls("scontrol")), (1, 1, []))

    def test_a_job_whose_time_is_up_goes_back_into_the_queue_so_many_times(self):
        for n_before, settings, goes_back in ((None, {}, True), (19, {}, True), (20, {}, False),
                                              (2, {"CRACKLE_REQUEUES": 2}, False), (0, {"CRACKLE_REQUEUES": 0}, False)):
            if n_before is not None:
                settings = {**settings, "SLURM_RESTART_COUNT": n_before}
            result = self.job("ensemble.sbatch", "exit 3", **settings)
            self.assertEqual(result.returncode, 3)
            self.assertEqual(len(self.calls("srun")), 1)
            self.assertEqual(self.calls("scontrol"), ["requeue 7"] if goes_back else [], settings)
            if not goes_back:
                self.assertIn(f"after {n_before} requeues", result.stdout)

    def test_a_failure_inside_is_a_crash_on_any_number_of_ranks(self):
        for n_ranks in (1, 2, 3):
            result = subprocess.run([*mpirun(n_ranks), OPTIONS.failing_command], env=environment(), text=True, timeout=60,
                                    capture_output=True, check=False)
            self.assertEqual(result.returncode, 134, result.stderr)
            self.assertIn(f"crackle: rank {n_ranks - 1}: this rank is out of order", result.stderr)

    def test_crashes_are_started_again_so_many_times_and_are_no_time_limit(self):
        for status in (134, 137):
            result = self.job("ensemble.sbatch", f"exit {status}", CRACKLE_STARTS=3)
            self.assertEqual(result.returncode, status)
            self.assertEqual(len(self.calls("srun")), 3)
            self.assertEqual(self.calls("scontrol"), [])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--failing-command", required=True, type=os.path.abspath)
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
