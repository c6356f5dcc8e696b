#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What stands in the place of a file or folder of an ensemble: pipes, links, folders, files of other programs and of
other versions; folders that are moved, files that may not grow.
"""
import itertools
import os
import re
import shutil
import signal
import socket
import subprocess
import time

import h5py

import survival_fixture
from effort import repetitions
from survival_fixture import SMALL, SurvivalCase
from synthetic_ensemble import seal

FILES = ("ensemble.h5", "input.toml", "run.log", "lock-0-2", "lock-ensemble.h5", "samples/0001.h5", "samples/0001.checkpoint")
SECONDS = 60  # that a command may take which must not wait


def content(folder):
    """Everything that can be read in a folder."""
    return {str(path.relative_to(folder)): path.read_bytes() if path.is_file() else path.lstat().st_mode
            for path in folder.rglob("*")}


class Files(SurvivalCase):
    SLOW_SECONDS = 0.3

    def setUp(self):
        super().setUp()
        for name in ("moved", "elsewhere"):
            shutil.rmtree(self.root / name, ignore_errors=True)

    def at_once(self, *arguments, **options):
        """A command that must not wait for anything."""
        try:
            return self.call(*arguments, timeout=SECONDS, **options)
        except subprocess.TimeoutExpired:
            return self.fail(f"crackle {' '.join(map(str, arguments))} waits")

    def commands(self):
        run = ("run", self.small, "-o", self.out, "--resume")
        sample = ("sample", self.small, "--sample", "1", "-o", self.out, "--resume")
        compare = ("compare", self.out, self.whole(self.small))
        return {"stats": ("stats", self.out), "watch": ("watch", "--once", self.out), "compare": compare, "run": run,
                "sample": sample}

    def with_instead(self, name, make):
        """An ensemble with something else in the place of one of its files."""
        shutil.rmtree(self.out, ignore_errors=True)
        shutil.copytree(self.whole(self.small), self.out)
        (self.out / name).unlink(missing_ok=True)
        make(self.out / name)

    def without_waiting(self, make, kind, first=0, stride=1):
        """Each file and each command; of their pairs, which are counted along the files, every `stride`th from `first` on."""
        pairs = list(itertools.product(FILES, self.commands().items()))
        for name, (command, arguments) in pairs[first::stride]:
            with self.subTest(file=name, command=command):
                self.with_instead(name, make)
                before = content(self.out)
                result = self.at_once(*arguments)
                said = result.stdout + result.stderr
                self.assertIn(result.returncode, (0, 1), said)
                self.assertNotRegex(said, "HDF5|filesystem error|unable to|basic_")
                self.assertEqual(len(result.stderr.splitlines()), 0 if result.returncode == 0 else 1, said)
                if result.returncode == 1:
                    self.assertRegex(result.stderr, rf"{name}'?:? (it )?(is )?{kind}")
                    self.assertEqual(content(self.out), before)
                elif command in ("watch", "compare"):
                    self.assertEqual(content(self.out), before)
                if name == "ensemble.h5" and command in ("stats", "run"):
                    self.assertEqual(result.returncode, 1)

    def test_pipes_are_not_waited_for(self):
        self.without_waiting(os.mkfifo, "a named pipe", 0, repetitions(3, 1))

    def test_folders_in_the_place_of_files(self):
        self.without_waiting(os.mkdir, "a folder", 1, repetitions(3, 1))

    def test_links_that_lead_nowhere(self):
        def loop(path):
            path.symlink_to(path.name)
        self.without_waiting(loop, "(a broken link|a symbolic link)", 2, repetitions(3, 1))

    def test_a_link_to_a_file_stays_one(self):
        elsewhere = self.root / "elsewhere"
        elsewhere.mkdir()
        shutil.copytree(self.whole(self.small), self.out)
        shutil.move(self.out / "ensemble.h5", elsewhere / "results.h5")
        (elsewhere / "results.h5").write_bytes((elsewhere / "results.h5").read_bytes()[:5000])
        (self.out / "ensemble.h5").symlink_to(elsewhere / "results.h5")
        self.assert_complete(self.small, self.call("run", self.small, "-o", self.out, "--resume"))
        self.assertTrue((self.out / "ensemble.h5").is_symlink())
        self.assertEqual(sorted(path.name for path in elsewhere.iterdir()), ["results.h5"])

    def test_devices_are_not_replaced(self):
        device = self.root / "null"
        if subprocess.run(["mknod", device, "c", "1", "3"], check=False, stderr=subprocess.DEVNULL).returncode != 0:
            self.skipTest("no devices can be made here")
        result = self.at_once("mesh", self.small, "--sample", "0", "-o", device)
        self.assert_refused(result, "null': it is a device")
        self.assertTrue(device.is_char_device())

    def test_files_of_other_programs_stay(self):
        def other_hdf5(path, kind=None):
            with h5py.File(path, "w") as root:
                root["measured"] = [1.0, 2.0]
                if kind is not None:
                    root.attrs["kind"] = kind

        def sample_file(path):
            shutil.copy(self.out / "samples/0001.h5", path)

        foreign = "ensemble.h5 was not written by crackle"
        for make, reason in ((other_hdf5, foreign), (lambda path: other_hdf5(path, 3), foreign),
                             (lambda path: other_hdf5(path, "a measurement"), foreign),
                             (sample_file, "ensemble.h5 is a crackle sample file"),
                             (lambda path: path.write_text("my notes\n"), foreign)):
            for arguments, said in ((self.commands()["stats"], reason), (self.commands()["run"], reason),
                                    (("run", self.small, "-o", self.out), "already holds an ensemble")):
                self.with_instead("ensemble.h5", make)
                before = content(self.out)
                result = self.at_once(*arguments)
                self.assertEqual(result.returncode, 1, result.stdout + result.stderr)
                self.assertIn(said, result.stderr)
                self.assertEqual(content(self.out), before)

    def test_damaged_results_are_written_anew(self):
        whole = (self.whole(self.small) / "ensemble.h5").read_bytes()
        for damaged in (b"", whole[:100], whole[:len(whole) // 2], bytes(512) + whole[512:]):
            for command in ("stats",) if damaged else ("stats", "run"):
                self.with_instead("ensemble.h5", lambda path, data=damaged: path.write_bytes(data))
                self.assert_complete(self.small, self.call(*self.commands()[command]))

    def test_what_killed_ones_left_beside_a_lock_goes(self):
        shutil.copytree(self.whole(self.small), self.out)
        for name in ("lock-0-2.probe-node1-boot-1-2", "lock-0-2.stale-node1-boot-1-2", "lock-ensemble.h5.probe-node1-boot-1-2"):
            (self.out / name).write_text("\n")
            os.utime(self.out / name, (0, 0))  # of another host: only its age tells
        self.assertIn("no run is active here", self.at_once("watch", "--once", self.out).stdout)
        self.assert_complete(self.small, self.call("run", self.small, "-o", self.out, "--resume"))
        self.assertEqual(sorted(self.out.glob("lock-*")), [])

    # Two runs, one after the other.

    def test_who_waited_for_a_lock_plans_anew(self):
        for command in (("run", self.small, "-o", self.out), ("sample", self.small, "--sample", "2", "-o", self.out)):
            shutil.rmtree(self.out, ignore_errors=True)
            shutil.copytree(self.whole(self.small), self.out)
            for name in ("0001", "0002"):
                (self.out / "samples" / f"{name}.h5").rename(self.root / f"{name}.h5")
            # This process stands for the first run, which ends while the second one waits.
            lock = self.out / ("lock-0-2" if command[0] == "run" else "lock-2-2")
            lock.write_text(f"host {socket.gethostname()}\nprocess {os.getpid()}\nstart 0\njob -\n")
            second = self.start(*command, "--resume")
            time.sleep(1.5)
            self.assertIsNone(second.poll())
            for name in ("0001", "0002"):
                (self.root / f"{name}.h5").rename(self.out / "samples" / f"{name}.h5")
            lock.unlink()
            out, err = second.communicate(timeout=survival_fixture.TIMEOUT)
            self.assertIn("0 of 3 samples to compute" if command[0] == "run" else "it is kept", out)
            self.assert_complete(self.small, subprocess.CompletedProcess(command, second.returncode, out, err))

    def test_refused_inputs_leave_no_folder(self):
        thin = self.root / "thin.toml"
        thin.write_text(SMALL.replace('spacing = "1.5 mm"', 'spacing = "1 um"').replace('"0.6 mm"\ngrowth', '"1 um"\ngrowth'))
        for command in ("run", "sample"):
            more = ["--sample", "0"] if command == "sample" else []
            self.assert_refused(self.at_once(command, thin, "-o", self.out, *more))
            self.assertFalse(self.out.exists())

    # Folders that are moved.

    def move_while_it_runs(self, *arguments, n_ranks=1):
        process = self.start(*arguments, n_ranks=n_ranks)
        self.wait_for(lambda: (self.out / "samples" / "0000.h5").exists(), process)
        self.out.rename(self.root / "moved")
        out, err = process.communicate(timeout=survival_fixture.TIMEOUT)
        self.assertEqual(process.returncode, 2, out + err)
        self.assertFalse(self.out.exists(), out + err)
        self.assertEqual(list((self.root / "moved").glob("lock-*")), [])
        return out

    def test_a_folder_that_is_moved(self):
        out = self.move_while_it_runs("run", self.slow, "-o", self.out, n_ranks=3)
        self.assertIn("it or its folder was moved or removed during the run", out)
        (self.root / "moved").rename(self.out)
        self.assert_complete(self.slow, self.call("run", self.slow, "-o", self.out, "--resume"))

    def test_a_folder_that_is_removed(self):
        process = self.start("run", self.slow, "-o", self.out)
        self.wait_for(lambda: (self.out / "samples" / "0000.h5").exists(), process)
        self.freeze(process)
        shutil.rmtree(self.out)
        process.send_signal(signal.SIGCONT)
        out, err = process.communicate(timeout=survival_fixture.TIMEOUT)
        self.assertEqual(process.returncode, 2, out + err)
        self.assertIn("it or its folder was moved or removed during the run", out)
        self.assertFalse(self.out.exists())

    def test_a_range_whose_folder_is_moved(self):
        out = self.move_while_it_runs("run", self.slow, "-o", self.out, "--samples", "0-2")
        self.assertIn("nothing more was written", out)

    def test_a_sweep_whose_folder_is_moved(self):
        sweep = self.root / "slow-sweep.toml"
        sweep.write_text(self.slow.read_text() + '[[sweep]]\nkey = "ensemble.seed"\nvalues = [1, 2]\n')
        process = self.start("run", sweep, "-o", self.out)
        self.wait_for(lambda: (self.out / "case-0" / "samples" / "0000.h5").exists(), process)
        self.out.rename(self.root / "moved")
        out, err = process.communicate(timeout=survival_fixture.TIMEOUT)
        self.assertEqual(process.returncode, 2, out + err)
        self.assertFalse(self.out.exists(), out + err)
        self.assertEqual(list((self.root / "moved").glob("*/lock-*")), [])

    def test_a_copy_of_the_input_that_is_removed(self):
        process = self.start("run", self.slow, "-o", self.out)
        self.wait_for(lambda: (self.out / "samples" / "0000.h5").exists(), process)
        (self.out / "input.toml").unlink()
        out, err = process.communicate(timeout=survival_fixture.TIMEOUT)
        self.assertIn("the copy of the input was missing and has been written again", out)
        self.assert_complete(self.slow, subprocess.CompletedProcess((), process.returncode, out, err))

    # Files that may not grow.

    def test_a_limit_on_the_size_of_files(self):
        size = (self.whole(self.small) / "samples" / "0000.h5").stat().st_size // 2
        results_size = (self.whole(self.small) / "ensemble.h5").stat().st_size - 1000
        if subprocess.run(["sh", "-c", "ulimit -f 1 && ulimit -f"], capture_output=True, check=True).stdout != b"1\n":
            self.skipTest("this shell has no limit on files")
        for n_ranks, limit, text in ((3, size, r"sample \d failed .*writing: cannot write '.*\.h5': File too large"),
                                     (1, results_size, r"cannot write '.*ensemble.h5': .*File too large")):
            with self.subTest(n_ranks=n_ranks, limit=limit):
                shutil.rmtree(self.out, ignore_errors=True)
                launcher = [] if n_ranks == 1 else survival_fixture.mpirun(n_ranks)
                limited = ["sh", "-c", f'ulimit -f {limit // 512} && exec "$0" "$@"']
                result = self.call("run", self.small, "-o", self.out, launcher=[*launcher, *limited])
                self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
                self.assertRegex(result.stdout, text)
                self.assertNotRegex(result.stdout, r"cannot write '(.*)': cannot write '\1'")
                self.assertNotIn("signal", result.stderr)
                self.assert_complete(self.small, self.call("run", self.small, "-o", self.out, "--resume"))

    # Other versions.

    def test_samples_of_another_model_cannot_be_resumed(self):
        for model in (None, 1, 99):
            shutil.rmtree(self.out, ignore_errors=True)
            shutil.copytree(self.whole(self.small), self.out)
            for file in (self.out / "samples").iterdir():
                file.write_bytes(file.read_bytes()[:-32])  # without its check sum
                with h5py.File(file, "r+") as root:
                    root.attrs.pop("model_version")
                    if model is not None:
                        root.attrs["model_version"] = model
                seal(file)
            (self.out / "samples" / "0002.h5").unlink()
            before = content(self.out)
            again = ("sample", self.small, "--sample", "2", "-o", self.out, "--overwrite")
            part = ("run", self.small, "-o", self.out, "--resume", "--samples", "2-2")
            for arguments in (self.commands()["run"], self.commands()["sample"], again, part):
                result = self.at_once(*arguments)
                self.assert_refused(result, f"model {model or 1}, of version", "continue with the program that started")
                self.assertEqual(content(self.out), before)
            result = self.at_once("stats", self.out)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn("2 done", result.stdout)
            self.assertIn(f"these samples are of model {model or 1}; this program's model", result.stdout)

    def change(self, name, change):
        """An ensemble in which one sample file was changed and sealed again; there is no ensemble.h5."""
        self.with_instead("ensemble.h5", lambda path: None)
        file = self.out / "samples" / name
        file.write_bytes(file.read_bytes()[:-32])  # without its check sum
        with h5py.File(file, "r+") as root:
            change(root)
        seal(file)

    def test_a_sample_of_another_model_belongs_to_no_ensemble(self):
        def other_model(root):
            root.attrs["model_version"] = 99
        for name, number in (("0001.h5", 1), ("0002.h5", 2)):
            self.change(name, other_model)
            reason = f"cannot use '{self.out / 'samples' / name}': model 99, of version .* of the program; the other samples are of model "
            result = self.at_once("stats", "--read-only", self.out)
            self.assertEqual((result.returncode, result.stderr), (0, ""))
            self.assertRegex(result.stdout, "2 done, 0 failed, 1 pending")
            self.assertRegex(result.stdout, f"pending sample {number}: {reason}")
            result = self.at_once("compare", self.whole(self.small), self.out)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertRegex(result.stderr, f"^sample {number} is left out: {reason}")
            result = self.at_once("match", self.out, "--held-out", "each")
            self.assertRegex(result.stderr, f"sample {number} is left out: {reason}")

    def test_numbers_that_are_none_are_named_with_their_file(self):
        def no_corner(root):
            root["crack_surface/corners"][0, 0, 0] = float("nan")
        self.change("0001.h5", no_corner)
        reason = f"cannot use '{self.out / 'samples/0001.h5'}': the corners, time or area of facet 0 of its crack are not numbers"
        result = self.at_once("stats", "--sections", "y=5 mm", self.out)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertIn(f"pending sample 1: {reason}", result.stdout)

        def no_place(root):
            root["crack_lines/position"][0, 0] = float("nan")
        self.change("0001.h5", no_place)
        result = self.at_once("match", self.out, "--held-out", "each")
        self.assertIn(f"sample 1 is left out: cannot use '{self.out / 'samples/0001.h5'}': places of its crack lines are not numbers", result.stderr)

    def test_samples_of_earlier_models_shared_their_base_points_unless_the_input_says_otherwise(self):
        shutil.copytree(self.whole(self.small), self.out)
        said = 'base = "shared"\n'
        self.assertIn(said, SMALL)
        (self.out / "input.toml").write_text(SMALL.replace(said, ""))
        (self.out / "ensemble.h5").unlink()
        for file in (self.out / "samples").iterdir():
            file.write_bytes(file.read_bytes()[:-32])  # without its check sum
            with h5py.File(file, "r+") as root:
                root.attrs["model_version"] = 4
                root.attrs["input"] = SMALL.replace(said, "")
            seal(file)
        for _ in range(2):  # with and without ensemble.h5
            result = self.at_once("stats", self.out)
            self.assertEqual((result.returncode, result.stderr), (0, ""))
            self.assertIn("3 done", result.stdout)
            self.assertIn("hold for this base (one set of mother points)", result.stdout)
        with h5py.File(self.out / "ensemble.h5") as root:
            self.assertIn(said, root.attrs["input"])
            self.assertIn("mother_points", root)

    # What is given.

    def test_the_results_may_be_given_for_their_folder(self):
        folder = self.whole(self.small)
        for arguments in (("stats", "--read-only"), ("watch", "--once"), ("compare", folder)):
            of_folder, of_file = (self.at_once(*arguments, given) for given in (folder, folder / "ensemble.h5"))
            self.assertEqual(of_file.returncode, 0, of_file.stderr)
            if arguments[0] != "watch":  # which shows the log
                self.assertEqual(of_file.stdout.replace("/ensemble.h5", ""), of_folder.stdout)
            self.assert_refused(self.at_once(*arguments, folder / "samples" / "0001.h5"), "0001.h5 is the file of one sample",
                                f"give the ensemble's folder, {folder}")
            self.assert_refused(self.at_once(*arguments, self.small), "is a file; give the folder of an ensemble")

    def test_equal_cases_of_a_sweep_are_reported(self):
        sweep = self.root / "sweep.toml"
        sweep.write_text(SMALL.replace("samples = 3", "samples = 1") +
                         '[[sweep]]\nkey = "mesh.perturbation"\nvalues = [0.1, 0.05, 0.10]\n')
        result = self.call("run", sweep, "-o", self.out)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertEqual(re.findall("warning: cases .*", result.stdout),
                         ["warning: cases 0, 2 of the sweep are identical, so their samples are too: mesh.perturbation = 0.1"])

    # SLURM.

    def test_ranks_that_do_not_find_each_other(self):
        step = {"SLURM_JOB_ID": "7", "SLURM_PROCID": "1", "SLURM_STEP_NUM_TASKS": "3", "SLURM_NTASKS": "3"}
        task = ["sh", "-c", 'SLURM_TASK_PID=$$ exec "$0" "$@"']
        result = self.at_once("run", self.small, "-o", self.out, extra_environment=step, launcher=task)
        self.assert_refused(result, "srun started 3 tasks, but MPI sees only 1", "srun --mpi=pmix")
        self.assertFalse(self.out.exists())
        of_shell = {**step, "SLURM_TASK_PID": str(os.getpid())}
        for arguments, options in ((["--part", "1/3"], {"extra_environment": step, "launcher": task}),
                                   (["--resume"], {"extra_environment": of_shell})):
            result = self.at_once("run", self.small, "-o", self.out, *arguments, **options)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn("srun started 3 tasks, but MPI sees only 1", result.stderr)
        script = {**step, "SLURM_PROCID": "0"}
        del script["SLURM_STEP_NUM_TASKS"]
        result = self.at_once("run", self.small, "-o", self.out, "--resume", extra_environment=script)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("the SLURM job has 3 tasks, and this run uses 1", result.stderr)
        for quiet in ({**script, "SLURM_NTASKS": "1"}, {**step, "SLURM_STEP_NUM_TASKS": "1", "SLURM_NTASKS": "1"}):
            result = self.at_once("run", self.small, "-o", self.out, "--resume", extra_environment=quiet)
            self.assertEqual((result.returncode, result.stderr), (0, ""))


if __name__ == "__main__":
    survival_fixture.main(__doc__)
