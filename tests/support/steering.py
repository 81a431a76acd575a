"""A brain that steers as its assumed accuracy says."""

from swarmcensus import brains

# One brain, compiled once: what it wants is told by the accuracy on white that its robots believe in.
STEER = """

def steer(me):
    if me.w == NEVER:
        return None
    if me.w == ABSURD:
        if me.n % 2.0 < 1.0:
            return 1e9, -1e9
        return -1e9, 1e9
    if me.w == CIRCLE:
        return 0.05, 0.5
    if me.w == STRAIGHT:
        return 0.14, 0.0
    if me.w == SPIN:
        return 0.0, 0.5
    if me.w == DIVIDES:
        return 0.1 / (me.t - me.t), 0.0
    if me.w == BROKEN:
        return 1e308 * 10.0 - 1e308 * 10.0, 0.0
    if me.n % 2.0 < 1.0:
        return None
    return 0.1, 1.0
"""


WANTS = {"NEVER": 0.6, "ABSURD": 0.65, "CIRCLE": 0.7, "STRAIGHT": 0.75, "BROKEN": 0.8, "SEEN": 0.85, "DIVIDES": 0.9,
         "SPIN": 0.95}  # fmt: skip


def steered_in(folder):
    """The folder, with a brain steered.py that steers as one of `WANTS` says."""
    constants = "\n".join(f"{name} = {w}" for name, w in WANTS.items())
    (folder / "steered.py").write_text(f"{brains.load('minimalistic').source}\n\n{constants}{STEER}")
    return folder
