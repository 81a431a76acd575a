"""Counts what this robot's sensor, that of main.py, reads on one strip, while somebody moves the robot there.

On black: `mpremote exec "import calibrate; calibrate.run('black')" > robot-1-black.csv`, and then on white.
`swarmcensus calibrate robot-*.csv` finds b and w.
"""

import time

import main
import settings

READINGS = 1000


def count(sensor, readings, pause):
    """How many readings there were, how many said black, and how often one differed from the one before."""
    looks = blacks = changes = 0
    before = None
    for _ in range(readings):
        seen = sensor.read()
        if seen is not None:
            looks += 1
            blacks += 1 if seen else 0
            changes += 1 if before is not None and bool(seen) != before else 0
            before = bool(seen)
        time.sleep(pause)
    return looks, blacks, changes


def run(strip, readings=READINGS):
    """Count on a strip, "black" or "white", on which the robot moves already, and print a table."""
    sensor, number = main.Sensor(), main.own_number()
    sensor.start()
    looks, blacks, changes = count(sensor, readings, settings.PERIOD / 1000)
    print("robot,strip,readings,black,changes")
    print(f"{number},{strip},{looks},{blacks},{changes}")
