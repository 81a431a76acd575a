"""Boards with MicroPython, such as an ESP32, that talk over ESP-NOW."""

from swarmcensus.robots.micropython_files import micropython_board
from swarmcensus.runtime.reports import GATEWAY, USB

TARGET = micropython_board("ESP-NOW", largest=250, reports=(GATEWAY, USB))
