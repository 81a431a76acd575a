"""Boards with MicroPython that talk over UDP."""

from swarmcensus.deployment.micropython_files import NUMBERS, micropython_files
from swarmcensus.deployment.target import Target

TARGET = Target("UDP", micropython_files, largest=1400, refuses=NUMBERS)
