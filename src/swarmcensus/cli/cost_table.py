"""What brains take of the chip of a Kilobot, measured and printed: `brains --cost`."""

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from swarmcensus.basics.formatting import counted
from swarmcensus.cli.output import present, say

if TYPE_CHECKING:
    from swarmcensus.deployment.costs import Cost


def show_costs(options: argparse.Namespace) -> None:
    """Measure the brains of --cost, all shipped ones if none is named, and print what they take."""
    from swarmcensus.brains import load, shipped
    from swarmcensus.deployment.costs import check_tools, cost

    brains = [load(name) for name in options.cost or shipped()]
    check_tools()
    say(f"measuring {counted(len(brains), 'brain')}, each for about half a second")
    costs = [cost(brain) for brain in brains]
    rows = [_as_dict(one) for one in costs]
    present(options, "costs", lambda: {"costs": rows}, lambda: rows, lambda: _show(costs))


def _as_dict(one: "Cost") -> dict[str, Any]:
    more = {"milliseconds": one.milliseconds, "fits_kilobot": not one.too_large, "too_large": one.too_large}
    return one._asdict() | more


def _show(costs: "Sequence[Cost]") -> None:
    from swarmcensus.basics.printed_tables import Table
    from swarmcensus.basics.terminal import show
    from swarmcensus.deployment.chips import CLOCK, KILOBOT
    from swarmcensus.deployment.costs import COLUMNS

    columns = [column for column in COLUMNS if column.short]
    heads = {column.short: column not in (columns[0], columns[-1]) for column in columns}
    rows = [[column.text(one) for column in columns] for one in costs]
    for row, one in zip(rows, costs, strict=True):
        row[0] += "*" * (one.chip != KILOBOT)
    show(Table.of_rows(heads, rows))
    print()
    print("flash, RAM, stack and message: bytes of an ATmega328P, in single precision, with messages in ratio16")
    print(f"cycles: of a tick, on average; longest: of the longest tick; ms: of a tick, at {CLOCK / 1e6:g} MHz")
    print("Kilobot: whether a Kilobot has room, and if not, what is too large")
    if any(one.chip != KILOBOT for one in costs):
        print("*: its memory has no room on an ATmega328P, and its cycles are those of an ATmega1284P")
