"""Boards with MicroPython, such as an ESP32, that talk over ESP-NOW."""

from swarmcensus.robots.micropython_files import FLASH, NUMBERS, micropython_files
from swarmcensus.robots.target import Target

TARGET = Target(
    "ESP-NOW",
    micropython_files,
    largest=250,
    refuses=NUMBERS,
    flash=FLASH,
    counts=True,
    moves=False,
)
