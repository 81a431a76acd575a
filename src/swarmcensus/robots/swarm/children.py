"""The processes of a swarm's robots: started, stopped, continued and ended.

Each process is in a group of its own, so that Ctrl-C in a terminal reaches the command alone. If the command is
killed, robots end because nobody takes their reports; those that are stopped are ended by the system, which does so in
groups without a parent.
"""

import contextlib
import signal
import subprocess
import sys
import time
from pathlib import Path

from swarmcensus.robots.swarm.folder import RUN, module_of
from swarmcensus.support.errors import InputError

PROGRAM = (
    "import sys; sys.path.insert(0, sys.argv[1]); sys.dont_write_bytecode = True; import node; node.main(*sys.argv[2:])"
)
GRACE = 0.3  # seconds from asking a process to end to ending it
LAST_LINES = 3  # of a dead robot's output that are shown


def check_system() -> None:
    """Raise InputError where processes have no groups and signals as here."""
    if sys.platform == "win32":
        raise InputError("swarmcensus swarm needs the signals of Linux or macOS: on Windows, run it in WSL")


class Children:
    """The processes by robot; each start of a robot is a life, counted from 1."""

    def __init__(self, folder: Path) -> None:
        """Nobody runs yet."""
        self.folder = folder.resolve()
        self.running: dict[int, subprocess.Popen[bytes]] = {}
        self.lives: dict[int, int] = {}

    def start(self, number: int) -> None:
        """Start a robot's process."""
        run = self.folder / RUN
        self.lives[number] = self.lives.get(number, 0) + 1
        # -I and -S: nothing but Python itself is loaded, which keeps a process small
        command = [sys.executable, "-I", "-S", "-c", PROGRAM, str(run), module_of(number), str(self.lives[number])]
        with open(self._errors(number), "ab") as errors:
            self.running[number] = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=errors, process_group=0
            )

    def kill(self, number: int) -> None:
        """End a robot at once, as a power cut does."""
        process = self.running.pop(number, None)
        if process is not None:
            process.kill()
            process.wait()

    def stop(self, number: int) -> None:
        """Let a robot do nothing until it is continued."""
        if number in self.running:
            self.running[number].send_signal(signal.SIGSTOP)

    def resume(self, number: int) -> None:
        """Continue a stopped robot."""
        if number in self.running:
            self.running[number].send_signal(signal.SIGCONT)

    def dead(self) -> list[tuple[int, str]]:
        """Robots whose processes have ended by themselves since the last call, and why."""
        gone = [number for number, process in self.running.items() if process.poll() is not None]
        return [(number, self._reason(number, self.running.pop(number).returncode)) for number in gone]

    def end(self) -> None:
        """End all, also those that are stopped; within a second."""
        for process in self.running.values():
            with contextlib.suppress(ProcessLookupError):
                process.terminate()
        until = time.monotonic() + GRACE
        while time.monotonic() < until and any(process.poll() is None for process in self.running.values()):
            time.sleep(0.01)
        for process in self.running.values():
            process.kill()
        for process in self.running.values():
            process.wait()
        self.running.clear()

    def _errors(self, number: int) -> Path:
        return self.folder / RUN / f"{number}.errors"

    def _reason(self, number: int, code: int) -> str:
        said = self._errors(number).read_text(encoding="utf-8", errors="replace").strip().splitlines()[-LAST_LINES:]
        how = f"signal {-code}" if code < 0 else f"exit code {code}"
        return f"{how}: {' / '.join(line.strip() for line in said)}" if said else how


def seconds_of_children() -> float:
    """Processor seconds of all processes that have been waited for."""
    import resource

    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
