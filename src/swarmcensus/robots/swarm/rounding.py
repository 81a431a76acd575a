"""Rounding to single precision where neither NumPy nor ctypes is."""

import struct


def rounded_to_single(x):
    """The nearest float32; infinite beyond its largest."""
    try:
        return struct.unpack("<f", struct.pack("<f", x))[0]
    except OverflowError:
        return float("inf") if x > 0.0 else float("-inf")
