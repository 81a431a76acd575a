"""Brain files and adversary files: found, checked against their contract, loaded, hashed; `library` has shipped brains.

In: a brain or adversary file, or the name of a shipped one or of one of another package.
Out: a Brain: its functions, memory, message, parameters and source; also for an adversary with a brain that it wears.
Must not know: how brains are compiled, worlds, studies.
"""

from swarmcensus.brains.adversary import Adversary
from swarmcensus.brains.adversary_source import lying_brain
from swarmcensus.brains.brain import PLUGINS, Brain, find, is_shipped, load, parse, shipped, unloaded
from swarmcensus.brains.contract import FUNCTIONS, MAY_HAVE, TRACED
from swarmcensus.brains.fields import Value, Vector, length, numbers, places, slots
from swarmcensus.brains.syntax import BELIEFS
from swarmcensus.support.safe_source import digest, read_source

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
    "is_shipped",
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
