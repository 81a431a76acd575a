"""Takes a brain to a robot without Python: translation to C, a self-test of the translation, and chips to try it on.

In: a brain, in the number formats of its robot.
Out: C files, what they should print, and their size and speed on simulated chips.
Must not know: studies, worlds, results.
"""
