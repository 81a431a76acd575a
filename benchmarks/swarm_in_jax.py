"""The paper's swarm in JAX, as a user would write it, on a ring and in a full network: kernels are timed against it.

Double precision, compiled, one scan over rounds; the ring by `roll`, the full network by a sum less the own term, K by
two scans backwards. Trials are a dimension. Random numbers are JAX's own.
"""

import functools
import importlib.util
import math
import os
import time


def seconds_in_jax(study):
    """The least seconds of three runs of a study's only setting; None without JAX."""
    if importlib.util.find_spec("jax") is None:
        return None
    os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")  # else JAX takes most of a card's memory
    import jax

    jax.config.update("jax_enable_x64", True)
    (setting,) = study.settings()
    run = program(setting.topology.name, (study.trials, setting.robots), setting.rounds, setting.observations_per_round,
                  float(str(setting.accuracy)), setting.fill_ratio)  # fmt: skip
    seconds = []
    for seed in range(4):  # the first compiles
        begun = time.perf_counter()
        jax.block_until_ready(run(jax.random.key(seed)))
        seconds.append(time.perf_counter() - begun)
    return min(seconds)


@functools.cache
def program(topology, shape, rounds, looks, accuracy, fill_ratio):
    """A compiled function of a key, which gives K and the final estimates of robots, (trial, robot)."""
    import jax
    import jax.numpy as jnp

    black = accuracy * fill_ratio + (1.0 - accuracy) * (1.0 - fill_ratio)
    shares = [math.comb(looks, k) * black**k * (1.0 - black) ** (looks - k) for k in range(looks)]
    below = jnp.cumsum(jnp.array(shares))
    slope = 2.0 * accuracy - 1.0

    def heard(values):
        if topology == "ring":
            return jnp.roll(values, 1, axis=1) + jnp.roll(values, -1, axis=1)
        return values.sum(axis=1, keepdims=True) - values

    def one_round(n, given):
        k, key = given
        n += (jax.random.uniform(key, shape)[..., None] > below).sum(axis=-1)
        t = k * looks
        low, high = (1.0 - accuracy) * t, accuracy * t
        x_hat = jnp.clip((n / t + accuracy - 1.0) / slope, 0.0, 1.0)
        ends = (t - n) / accuracy**2 + n / (1.0 - accuracy) ** 2, n / accuracy**2 + (t - n) / (1.0 - accuracy) ** 2
        within = t**3 / jnp.where((n > 0) & (n < t), n * (t - n), 1.0)
        alpha = slope**2 * jnp.where(n <= low, ends[0], jnp.where(n >= high, ends[1], within))
        total, weighted = heard(alpha), heard(alpha * x_hat)
        return n, (alpha * x_hat + weighted) / (alpha + total)

    @jax.jit
    def run(key):
        keys = jax.random.split(key, rounds)
        _, rows = jax.lax.scan(one_round, jnp.zeros(shape), (jnp.arange(1.0, rounds + 1.0), keys))
        rows = jnp.concatenate([jnp.full((1, *shape), 0.5), rows])
        near = (jax.lax.cummax(rows, axis=0, reverse=True) - rows < 0.01) & (
            rows - jax.lax.cummin(rows, axis=0, reverse=True) < 0.01
        )
        return jnp.argmax(near, axis=0), rows[-1]

    return run
