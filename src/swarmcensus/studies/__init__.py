"""From a study file to its settings: tables and keys, what goes together, the grid, each setting's random addresses.

In: TOML text or Python values.
Out: a Study, and its Settings.
Must not know: how a setting is run, what is stored.
"""
