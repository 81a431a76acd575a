"""The few lines that fit one brain, or one metric, to the compiled loops: a module that is written for it."""

import ast
from collections.abc import Iterable

from swarmcensus.brains import BELIEFS, FUNCTIONS, Brain
from swarmcensus.metrics import Metric

DECLARED = ("MEMORY", "MESSAGE", "SUMS")

MIND = '''"""Fits one brain to the engine. Made by swarmcensus; edits are lost."""

import numpy as np

from swarmcensus.engine.calling import nobody
from swarmcensus.engine.compiler import compiled

from . import brain

record = np.dtype((np.record, [(name, np.float64) for name in {fields}]))

for name, value in list(vars(brain).items()):
    if isinstance(value, type(lambda: None)):
        setattr(brain, name, compiled(value))
{functions}
steer = {steer}
width = {width}


@compiled
def say(outbox, i, me):
    {names} = broadcast(me)
    {saying}


@compiled
def take(me, outbox, i):
    {taking}


@compiled
def sums_of(me):
    return {own}


@compiled
def sums_with(sums, outbox, i):
    return {more}


@compiled
def sums_at(rows, i):
    return {kept}


@compiled
def keep_sums(rows, i, sums):
    {keeping}


@compiled
def put_sums(me, sums):
    {putting}


@compiled
def add_sums(me, sums):
    {adding}
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


def essence(source: str) -> str:
    """What of a brain's file machine code depends on: no comment, no docstring, no number that MEMORY begins with."""
    tree = ast.parse(source)
    read = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)}
    tree.body = [node for node in tree.body if not _is_declaration(node, read)]
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.FunctionDef):
            said = [one for one in node.body if not (isinstance(one, ast.Expr) and isinstance(one.value, ast.Constant))]
            node.body = said or [ast.Pass()]
    try:
        return ast.unparse(tree)
    except RecursionError:  # an expression of hundreds of terms
        return source


def _is_declaration(node: ast.stmt, read: set[str]) -> bool:
    """Whether this is MEMORY, MESSAGE or SUMS, which the engine knows from elsewhere, and nobody in the file reads."""
    if not isinstance(node, ast.Assign) or len(node.targets) != 1 or not isinstance(node.targets[0], ast.Name):
        return False
    return node.targets[0].id in DECLARED and node.targets[0].id not in read


def of_brain(brain: Brain) -> str:
    """The module `mind.py` of a brain.

    Where `receive` only adds, what a message adds is found once, when it is said, and not by everyone who hears it.
    """
    names = [f"said_{k}" for k in range(len(brain.message))]
    given = "".join(f"1.0 * {name}, " for name in names)
    slots = [f"outbox[i, {k}]" for k in range(outbox_width(brain))]
    if brain.sums:
        saying = ["hearer = nobody(record)", f"receive(hearer, ({given}))"]
        saying += [f"{slot} = hearer.{name}" for slot, name in zip(slots, brain.sums, strict=True)]
        taking = [f"me.{name} += {slot}" for slot, name in zip(slots, brain.sums, strict=True)]
    else:
        saying = [f"{slot} = 1.0 * {name}" for slot, name in zip(slots, names, strict=True)]
        taking = [f"receive(me, ({', '.join(slots)},))"]
    return MIND.format(
        fields=(*brain.memory, *BELIEFS),
        functions="\n".join(f"{name} = brain.{name}" for name in FUNCTIONS),
        steer="brain.steer" if brain.steers else "compiled(lambda me: None)",
        width=len(slots),
        names="".join(f"{name}, " for name in names).strip(),
        saying="\n    ".join(saying),
        taking="\n    ".join(taking),
        own=_tuple(f"me.{name}" for name in brain.sums),
        more=_tuple(f"sums[{k}] + {slot}" for k, slot in enumerate(slots[: len(brain.sums)])),
        kept=_tuple(f"rows[i, {k}]" for k, _ in enumerate(brain.sums)),
        keeping="\n    ".join(f"rows[i, {k}] = sums[{k}]" for k, _ in enumerate(brain.sums)) or "pass",
        putting="\n    ".join(f"me.{name} = sums[{k}]" for k, name in enumerate(brain.sums)) or "pass",
        adding="\n    ".join(f"me.{name} += sums[{k}]" for k, name in enumerate(brain.sums)) or "pass",
    )


def _tuple(items: Iterable[str]) -> str:
    return f"({''.join(f'{item}, ' for item in items) or '0.0,'})"


def outbox_width(brain: Brain) -> int:
    """How many numbers the engine keeps of a message: what it adds, where `receive` only adds."""
    return len(brain.sums or brain.message)


def of_metric(metric: Metric) -> str:
    """The module `gauge.py` of a metric."""
    return GAUGE.format(after="metric.after" if metric.of_swarm else "compiled(lambda our, k: None)")
