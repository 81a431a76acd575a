"""Boards with MicroPython, such as an ESP32, that talk over UDP in a Wi-Fi."""

from swarmcensus.robots.micropython_files import micropython_board
from swarmcensus.robots.target import ADDRESS
from swarmcensus.runtime.reports import USB

TARGET = micropython_board("UDP", largest=1400, reports=(ADDRESS, USB))
