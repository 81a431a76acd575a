"""Missions planned: how many robots, and how many minutes, a wanted precision takes.

In: a mission, from TOML or Python values.
Out: plans: sizes and times with their intervals, found by theory and confirmed by simulation.
Must not know: the command line, figures.
"""
