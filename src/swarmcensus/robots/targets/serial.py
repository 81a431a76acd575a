"""Boards with MicroPython that talk over a serial line."""

from swarmcensus.robots.micropython_files import micropython_board
from swarmcensus.runtime.reports import USB

TARGET = micropython_board("a serial line", largest=250, reports=(USB,))
