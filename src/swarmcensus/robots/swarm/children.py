"""The processes of a swarm's robots: started, stopped, continued and ended.

Each process is in a group of its own, so that Ctrl-C in a terminal reaches the command alone. If the command is
killed, robots end because nobody takes their reports. Those that are stopped cannot: a guardian ends them, a small
process that notices when the command's end of a pipe is gone.
"""

import contextlib
import signal
import subprocess
import sys
import time
from collections.abc import Set
from pathlib import Path

from swarmcensus.robots import on_node
from swarmcensus.robots.swarm.folder import ON_MICROPYTHON, RUN, module_of
from swarmcensus.support.errors import InputError

GUARDIAN = Path(__file__).with_name("guardian.py")
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

    def __init__(self, folder: Path, on_micropython: Set[int] = frozenset()) -> None:
        """Nobody runs yet."""
        self.folder = folder.resolve()
        self.on_micropython = on_micropython
        self.running: dict[int, subprocess.Popen[bytes]] = {}
        self.lives: dict[int, int] = {}
        self.stopped: set[int] = set()
        self.guardian: subprocess.Popen[bytes] | None = None

    def start(self, number: int) -> None:
        """Start a robot's process."""
        run = self.folder / RUN
        self.lives[number] = self.lives.get(number, 0) + 1
        # -I and -S: nothing but Python itself is loaded, which keeps a process small
        command = [sys.executable, "-I", "-S", "-c", PROGRAM]
        if number in self.on_micropython:
            command = ["node", str(run / ON_MICROPYTHON.name), str(on_node.micropython())]
        command += [str(run), module_of(number), str(self.lives[number])]
        with open(self._errors(number), "ab") as errors:
            self.running[number] = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=errors, process_group=0
            )
        self._guard(self.running[number].pid)

    def _guard(self, line: int) -> None:
        """Tell the guardian of a process that has started, or of one that has ended by its number below 0."""
        if self.guardian is None:
            self.guardian = subprocess.Popen(
                [sys.executable, "-I", "-S", str(GUARDIAN)], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL, bufsize=0, cwd="/", start_new_session=True,
            )  # fmt: skip
        if self.guardian.stdin is not None:
            with contextlib.suppress(OSError):  # somebody has ended it
                self.guardian.stdin.write(b"%d\n" % line)

    def kill(self, number: int) -> None:
        """End a robot at once, as a power cut does."""
        process = self.running.pop(number, None)
        self.stopped.discard(number)
        if process is not None:
            process.kill()
            process.wait()
            self._guard(-process.pid)

    def stop(self, number: int) -> None:
        """Let a robot do nothing until it is continued."""
        if number in self.running:
            self.running[number].send_signal(signal.SIGSTOP)
            self.stopped.add(number)

    def resume(self, number: int) -> None:
        """Continue a stopped robot."""
        if number in self.running:
            self.running[number].send_signal(signal.SIGCONT)
        self.stopped.discard(number)

    def dead(self) -> list[tuple[int, str]]:
        """Robots whose processes have ended by themselves since the last call, and why."""
        gone = [(number, process) for number, process in self.running.items() if process.poll() is not None]
        for number, process in gone:
            self._guard(-process.pid)
            del self.running[number]
            self.stopped.discard(number)
        return [(number, self._reason(number, process.returncode)) for number, process in gone]

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
            self._guard(-process.pid)
        self.running.clear()
        self.stopped.clear()
        if self.guardian is not None and self.guardian.stdin is not None:
            self.guardian.stdin.close()
            self.guardian.wait()
            self.guardian = None

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
