"""Passes what a computer says at this board's serial port to robots over ESP-NOW, and their reports back.

It is no robot. `mpremote cp *.py : + cp gateway.py :boot.py + reset` lets it do nothing else; of a fleet, it needs the
settings.py of any robot, too.
"""

import time

import main
from lines import Console
from reports import MAGIC

main.BUFFER = 16384  # robots of one clock report at once, faster than the line carries it


def passed(line, radio):
    """Pass what has come; returns whether there was anything."""
    order = line.receive()
    if order is not None and order.startswith(MAGIC):  # keys that somebody presses are none
        radio.send(order)
    report = radio.receive()
    if report is not None and report.startswith(MAGIC):  # robots' messages would fill the line
        line.send(report)
    return order is not None or report is not None


def run():
    """Pass on for ever."""
    line, radio = Console(), main.Radio()
    while True:
        try:
            busy = passed(line, radio)
        except Exception:  # the radio is off, and switched on again by the next call
            busy = False
        if not busy:
            time.sleep(0.001)


if __name__ == "__main__":
    run()
