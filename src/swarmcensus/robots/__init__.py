"""Takes a brain to a robot: a folder of files for its board, or C, and whether the board computes what it should.

In: a brain, in the number formats of its robot, its sensor's accuracies and its radio.
Out: files for MicroPython and in C, comparisons of self-tests, size and speed on simulated chips.
Must not know: studies, worlds, results.
"""
