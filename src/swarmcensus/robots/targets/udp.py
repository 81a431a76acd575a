"""Boards with MicroPython, such as an ESP32, that talk over UDP in a Wi-Fi."""

from swarmcensus.robots.micropython_files import micropython_board

TARGET = micropython_board("UDP", largest=1400, reports=True)
