"""What runs on a robot beside its brain: the codec of messages and the runtime, plain Python without dependencies.

In: nothing.
Out: files that CPython and MicroPython run as they are, that Numba compiles, and that a translation to C takes along.
Must not know: anything else of swarmcensus.
"""
