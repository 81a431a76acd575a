"""The few lines that fit one brain, or one metric, to the compiled loops: a module that is written for it."""

from swarmcensus.brains import BELIEFS, FUNCTIONS, Brain
from swarmcensus.metrics import Metric

MIND = '''"""Fits one brain to the engine. Made by swarmcensus; edits are lost."""

import numpy as np

from swarmcensus.engine.compiler import compiled

from . import brain

record = np.dtype((np.record, [(name, np.float64) for name in {fields}]))

for name, value in list(vars(brain).items()):
    if isinstance(value, type(lambda: None)):
        setattr(brain, name, compiled(value))
{functions}
steer = {steer}
outbox_width = {width}
no_sums = {no_sums}


@compiled
def pack(outbox, i, message):
    {slots} = message


@compiled
def unpack(outbox, i):
    return {slots}


@compiled
def add_sums(me, sums):
    {additions}


@compiled
def sums_with(sums, message, scratch):
    {clearing}
    receive(scratch, message)
    return {sums}
'''

GAUGE = '''"""Fits one metric to the engine. Made by swarmcensus; edits are lost."""

from swarmcensus.engine.compiler import compiled, entry  # noqa: F401

from . import metric

for name, value in list(vars(metric).items()):
    if isinstance(value, type(lambda: None)):
        setattr(metric, name, compiled(value))
begin = metric.begin
watch = metric.watch
result = metric.result
after = {after}
'''


def of_brain(brain: Brain) -> str:
    """The module `mind.py` of a brain."""
    slots = "".join(f"outbox[i, {j}], " for j in range(len(brain.message))).strip()
    return MIND.format(
        functions="\n".join(f"{name} = brain.{name}" for name in FUNCTIONS),
        steer="brain.steer" if brain.steers else "compiled(lambda me: None)",
        width=len(brain.message),
        slots=slots,
        additions="\n    ".join(f"me.{name} += sums[{j}]" for j, name in enumerate(brain.sums)) or "pass",
        sums="".join(f"sums[{j}] + scratch.{name}, " for j, name in enumerate(brain.sums)).strip() or "sums",
        clearing="\n    ".join(f"scratch.{name} = 0.0" for name in brain.sums) or "pass",
        fields=(*brain.memory, *BELIEFS),
        no_sums=(0.0,) * max(1, len(brain.sums)),
    )


def of_metric(metric: Metric) -> str:
    """The module `gauge.py` of a metric."""
    return GAUGE.format(after="metric.after" if metric.of_swarm else "compiled(lambda our, k: None)")
