#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""crackle run under adversity: signals, time limits, a second run, changed inputs, damaged files, full and vanished
disks.
"""
import os
import pathlib
import random
import re
import shutil
import signal
import socket
import subprocess
import time

import h5py

import survival_fixture
from survival_fixture import SMALL, TRIALS, SurvivalCase

SUSPEND_SECONDS = 10  # within which a run of this size has suspended


class Survival(SurvivalCase):
    # Signals and time.

    def test_signals_suspend_and_a_second_one_ends_at_once(self):
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGUSR1):
            with self.subTest(number):
                shutil.rmtree(self.out, ignore_errors=True)
                process = self.start("run", self.slow, "-o", self.out)
                self.wait_for(lambda: (self.out / "samples" / "0000.h5").exists(), process)
                start = time.monotonic()
                process.send_signal(number)
                out, err = process.communicate(timeout=SUSPEND_SECONDS)
                print(f"{number.name}: suspended in {time.monotonic() - start:.2f} s")
                self.assertEqual(process.returncode, 3, out + err)
                self.assertIn(f"{number.name}: stopping\n", out)
                self.assertFalse(list(self.out.glob("lock-*")))
        self.assert_complete(self.slow, self.call("run", self.slow, "-o", self.out, "--resume"))
        shutil.rmtree(self.out)
        process = self.start("run", self.slow, "-o", self.out)
        self.wait_for(lambda: (self.out / "samples" / "0000.h5").exists(), process)
        process.send_signal(signal.SIGTERM)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=2)
        self.assertEqual(process.returncode, 3)
        self.assertTrue(list(self.out.glob("lock-*")), "it took the time to end in order")

    def test_time_limits_suspend(self):
        result = self.call("run", self.slow, "-o", self.out, "--time-limit", "0.5s")
        self.assertEqual(result.returncode, 3, result.stdout + result.stderr)
        self.assertIn("the time limit of 0 s: stopping", result.stdout)
        shutil.rmtree(self.out)
        result = self.call("run", self.slow, "-o", self.out,
                           extra_environment={"SLURM_JOB_END_TIME": str(int(time.time()))})
        self.assertEqual(result.returncode, 3, result.stdout + result.stderr)
        self.assertIn(f"to continue: {survival_fixture.PROGRAM} run {self.slow} -o {self.out} --resume\n", result.stdout)
        result = self.call("run", self.slow, "-o", self.out, "--resume")
        self.assertIn(f"pictures and report: tools/crackle-report {self.out}\n", result.stdout)
        self.assert_complete(self.slow, result)

    # What a folder holds.

    def test_a_second_run_is_refused(self):
        process = self.start("run", self.slow, "-o", self.out)
        self.wait_for(lambda: (self.out / "input.toml").exists(), process)
        self.freeze(process)
        self.assert_refused(self.call("run", self.slow, "-o", self.out, "--resume"), "another run is active",
                            f"process {process.pid} on ", "lock-0-2")
        self.assert_refused(self.call("run", self.slow, "-o", self.out, "--resume", "--samples", "1-2"),
                            "another run is computing some of these samples")
        self.kill(process)
        result = self.call("run", self.slow, "-o", self.out, "--resume")
        self.assertIn("is taken over: process", result.stdout)
        self.assert_complete(self.slow, result)

    def test_locks_of_other_hosts_and_of_the_same_job(self):
        shutil.copytree(self.whole(self.small), self.out)
        lock = self.out / "lock-0-2"
        lock.write_text("host elsewhere\nprocess 12\nstart 34\njob 56\n")
        self.assert_refused(self.call("run", self.small, "-o", self.out, "--resume"),
                            "process 12 on elsewhere, SLURM job 56")
        os.utime(lock, (time.time() - 3600, time.time() - 3600))
        self.assert_complete(self.small, self.call("run", self.small, "-o", self.out, "--resume"))
        lock.write_text("host elsewhere\nprocess 12\nstart 34\njob 56\n")
        requeued = {"SLURM_JOB_ID": "56", "SLURM_STEP_ID": "0", "SLURM_RESTART_COUNT": "1"}
        result = self.call("run", self.small, "-o", self.out, "--resume", extra_environment=requeued)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("is an earlier start of this job", result.stdout)
        # Another step of this start of the job, on another node.
        lock.write_text("host elsewhere\nprocess 12\nstart 34\njob 56\nrestart 1\nstep 1\n")
        self.assert_refused(self.call("run", self.small, "-o", self.out, "--resume", extra_environment=requeued),
                            "process 12 on elsewhere, SLURM job 56 step 1, restart 1")
        # Of this host, but of a process number that another process has now.
        lock.write_text(f"host {socket.gethostname()}\nprocess {os.getpid()}\nstart 1\njob -\n")
        self.assert_complete(self.small, self.call("run", self.small, "-o", self.out, "--resume"))

    def test_process_namespaces_do_not_mix(self):
        contained = ["unshare", "--pid", "--fork"]
        if subprocess.run([*contained, "true"], check=False, stderr=subprocess.DEVNULL).returncode != 0:
            self.skipTest("no process namespaces can be made here")
        for kind in ("its own /proc", "the host's /proc"):
            with self.subTest(kind):
                shutil.rmtree(self.out, ignore_errors=True)
                launcher = [*contained, "--mount-proc"] if kind == "its own /proc" else contained
                process = self.start("run", self.slow, "-o", self.out, launcher=launcher)
                self.wait_for(lambda: (self.out / "input.toml").exists(), process)
                child = int(pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text())
                os.kill(child, signal.SIGSTOP)
                number = next(line.split()[1] for line in (self.out / "lock-0-2").read_text().splitlines()
                              if line.startswith("process "))
                self.assertNotEqual(int(number), child, "the lock has the number of the namespace")
                # From outside, and from another namespace, in which the number is the reader's own.
                for other in ([], launcher):
                    self.assert_refused(self.call("run", self.slow, "-o", self.out, "--resume", launcher=other),
                                        "another run is active", f"process {number} on ")
                os.kill(child, signal.SIGKILL)
                process.communicate()
        # Nobody here can know that it has ended.
        self.assert_refused(self.call("run", self.slow, "-o", self.out, "--resume"), "another run is active")
        os.utime(self.out / "lock-0-2", (time.time() - 3600, time.time() - 3600))
        result = self.call("run", self.slow, "-o", self.out, "--resume", "--time-limit", "0.5s")
        self.assertRegex(result.stdout, f"is taken over: process {number} on .* has not updated it for 60 min")

    def test_other_inputs_are_refused_with_the_differences(self):
        shutil.copytree(self.whole(self.small), self.out)
        self.assert_refused(self.call("run", self.small, "-o", self.out), "already holds an ensemble", "--resume")
        other = self.root / "other.toml"
        other.write_text(SMALL.replace("0.38", "0.37").replace("seed = 1", "seed = 2"))
        self.assert_refused(self.call("run", other, "-o", self.out, "--resume"), "ensemble.seed is 2, not 1",
                            "material.poisson_ratio is 0.37, not 0.38")
        other.write_text(SMALL.replace("samples = 3", "samples = 2"))
        self.assert_refused(self.call("run", other, "-o", self.out, "--resume"), "ensemble.samples is 2, fewer than 3")

    def test_more_samples_extend_the_ensemble(self):
        more = self.root / "more.toml"
        more.write_text("# more\n" + SMALL.replace("samples = 3", "samples = 5"))
        shutil.copytree(self.whole(self.small), self.out)
        result = self.call("run", more, "-o", self.out, "--resume")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertIn("2 of 5 samples to compute", result.stdout)
        at_once = self.root / "at-once"
        self.assertEqual(self.call("run", more, "-o", at_once).returncode, 0)
        # Only the text of the input differs, in the files of the first samples.
        different = TRIALS.differences(at_once, self.out)
        self.assertEqual(different, [f"samples/{i:04}.h5" for i in range(3)])

    def assert_computed_again(self, *names):
        """Continues; the files must be named, set aside and computed again."""
        result = self.call("run", self.small, "-o", self.out, "--resume")
        for name in names:
            self.assertIn(f"{name}.invalid-1 and the sample computed again", result.stdout)
        aside = sorted((self.out / "samples").glob("*.invalid-*"))
        self.assertEqual([file.name for file in aside], [f"{name}.invalid-1" for name in sorted(names)])
        for file in aside:
            file.unlink()
        self.assert_complete(self.small, result)
        return result.stdout

    def test_damaged_files_are_set_aside_and_computed_again(self):
        generator = random.Random(7)
        shutil.copytree(self.whole(self.small), self.out)
        files = sorted((self.out / "samples").iterdir())
        faults = {
            "a bit flipped": lambda data, at: data[:at] + bytes([data[at] ^ 1 << at % 8]) + data[at + 1:],
            "cut": lambda data, at: data[:at],
            "512 bytes zeroed": lambda data, at: data[:at] + bytes(512) + data[at + 512:],
            "a byte too many": lambda data, at: data[:at] + b"x" + data[at:],
        }
        n_rounds = 2
        for number in range(n_rounds):
            for i, file in enumerate(files):
                # Each file is hit in its own order, and every part of it once.
                data = file.read_bytes()
                region = (number * 3 + i) % n_rounds
                at = (region * len(data) + generator.randrange(len(data))) // n_rounds
                damaged = list(faults.values())[(number + i) % len(faults)](data, at)
                file.write_bytes(damaged if damaged != data else data[:-1])
            self.assert_computed_again(*(file.name for file in files))
        print(f"{n_rounds * len(files)} damaged files found and computed again")
        shutil.copy(self.whole(self.small) / "samples" / "0000.h5", files[2])
        (self.out / "samples" / "0001.h5").unlink()
        (self.out / "samples" / "0001.checkpoint").write_bytes(b"rubbish")
        self.assertIn("holds sample 0 instead of 2", self.assert_computed_again("0001.checkpoint", "0002.h5"))

    def test_files_of_an_older_version_cannot_be_resumed(self):
        shutil.copytree(self.whole(self.small), self.out)
        file = self.out / "samples" / "0001.h5"
        with open(file, "r+b") as stream:
            stream.truncate(file.stat().st_size - 32)  # the check sum
        with h5py.File(file, "r+") as root:
            version = int(root.attrs["schema_version"])
            root.attrs["schema_version"] = version - 1
        data = file.read_bytes()
        value = 0xCBF29CE484222325
        for byte in data:
            value = (value ^ byte) * 0x100000001B3 % 2**64
        file.write_bytes(data + b"\ncrackle FNV-1a %016x" % value)
        before = file.read_bytes()
        result = self.call("run", self.small, "-o", self.out, "--resume")
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertRegex(result.stderr, rf"0001\.h5': version {version - 1} of the file format, written by .*; this program "
                         rf"writes version {version}; continue with the program that started this ensemble")
        self.assertEqual(file.read_bytes(), before)

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
            self.assertEqual(TRIALS.differences(self.whole(self.small), mount / "out"), [])
            subprocess.run(["mount", "-o", "remount,ro", mount], check=True)
            self.assert_refused(self.call("run", self.small, "-o", mount / "new"), "Read-only file system")
            self.assert_refused(self.call("run", self.small, "-o", mount / "out", "--resume"), "Read-only file system")
        finally:
            subprocess.run(["umount", mount], check=True)

    def test_folders_that_cannot_be(self):
        (self.root / "plain").write_text("a file")
        self.assert_refused(self.call("run", self.small, "-o", self.root / "plain"), "is not a folder")
        self.assert_refused(self.call("run", self.small, "-o", self.root / "plain" / "out"), "cannot make the folder")
        self.assert_refused(self.call("run", self.small, "-o", "/proc/crackle"), "cannot make the folder")

    # Failures and ranges.

    # A thread's first allocation reserves 128 MB of addresses for a moment, in some runs and not in others.
    ONE_ARENA = {"MALLOC_ARENA_MAX": "1"}

    def status_of_rank(self, rank, process):
        """The file in which the system says how much memory a rank of a run has; nothing before it has begun."""
        for entry in pathlib.Path("/proc").iterdir():
            try:
                if entry.name.isdigit() and os.readlink(entry / "exe") == survival_fixture.PROGRAM:
                    parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
                    if process.pid not in (int(entry.name), parent):
                        continue
                    name = re.search(rb"(?:^|\0)OMPI_COMM_WORLD_RANK=(\d+)", (entry / "environ").read_bytes())
                    if int(name[1] if name else 0) == rank:
                        return entry / "status"
            except (OSError, IndexError):
                continue  # has ended meanwhile
        return None

    def peak_of_addresses(self, rank, *arguments, **options):
        """Most addresses that a rank of a run has had until its end [byte]."""
        process = self.start(*arguments, extra_environment=self.ONE_ARENA, **options)
        peak, status = 0, None
        while process.poll() is None:
            status = status or self.status_of_rank(rank, process)
            try:
                peak = max(peak, int(re.search(r"VmPeak:\s*(\d+)", status.read_text())[1])) if status else peak
            except (OSError, TypeError):
                pass  # has ended
            time.sleep(0.002)
        out, err = process.communicate()
        self.assertEqual(process.returncode, 0, out + err)
        return 1024 * peak

    def test_a_group_ends_when_one_rank_has_no_memory(self):
        if b"__asan_init" in pathlib.Path(survival_fixture.PROGRAM).read_bytes():
            self.skipTest("the address sanitizer needs all addresses")
        # The frames, 120 MB, are kept on the first rank of the group; the other one must not wait for it.
        setting = self.root / "group.toml"
        text = SMALL.replace("samples = 3", "samples = 1\nranks_per_sample = 2").replace('step = "auto"', 'step = "20 ns"')
        text = text.replace('"1.5 mm"', '"0.7 mm"').replace('"0.6 mm"\ngrowth', '"0.5 mm"\ngrowth')
        setting.write_text(text.replace("frames = 4", "frames = 1").replace('duration = "60 us"', 'duration = "6 us"'))
        limit = self.peak_of_addresses(1, "run", setting, "-o", self.root / "few-in-groups", n_ranks=3)
        setting.write_text(text.replace("frames = 4", "frames = 3000"))
        run = [survival_fixture.PROGRAM, "run", setting, "-o", self.out]
        limited = ["sh", "-c", f'ulimit -v {limit // 1024} && exec "$0" "$@"', *run]
        command = [*survival_fixture.mpirun(1), *run, ":", "-n", "1", *limited, ":", "-n", "1", *run]
        result = subprocess.run(list(map(str, command)), env=survival_fixture.environment(**self.ONE_ARENA),
                                text=True, capture_output=True, check=False, timeout=survival_fixture.TIMEOUT)
        self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
        self.assertRegex(result.stdout, r"sample 0 failed after .*: computation: .*std::bad_alloc")

    def test_retry_failed_when_the_cause_is_gone(self):
        if b"__asan_init" in pathlib.Path(survival_fixture.PROGRAM).read_bytes():
            self.skipTest("the address sanitizer needs all addresses")
        # A limit of memory that the frames do not keep to, and that is lifted afterwards.
        setting = self.root / "frames.toml"
        text = SMALL.replace("samples = 3", "samples = 1").replace('step = "auto"', 'step = "8 ns"').replace('"60 us"', '"20 us"')
        setting.write_text(text.replace("frames = 4", "frames = 1"))
        limit = self.peak_of_addresses(0, "run", setting, "-o", self.root / "few")
        setting.write_text(text.replace("frames = 4", "frames = 2500"))
        self.whole(setting)
        result = self.call("run", setting, "-o", self.out, memory_limit=limit, extra_environment=self.ONE_ARENA)
        self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
        self.assertRegex(result.stdout, r"sample 0 failed after .*: computation: (frame|fragments|time steps): there is not enough memory \(std::bad_alloc\)")
        result = self.call("run", setting, "-o", self.out, "--resume")
        self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
        self.assertIn("1 failed", result.stdout)
        self.assert_complete(setting, self.call("run", setting, "-o", self.out, "--retry-failed"))

    def test_options_in_the_environment_change_nothing(self):
        result = self.call("run", self.small, "-o", self.out, extra_environment={  # read when PETSc starts
            "PETSC_OPTIONS": "-ksp_rtol 0.1 -ksp_max_it 2 -pc_type none -log_view -options_left",
            "PETSC_OPTIONS_YAML": "ksp_rtol: 0.1"})
        self.assertNotIn("Performance", result.stdout)
        self.assertEqual(result.stderr, "")
        self.assert_complete(self.small, result)

    def test_ranges_are_merged_by_stats(self):
        for part in ("0-0", "1-2"):
            result = self.call("run", self.small, "-o", self.out, "--resume", "--samples", part)
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
            self.assertFalse((self.out / "ensemble.h5").exists())
        self.assert_complete(self.small, self.call("stats", self.out))
        shutil.rmtree(self.out)
        for part, samples in (("0/2", "samples 0 to 0"), ("1/2", "samples 1 to 2")):
            result = self.call("run", self.small, "-o", self.out, "--resume", "--part", part)
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
            self.assertIn(samples, result.stdout)
        self.assert_complete(self.small, self.call("stats", self.out))
        for part in ("3", "2-1", "1-", "-1", "x", "0--1", "+0-1", "0- 1", "0-1x"):
            result = self.call("run", self.small, "-o", self.out, "--resume", f"--samples={part}")
            self.assertEqual(result.returncode, 1, part)


if __name__ == "__main__":
    survival_fixture.main(__doc__)
