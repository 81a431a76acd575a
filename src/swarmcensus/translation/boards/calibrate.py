"""Counts what this robot's sensor reads on a black and on a white strip: `mpremote run calibrate.py > robot-1.csv`.

The sensor is that of main.py. `swarmcensus calibrate robot-*.csv` finds b and w.
"""

import time

import main
import settings

READINGS = 1000  # on each strip
WAIT = 10  # seconds to put the robot onto a strip, on which it then should move


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


def run(readings=READINGS, wait=WAIT):
    """Count on both strips, and print a table."""
    sensor, number = main.Sensor(), main.own_number()
    sensor.start()
    print("robot,strip,readings,black,changes")
    for strip in ("black", "white"):
        print(f"# put robot {number} on {strip}; counting begins in {wait} s")
        time.sleep(wait)
        looks, blacks, changes = count(sensor, readings, settings.PERIOD / 1000)
        print(f"{number},{strip},{looks},{blacks},{changes}")


if __name__ == "__main__":
    run()
