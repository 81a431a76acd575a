"""Ranking, the leaderboard: shipped brains, and brains of your own, in one fixed set of worlds, scored on a page.

In: brain files, and the shipped study studies/leaderboard.toml.
Out: results, a page and a figure in a folder.
Must not know: options and terminals.
"""
