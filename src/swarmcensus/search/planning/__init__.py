"""Plans missions: how many robots and how many minutes a wanted precision takes.

In: a mission, from TOML or Python values.
Out: plans: swarm sizes and times with their intervals, predicted by theory and confirmed by simulation.
Must not know: the command line, figures.
"""
