"""Further seeds for tuning and planning, derived from the seed of a study or mission, and never equal to it."""

import hashlib

BELOW = 2**63


def seed_for(seed: int, purpose: str, number: int = 0, command: str = "tune") -> int:
    """A seed for one purpose of a command, such as "training", and a number, such as that of a generation."""
    for attempt in range(3):
        text = f"swarmcensus {command} {seed} {purpose} {number} {attempt}"
        derived = int.from_bytes(hashlib.blake2b(text.encode(), digest_size=8).digest()) % BELOW
        if derived != seed:
            return derived
    raise AssertionError("three different hashes cannot all equal the seed")
