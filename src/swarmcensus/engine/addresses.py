"""Keys of random numbers; in a file of their own, so that reading a study does not load the compiler."""

import hashlib
import json

import numpy as np


def address(seed: int, purpose: str, **content: object) -> np.ndarray:
    """The 128-bit key, two uint64, of all draws with this seed, purpose and content."""
    text = json.dumps([seed, purpose, content], sort_keys=True)
    digest = hashlib.blake2b(text.encode(), digest_size=16).digest()
    return np.frombuffer(digest, dtype="<u8").astype(np.uint64)
