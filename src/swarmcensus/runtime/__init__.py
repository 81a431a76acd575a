"""What runs on a robot together with its brain: the codec of messages, the loop, the log and reports, plain Python.

In: nothing.
Out: files that CPython and MicroPython run as they are, that Numba compiles, and that a translation to C includes.
Must not know: anything else of swarmcensus.
"""
