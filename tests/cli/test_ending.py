"""However a command is ended, its processes end with it, and its exit code names the signal."""

import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest

from swarmcensus import brains

pytestmark = [
    pytest.mark.usefixtures("untraced_processes"),
    pytest.mark.skipif(sys.platform != "linux", reason="other systems copy no processes"),
]
COPIES = """
    import os, signal, time
    from swarmcensus.cli import commands, program
    from swarmcensus.support import fork
    fork.cores = lambda: 2
    def work():
        print(os.getpid(), flush=True)
        while True:
            pass
    def main():
        ended = fork.in_background(work)
        {waits}
    commands.main = main
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # also where the tests run under nohup
    program.program()
"""
CHILD = """
    import os, signal, subprocess, sys
    from swarmcensus.cli import commands, program
    child = "import sys; from swarmcensus.support.fork import end_with; end_with(int(sys.argv[1])); {loop}"
    commands.main = lambda: subprocess.run([sys.executable, "-c", child, str(os.getpid())])
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    program.program()
"""
LOOP = "print(1, flush=True); [1 for _ in iter(int, 1)]"


@pytest.mark.parametrize("code", [
    COPIES.format(waits="ended()"), COPIES.format(waits="time.sleep(600)"), CHILD.format(loop=LOOP)
])  # fmt: skip
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGKILL])
def test_no_process_is_left(code, number):
    process = subprocess.Popen([sys.executable, "-c", textwrap.dedent(code)], stdout=subprocess.PIPE)
    assert process.stdout.readline()  # the child runs
    process.send_signal(number)
    process.communicate(timeout=60)  # until nobody has the pipe
    assert process.returncode == (-number if number == signal.SIGKILL else 128 + number)


@pytest.mark.long
def test_a_check_ends_with_its_command(here):
    source, last = brains.load("minimalistic").source, "    return me.x\n"
    Path("endless.py").write_text(source.replace(last, f"    while me.x > -1.0:\n        pass\n{last}"))
    process = subprocess.Popen([sys.executable, "-m", "swarmcensus", "brains", "--check", "endless.py"])
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    while not (child := children.read_text().split()):
        assert process.poll() is None
        time.sleep(0.01)
    used = Path(f"/proc/{child[0]}/stat")
    while sum(map(int, used.read_text().split()[13:15])) < 2.5 * os.sysconf("SC_CLK_TCK"):  # then it is in the loop
        time.sleep(0.1)
    process.kill()
    process.wait()
    until = time.monotonic() + 20.0
    while used.exists() and used.read_text().rpartition(")")[2].split()[0] not in "ZX":
        assert time.monotonic() < until
        time.sleep(0.01)


def test_under_nohup_a_hangup_stays_ignored():
    code = """
        import signal
        from swarmcensus.cli import commands, program
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
        def main():
            signal.raise_signal(signal.SIGHUP)
            return 7
        commands.main = main
        program.program()
    """
    assert subprocess.run([sys.executable, "-c", textwrap.dedent(code)], check=False).returncode == 7


def test_a_stop_within_a_callback_is_not_lost():
    code = """
        import signal
        import time
        from swarmcensus.cli import commands, program
        class Called:
            def __del__(self):
                signal.raise_signal(signal.SIGINT)
        def main():
            Called()
            while True:
                time.sleep(0.01)
        commands.main = main
        program.program()
    """
    words = [sys.executable, "-c", textwrap.dedent(code)]
    done = subprocess.run(words, check=False, capture_output=True, text=True, timeout=40)
    assert (done.returncode, done.stderr) == (130, "swarmcensus: stopped\n")
