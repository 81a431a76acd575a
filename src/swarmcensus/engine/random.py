"""Counter-based random numbers: the Threefry-2x64-13 block cipher of a key and a counter.

Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011. A key (`addresses.py`) is the hash of a seed, a
purpose and the content that the draw depends on. The counter holds trial, tick and robot. There is no generator with a
state, so no result depends on order, threads or batches.
"""

import numpy as np
from numba import uint64

from swarmcensus.engine.compiling import loop

PARITY = np.uint64(0x1BD11BDAA9FC1A22)
U = np.uint64


@loop(forceinline=True)
def mix(a, b, r):
    """One add, rotate and xor of the cipher."""
    a = a + b
    b = (b << r) | (b >> (U(64) - r))
    return a, b ^ a


@loop(forceinline=True)
def mix_four(a, b, p, q, r, s):
    """Four rounds of it."""
    a, b = mix(a, b, p)
    a, b = mix(a, b, q)
    a, b = mix(a, b, r)
    return mix(a, b, s)


@loop(from_cpython=True)
def block(k0, k1, c0, c1):
    """Two uint64 that are uniform and independent over counters (c0, c1), under the key (k0, k1)."""
    k2 = PARITY ^ k0 ^ k1
    a, b = mix_four(c0 + k0, c1 + k1, U(16), U(42), U(12), U(31))
    a, b = mix_four(a + k1, b + k2 + U(1), U(16), U(32), U(24), U(21))
    a, b = mix_four(a + k2, b + k0 + U(2), U(16), U(42), U(12), U(31))
    return mix(a + k0, b + k1 + U(3), U(16))


@loop(from_cpython=True)
def counter(high, low):
    """One counter word of two 32-bit numbers."""
    return (uint64(high) << U(32)) | uint64(low)


@loop(from_cpython=True)
def word_of(k0, k1, trial, tick, receiver, sender):
    """The first word of the block whose counters are made of these four 32-bit numbers."""
    return block(k0, k1, counter(trial, tick), counter(receiver, sender))[0]


@loop(from_cpython=True)
def unit(word):
    """A uint64 as a float64 in [0, 1), uniform on multiples of 2^-53."""
    return (word >> U(11)) * (1.0 / 9007199254740992.0)


@loop(from_cpython=True)
def chance(word):
    """A uint64 as a float64 in (0, 1), uniform on odd multiples of 2^-53."""
    return ((uint64(word) >> U(12)) + 0.5) * (1.0 / 4503599627370496.0)


@loop(from_cpython=True)
def single_chance(word):
    """A uint64 as a float32 in (0, 1), uniform on odd multiples of 2^-24."""
    return ((uint64(word) >> U(41)) + 0.5) * (1.0 / 8388608.0)


@loop(from_cpython=True, forceinline=True)
def to_single(x):
    """The nearest float32, as one: `brains.single.rounded_to_single` in machine code."""
    return np.float32(x)


@loop(from_cpython=True)
def words(key, trial, tick, part, first, size, out):
    """Fill out[:size], a uint64 for each robot from `first` (even): robots 2j and 2j + 1 share block j."""
    k0, k1, c0 = key[0], key[1], counter(trial, tick)
    high = counter(part, uint64(first) >> U(1))
    pairs = size // 2
    for j in range(pairs):
        out[2 * j], out[2 * j + 1] = block(k0, k1, c0, high + uint64(j))
    if size % 2 == 1:
        out[size - 1], _ = block(k0, k1, c0, high + uint64(pairs))
