"""What takes long: tested where SWARMCENSUS_SLOW=1 asks for it; else with fewer cases, or by what is beside it."""

import os

import pytest

SLOW = bool(os.environ.get("SWARMCENSUS_SLOW"))
slow = pytest.mark.skipif(not SLOW, reason="takes long: SWARMCENSUS_SLOW=1 runs it")


def times(thorough, quick):
    """The first of two where there is time."""
    return thorough if SLOW else quick
