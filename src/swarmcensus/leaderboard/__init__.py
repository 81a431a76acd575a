"""The leaderboard: shipped brains, and one's own beside them, in one fixed set of worlds, scored on a page.

In: brain files, and the study that comes along (studies/leaderboard.toml).
Out: results, a page and a figure in a folder.
Must not know: options and terminals.
"""
