"""A Slurm cluster of this machine alone, in a folder of its own: munged, slurmctld and slurmd. Needs root and Debian's packages."""

import contextlib
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import time

PROGRAMS = ["munged", "mungekey", "slurmctld", "slurmd", "sbatch", "srun", "squeue", "scontrol"]
CONFIGURATION = """\
ClusterName=rayframe
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmdPort={port_of_node}
SlurmUser=root
AuthType=auth/munge
# The time for which a credential of a step is valid is also the delay of a requeued job.
AuthInfo=socket={folder}/munge.socket,cred_expire=5
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
SchedulerParameters=sched_interval=1,sched_min_interval=0,bf_interval=1
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
ReturnToService=2
SlurmdTimeout=10
KillWait=5
MpiDefault=none
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} RealMemory=4000 State=UNKNOWN
PartitionName=low Nodes={host} Default=YES MaxTime=INFINITE PriorityTier=1 PreemptMode=REQUEUE GraceTime=5 State=UP
PartitionName=high Nodes={host} MaxTime=INFINITE PriorityTier=10 PreemptMode=OFF State=UP
"""


def missing():
    """Programs that are not installed, or a privilege that is not there."""
    if os.geteuid() != 0:
        return "root"
    lacking = [program for program in PROGRAMS if not shutil.which(program, path=search_path())]
    return ", ".join(lacking)


def search_path():
    return os.environ.get("PATH", "") + ":/usr/sbin:/sbin"


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


class Cluster:
    """The daemons, as children of this process. They end with the block."""

    def __init__(self, folder, cpus):
        self.folder, self.cpus, self.daemons = pathlib.Path(folder), cpus, {}
        self.environment = os.environ | {"SLURM_CONF": str(self.folder / "slurm.conf"), "PATH": search_path()}

    def __enter__(self):
        try:
            self.begin()
        except BaseException:
            self.__exit__()
            raise
        return self

    def begin(self):
        for name in ["state", "spool"]:
            (self.folder / name).mkdir(parents=True)
        os.chmod(self.folder, 0o755)
        self.host = socket.gethostname().split(".")[0]
        text = CONFIGURATION.format(host=self.host, folder=self.folder, cpus=self.cpus, port=free_port(), port_of_node=free_port())
        (self.folder / "slurm.conf").write_text(text)
        self.run("mungekey", "--create", "--keyfile", self.folder / "munge.key")
        at = lambda name: f"{self.folder}/munge.{name}"
        self.start("munged", "--foreground", "--force", f"--socket={at('socket')}", f"--key-file={at('key')}",
                   f"--pid-file={at('pid')}", f"--log-file={at('log')}", f"--seed-file={at('seed')}")
        self.wait_for(lambda: (self.folder / "munge.socket").exists(), "munged")
        self.start("slurmctld", "-D")
        self.start("slurmd", "-D", "-N", self.host)
        self.wait_for(lambda: "State=IDLE" in self.run("scontrol", "show", "node"), "the node")

    def __exit__(self, *_):
        if "slurmd" in self.daemons:
            for job in self.jobs():
                self.run("scancel", job)
        for daemon in reversed(self.daemons.values()):
            daemon.terminate()
            try:
                daemon.wait(10)
            except subprocess.TimeoutExpired:
                daemon.kill()

    def start(self, name, *options):
        with open(self.folder / f"{name}.out", "ab") as log:
            self.daemons[name] = subprocess.Popen([name, *options], env=self.environment, stdout=log, stderr=log)

    def lose_node(self):
        """Ends the node and everything that runs there by SIGKILL, as a power cut does, and starts it again."""
        kept = {os.getpid(), self.daemons["slurmctld"].pid, self.daemons["munged"].pid}
        for process in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                is_of_node = f"SLURM_CONF={self.folder}/".encode() in (process / "environ").read_bytes()
            except OSError:
                continue
            if is_of_node and int(process.name) not in kept:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(int(process.name), signal.SIGKILL)
        self.daemons["slurmd"].wait()
        self.start("slurmd", "-D", "-N", self.host)

    def run(self, *words, check=False):
        ran = subprocess.run([str(word) for word in words], env=self.environment, capture_output=True, text=True, check=False)
        if check and ran.returncode != 0:
            raise RuntimeError(f"{words[0]}: {ran.stderr.strip()}")
        return ran.stdout.strip()

    def submit(self, script, *options):
        return self.run("sh", script, *options, check=True).splitlines()[-1]

    def jobs(self):
        """Jobs that have not ended."""
        return self.run("squeue", "-h", "-r", "-o", "%i").split()

    def wait_for(self, holds, what, seconds=90):
        end = time.monotonic() + seconds
        while not holds():
            if time.monotonic() > end or any(daemon.poll() is not None for daemon in self.daemons.values()):
                logs = [self.folder / "slurmctld.out", self.folder / "slurmctld.log"]
                tail = "".join(log.read_text()[-2000:] for log in logs if log.exists())
                raise RuntimeError(f"{what} did not come\n{self.run('squeue', '-r')}\n{tail}")
            time.sleep(0.2)

    def wait_for_the_end(self):
        self.wait_for(lambda: not self.jobs(), "the end of all jobs", seconds=240)
