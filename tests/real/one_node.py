"""A Slurm of one node on loopback, with all that it writes in a folder of its own."""

import contextlib
import getpass
import os
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from pathlib import Path

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "scancel", "squeue", "sinfo")
SBIN = os.pathsep.join((os.environ.get("PATH", ""), "/usr/sbin", "/usr/local/sbin"))
CONFIGURATION = """
ClusterName=one
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmdPort={node_port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
MpiDefault=none
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmdParameters=config_overrides
SchedulerParameters=batch_sched_delay=0,sched_interval=1
ReturnToService=2
SlurmdTimeout=5
KillWait=2
MinJobAge=10
NodeName={host} NodeAddr=127.0.0.1 CPUs=4 RealMemory=8000
PartitionName=short Nodes=ALL Default=YES MaxTime=10
"""


def missing():
    """The programs that are not here."""
    return [name for name in PROGRAMS if shutil.which(name, path=SBIN) is None]


class Slurm:
    """Its three daemons; commands find it by SLURM_CONF."""

    def __init__(self):
        self.folder = Path(tempfile.mkdtemp(prefix="slurm-"))
        self.folder.chmod(0o755)  # munge wants a socket that others could reach
        self.environment = {"SLURM_CONF": str(self.folder / "slurm.conf"), "PATH": SBIN}
        self._daemons = {}
        try:
            self._start()
        except BaseException:
            self.close()
            raise

    def _start(self):
        for name in ("state", "spool"):
            (self.folder / name).mkdir()
        key = self.folder / "munge.key"
        key.touch(0o600)
        key.write_bytes(os.urandom(1024))
        port, node_port = free_ports(2)
        text = CONFIGURATION.format(
            host=socket.gethostname().partition(".")[0], user=getpass.getuser(), folder=self.folder, port=port,
            node_port=node_port,
        )  # fmt: skip
        (self.folder / "slurm.conf").write_text(text)
        self.daemon(
            "munged", "--foreground", "--force", f"--socket={self.folder}/munge.socket", f"--key-file={key}",
            f"--pid-file={self.folder}/munged.pid", f"--seed-file={self.folder}/munged.seed", "--num-threads=2",
        )  # fmt: skip
        until(lambda: (self.folder / "munge.socket").exists(), "munged listens")
        self.daemon("slurmctld", "-D")
        self.daemon("slurmd", "-D")
        self.wait_for_node()

    def daemon(self, name, *options):
        """Start one of the daemons."""
        with open(self.folder / f"{name}.log", "a") as log:
            self._daemons[name] = subprocess.Popen(
                [name, *options], env=os.environ | self.environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log
            )

    def end(self, name, number=signal.SIGTERM):
        """End one of them."""
        process = self._daemons.pop(name)
        process.send_signal(number)
        try:
            process.wait(5)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def wait_for_node(self):
        """Wait until jobs can start."""
        until(lambda: self.says("sinfo", "--noheader", "--format=%t") in ("idle", "mix", "alloc"), "the node is up")

    def says(self, *command):
        """What a command of Slurm's prints."""
        done = subprocess.run(command, env=os.environ | self.environment, capture_output=True, text=True, timeout=60)
        return done.stdout.strip()

    def jobs(self):
        """The ids of the jobs that wait or run."""
        return self.says("squeue", "--noheader", "--states=PENDING,RUNNING", "--format=%i").split()

    def crash(self):
        """Kill the node's daemon and all that it runs, as a power cut does."""
        spared = {process.pid for name, process in self._daemons.items() if name != "slurmd"}
        self.end("slurmd", signal.SIGKILL)
        self._kill(spared)

    def _kill(self, spared=()):
        for pid in set(self._ours()) - set(spared):
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)

    def _ours(self):
        """The processes that were started under this Slurm, by what their environment says."""
        mark = f"SLURM_CONF={self.folder}/".encode()
        for entry in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                if int(entry.name) != os.getpid() and mark in (entry / "environ").read_bytes():
                    yield int(entry.name)

    def close(self):
        """End all of it, whatever state it is in."""
        for name in ("slurmctld", "slurmd", "munged"):
            if name in self._daemons:
                self.end(name)
        self._kill()
        shutil.rmtree(self.folder, ignore_errors=True)


def free_ports(count):
    """Ports that nobody listens on just now."""
    with contextlib.ExitStack() as stack:
        sockets = [stack.enter_context(socket.create_server(("127.0.0.1", 0))) for _ in range(count)]
        return [one.getsockname()[1] for one in sockets]


def until(holds, what, seconds=60):
    """Wait for something."""
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end, f"not within {seconds} seconds: {what}"
        time.sleep(0.2)
