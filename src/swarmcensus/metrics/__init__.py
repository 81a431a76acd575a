"""Metric files and the contract that they keep: found, checked, hashed; `library` holds those that come along.

In: a metric file, or the name of one that is shipped or that another package gives.
Out: a Metric: its functions, the fields of its record, its unit and meaning.
Must not know: how metrics are compiled, brains, worlds, studies.
"""

from swarmcensus.metrics.metric import GIVEN, PLUGINS, RESERVED, Metric, find, load, parse, variable_of

__all__ = ["GIVEN", "PLUGINS", "RESERVED", "Metric", "find", "load", "parse", "variable_of"]
