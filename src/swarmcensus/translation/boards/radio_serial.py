import machine

UART = 1  # FILL IN
PINS = {}  # FILL IN such as {"tx": 17, "rx": 16}; without them the board takes its own
BAUD = 9600
END, ESCAPE, END_INSIDE, ESCAPE_INSIDE = 0xC0, 0xDB, 0xDC, 0xDD  # as in SLIP, RFC 1055
LONGEST = 300


class Radio:
    """Datagrams over a serial line, such as infrared or a radio module; a byte ends each."""

    def __init__(self):
        """Open the line."""
        self.line = machine.UART(UART, BAUD, timeout=0, **PINS)
        self.got = bytearray()
        self.frame = bytearray()
        self.escaped = False

    def send(self, datagram):
        """Write it, between two ends: what noise came before is then a datagram of its own."""
        out = bytearray([END])
        for byte in datagram:
            if byte == END:
                out.extend(bytes([ESCAPE, END_INSIDE]))
            elif byte == ESCAPE:
                out.extend(bytes([ESCAPE, ESCAPE_INSIDE]))
            else:
                out.append(byte)
        out.append(END)
        self.line.write(out)

    def receive(self):
        """The next datagram that has arrived whole, or None."""
        waiting = self.line.any()
        if waiting:
            self.got.extend(self.line.read(min(waiting, LONGEST)) or b"")
        for at, byte in enumerate(self.got):
            if byte == END:
                whole, self.frame, self.escaped = bytes(self.frame), bytearray(), False
                if whole:
                    self.got = self.got[at + 1 :]
                    return whole
            elif self.escaped:
                self.frame.append({END_INSIDE: END, ESCAPE_INSIDE: ESCAPE}.get(byte, byte))
                self.escaped = False
            elif byte == ESCAPE:
                self.escaped = True
            elif len(self.frame) < LONGEST:
                self.frame.append(byte)
        self.got = bytearray()
        return None
