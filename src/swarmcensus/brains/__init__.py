"""Brain files and the contract that they keep: found, checked, loaded, hashed; `library` holds those that come along.

In: a brain file, or the name of one that is shipped or that another package gives; likewise an adversary.
Out: a Brain: its functions, memory, message, parameters and source; of an adversary and the brain that it wears, too.
Must not know: how brains are compiled, worlds, studies.
"""

from swarmcensus.basics.safe_source import digest, read_source
from swarmcensus.brains.adversary import Adversary
from swarmcensus.brains.adversary_source import lying_brain
from swarmcensus.brains.brain import PLUGINS, Brain, find, load, parse, shipped, unloaded
from swarmcensus.brains.contract import FUNCTIONS, MAY_HAVE, TRACED
from swarmcensus.brains.fields import Value, Vector, length, numbers, places, slots
from swarmcensus.brains.syntax import BELIEFS

__all__ = [
    "BELIEFS",
    "FUNCTIONS",
    "MAY_HAVE",
    "PLUGINS",
    "TRACED",
    "Adversary",
    "Brain",
    "Value",
    "Vector",
    "digest",
    "find",
    "length",
    "load",
    "lying_brain",
    "numbers",
    "parse",
    "places",
    "read_source",
    "shipped",
    "slots",
    "unloaded",
]
