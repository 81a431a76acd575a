"""Brain files and the contract that they keep: found, checked, loaded, hashed; `library` holds those that come along.

In: a brain file, or the name of one that is shipped or that another package gives.
Out: a Brain: its functions, memory, message and source.
Must not know: how brains are compiled, worlds, studies.
"""

from swarmcensus.basics.plain import digest, read_source
from swarmcensus.brains.brain import (
    BELIEFS,
    DOOR,
    FUNCTIONS,
    MAY_HAVE,
    TRACED,
    Brain,
    find,
    load,
    parse,
    shipped,
)

__all__ = [
    "BELIEFS",
    "DOOR",
    "FUNCTIONS",
    "MAY_HAVE",
    "TRACED",
    "Brain",
    "digest",
    "find",
    "load",
    "parse",
    "read_source",
    "shipped",
]
