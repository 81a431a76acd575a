"""Boards with MicroPython that talk over a serial line."""

from swarmcensus.robots.micropython_files import FLASH, NUMBERS, micropython_files
from swarmcensus.robots.target import Target

TARGET = Target(
    "a serial line",
    micropython_files,
    largest=250,
    refuses=NUMBERS,
    flash=FLASH,
    counts=True,
    moves=False,
)
