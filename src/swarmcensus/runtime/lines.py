"""Datagrams over a stream of bytes, such as a serial line. Runs in CPython and in MicroPython."""

END, ESCAPE, END_INSIDE, ESCAPE_INSIDE = b"\xc0", b"\xdb", b"\xdb\xdc", b"\xdb\xdd"  # as in SLIP, RFC 1055
LONGEST = 600  # bytes without an end that are kept


class Line:
    """A stream on which a byte ends each datagram.

    read: a function that returns the bytes that have come, perhaps none, and never waits. write: one that takes bytes.
    """

    def __init__(self, read, write):
        """Nothing has come."""
        self.read = read
        self.write = write
        self.got = b""

    def send(self, datagram):
        """Write it, between two ends: what noise came before is then a datagram of its own."""
        inside = bytes(datagram).replace(ESCAPE, ESCAPE_INSIDE).replace(END, END_INSIDE)
        self.write(END + inside + END)

    def receive(self):
        """The next datagram that has come whole, or None."""
        self.got += self.read() or b""
        at = self.got.find(END)
        while at >= 0:
            whole, self.got = self.got[:at], self.got[at + 1 :]
            if whole:
                return whole.replace(END_INSIDE, END).replace(ESCAPE_INSIDE, ESCAPE)
            at = self.got.find(END)
        self.got = self.got[-LONGEST:]
        return None


class Console(Line):
    """A board's own serial port, on which its prints are noise between datagrams."""

    def __init__(self):
        """Begin to listen."""
        import select
        import sys

        # a computer's `raw` holds nothing back; boards have no such thing
        self.inward, out = (getattr(one.buffer, "raw", one.buffer) for one in (sys.stdin, sys.stdout))
        self.poll = select.poll()
        self.poll.register(sys.stdin, select.POLLIN)
        Line.__init__(self, self.arrived, out.write)

    def arrived(self):
        """The bytes that have come."""
        out = b""
        while len(out) < LONGEST and self.poll.poll(0):
            byte = self.inward.read(1)
            if not byte:
                break
            out += byte
        return out
