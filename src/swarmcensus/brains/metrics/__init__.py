"""Metric files: found, checked against their contract, hashed; `library` has the shipped metrics.

In: a metric file, or the name of a shipped one or of one of another package.
Out: a Metric: its functions, the fields of its record, its unit and meaning.
Must not know: how metrics are compiled, brains, worlds, studies.
"""

from swarmcensus.brains.metrics.metric import GIVEN, PLUGINS, Metric, find, load, parse, variable_of

__all__ = ["GIVEN", "PLUGINS", "Metric", "find", "load", "parse", "variable_of"]
