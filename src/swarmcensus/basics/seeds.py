"""Seeds of trials beside a study's, or a mission's, own: made of its seed, and never equal to it."""

import hashlib

BELOW = 2**63


def seed_for(seed: int, purpose: str, number: int = 0, command: str = "tune") -> int:
    """A seed of its own for a purpose of a command, as "training", and a number of it, as of a generation."""
    for again in range(3):
        text = f"swarmcensus {command} {seed} {purpose} {number} {again}"
        found = int.from_bytes(hashlib.blake2b(text.encode(), digest_size=8).digest()) % BELOW
        if found != seed:
            return found
    raise AssertionError("a hash cannot be three times what it should not be")
