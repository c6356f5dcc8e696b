# SPDX-License-Identifier: GPL-3.0-or-later
"""A SLURM cluster of one node on this machine: munged, slurmctld and slurmd of its own, in a folder of its own."""
import os
import pathlib
import shutil
import socket
import subprocess
import time

CONFIGURATION = """
ClusterName=crackle
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={daemon}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=5
CredType=cred/munge
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
SchedulerParameters=sched_interval=2,sched_min_interval=0,batch_sched_delay=0
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ReturnToService=2
KillWait=30
NodeName={host} NodeAddr=127.0.0.1 CPUs=8 State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP OverSubscribe=FORCE:4
"""


def why_not():
    """What this machine lacks for a cluster; empty when it lacks nothing."""
    path = os.environ.get("PATH", "") + ":/usr/sbin"
    missing = [name for name in ("munged", "slurmctld", "slurmd", "sbatch") if not shutil.which(name, path=path)]
    if missing:
        return f"{', '.join(missing)} not installed (packages slurm-wlm, munge)"
    return "" if os.geteuid() == 0 else "only root can start the daemons"


def free_ports(n):
    sockets = [socket.socket() for _ in range(n)]
    for each in sockets:
        each.bind(("127.0.0.1", 0))
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


class Cluster:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.daemons = []
        for name in ("state", "spool"):
            (self.folder / name).mkdir()
        controller, daemon = free_ports(2)
        (self.folder / "slurm.conf").write_text(CONFIGURATION.format(
            host=socket.gethostname().split(".")[0], controller=controller, daemon=daemon, folder=self.folder))
        self.environment = dict(os.environ, SLURM_CONF=str(self.folder / "slurm.conf"),
                                PATH=os.environ["PATH"] + ":/usr/sbin")

    def __enter__(self):
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        self._start("munged", "--foreground", "--force", f"--key-file={key}",
                    *(f"--{kind}={self.folder}/munge.{kind.split('-')[0]}" for kind in ("socket", "pid-file",
                                                                                       "log-file", "seed-file")))
        self._wait_for(lambda: (self.folder / "munge.socket").exists(), "munged")
        self._start("slurmctld", "-D")
        self._start("slurmd", "-D")
        self._wait_for(lambda: "idle" in self.call("sinfo", "-h", "-o", "%T"), "the node")
        return self

    def __exit__(self, *_):
        subprocess.run(["scancel", "--full", "--user=root"], env=self.environment, check=False,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(1)
        for daemon in reversed(self.daemons):
            daemon.terminate()
        for daemon in self.daemons:
            try:
                daemon.wait(10)
            except subprocess.TimeoutExpired:
                daemon.kill()

    def _start(self, *command):
        with open(self.folder / f"{command[0]}.out", "wb") as out:
            self.daemons.append(subprocess.Popen(command, env=self.environment, stdout=out, stderr=out,
                                                 start_new_session=True))

    def _wait_for(self, condition, what, seconds=30):
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                logs = "".join(f"\n{file}:\n{file.read_text(errors='replace')[-1500:]}"
                               for file in self.folder.glob("*.*") if file.suffix in (".log", ".out"))
                raise RuntimeError(f"{what} did not come up in {seconds} s{logs}")
            time.sleep(0.2)

    def call(self, *command):
        return subprocess.run(command, env=self.environment, check=False, capture_output=True, text=True,
                              timeout=60).stdout

    def submit(self, folder, *arguments, **environment):
        """Number of the job that sbatch makes of the arguments."""
        result = subprocess.run(["sbatch", "--parsable", *map(str, arguments)], cwd=folder, check=False,
                                env=dict(self.environment, **environment), capture_output=True, text=True, timeout=60)
        if result.returncode != 0:
            raise RuntimeError(result.stderr)
        return result.stdout.strip()

    def wait(self, job, seconds):
        """Waits for the job's end. Returns the number of times it was started again, for each task of it."""
        end = time.monotonic() + seconds
        while True:
            states = [line.split() for line in self.call("squeue", "-h", "-r", "-j", job, "-o", "%T").splitlines()]
            if not states or time.monotonic() > end:
                break
            time.sleep(0.5)
        shown = self.call("scontrol", "show", "job", job)
        restarts = [int(word.partition("=")[2]) for word in shown.split() if word.startswith("Restarts=")]
        finished = [word.partition("=")[2] for word in shown.split() if word.startswith("JobState=")]
        return finished, restarts
