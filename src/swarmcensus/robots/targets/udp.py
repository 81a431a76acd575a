"""Boards with MicroPython, such as an ESP32, that talk over UDP in a Wi-Fi."""

from swarmcensus.robots.micropython_files import FLASH, NUMBERS, micropython_files
from swarmcensus.robots.target import Target

TARGET = Target(
    "UDP", micropython_files, largest=1400, refuses=NUMBERS, flash=FLASH, counts=True, reports=True, moves=False
)
