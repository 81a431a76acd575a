"""Boards with MicroPython that talk over UDP."""

from swarmcensus.robots.micropython_files import NUMBERS, micropython_files
from swarmcensus.robots.target import Target

TARGET = Target("UDP", micropython_files, largest=1400, refuses=NUMBERS, moves=False)
