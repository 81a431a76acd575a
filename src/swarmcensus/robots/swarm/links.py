"""Links to real robots: datagrams over UDP, and over serial ports, of robots or of a gateway."""

import contextlib
import errno
import os
import socket
import time
from collections.abc import Sequence
from typing import Any

from swarmcensus.robots.target import watcher_of
from swarmcensus.runtime.lines import Line
from swarmcensus.runtime.reports import USB
from swarmcensus.support.errors import InputError
from swarmcensus.support.options import wrong_option
from swarmcensus.worlds import KnownRobot

FAR = 1 << 20  # bytes of the socket for reports
MOST = 65536  # bytes that are read at a time
AGAIN = 1.0  # seconds from one try to open a port that is gone to the next


class Network:
    """A link over UDP; what it receives has an address to answer to."""

    is_open = True

    def __init__(self, where: tuple[str, int]) -> None:
        """Listen at an address and a port. Raises InputError."""
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.fileno, self.close = self.socket.fileno, self.socket.close
        try:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, FAR)
            self.socket.bind(where)
        except OSError as error:
            self.close()
            what = f"{error.strerror or error}: should be an address of this machine"
            if error.errno == errno.EADDRINUSE:
                what = f"port {where[1]} is in use: does another `swarmcensus swarm --on` run?"
            raise wrong_option("host", where[0], what) from None
        self.socket.setblocking(False)

    def receive(self) -> tuple[bytes, Any] | None:
        """The next datagram and its sender's address; None if there is none."""
        try:
            return self.socket.recvfrom(MOST)
        except (BlockingIOError, ConnectionRefusedError):
            return None

    def send(self, datagram: bytes, address: Any) -> None:
        """Send to an address; it may be lost."""
        with contextlib.suppress(OSError):
            self.socket.sendto(datagram, address)


class SerialPort:
    """A link over a serial port. If the port goes, as where a board restarts, it is opened again."""

    def __init__(self, name: str) -> None:
        """Open the port. Raises InputError."""
        self.name, self.file, self.line = name, -1, Line(self._read, self._write)
        try:
            self._open()
        except (OSError, ImportError) as error:
            why = getattr(error, "strerror", None) or error
            raise InputError(f"serial port {name}: {why}", file=name) from None

    def _open(self) -> None:
        import termios  # Windows has none
        import tty

        self.tried = time.monotonic()
        self.file = os.open(self.name, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        try:
            tty.setraw(self.file)
            settings = termios.tcgetattr(self.file)
            settings[2] = (settings[2] | termios.CLOCAL) & ~termios.HUPCL  # or some boards restart when it is closed
            settings[4] = settings[5] = termios.B115200
            termios.tcsetattr(self.file, termios.TCSAFLUSH, settings)
        except termios.error:
            self.close()
            raise OSError("it is no serial port") from None

    @property
    def is_open(self) -> bool:
        """Whether the port is there; tries to open it again, from time to time."""
        if self.file < 0 and time.monotonic() > self.tried + AGAIN:
            with contextlib.suppress(OSError):
                self._open()
        return self.file >= 0

    def fileno(self) -> int:
        """Of the open port."""
        return self.file

    def close(self) -> None:
        """Close the port."""
        if self.file >= 0:
            os.close(self.file)
        self.file = -1

    def _read(self) -> bytes:
        try:
            if not (read := os.read(self.file, MOST)):
                self.close()
            return read
        except BlockingIOError:
            return b""
        except OSError:
            self.close()
            return b""

    def _write(self, what: bytes) -> None:
        with contextlib.suppress(OSError):
            os.write(self.file, what)

    def receive(self) -> tuple[bytes, Any] | None:
        """The next datagram; None if there is none."""
        whole = self.line.receive() if self.is_open else None
        return None if whole is None else (whole, None)

    def send(self, datagram: bytes, address: Any) -> None:
        """Send to all who hear it."""
        self.line.send(datagram)


Link = Network | SerialPort


def links_to(robots: Sequence[KnownRobot], host: str | None) -> list[Link]:
    """The robots' ports, a gateway's port, or an address to listen at. Raises InputError."""
    if host == USB:
        for one in robots:
            if one.port is None:
                raise wrong_option("host", host, f"robot {one.number} has no port in the file of robots")
        return [SerialPort(str(one.port)) for one in robots]
    if host and "/" in host:
        return [SerialPort(host)]
    return [Network(watcher_of(host or "0.0.0.0", "host"))]
