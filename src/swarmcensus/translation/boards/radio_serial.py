import machine
from lines import Line

UART = 1  # FILL IN
PINS = {}  # FILL IN such as {"tx": 17, "rx": 16}; without them the board takes its own
BAUD = 9600


class Radio(Line):
    """Datagrams over a serial line, such as infrared or a radio module."""

    def __init__(self):
        """Open the line."""
        uart = machine.UART(UART, BAUD, timeout=0, **PINS)
        Line.__init__(self, lambda: uart.read(uart.any()) if uart.any() else b"", uart.write)
