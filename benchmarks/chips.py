"""What every shipped brain takes of an ATmega328P: python benchmarks/chips.py [--write] [BRAIN ...].

Prints flash, RAM, stack and cycles a tick, of brains as C in single precision, and whether a Kilobot has room for them.
With --write the table goes into docs/in-c.md. It needs the packages of tools/install-chips.sh.
"""

import argparse
from pathlib import Path

from swarmcensus.brains import load
from swarmcensus.brains.brain import shipped
from swarmcensus.deployment import chips
from swarmcensus.deployment.costs import COLUMNS, cost

PAGE = Path(__file__).parents[1] / "docs" / "in-c.md"
BEGIN, END = "<!-- costs: python benchmarks/chips.py --write -->", "<!-- end of costs -->"
HEAD = f"| {' | '.join(column.name for column in COLUMNS)} |\n|---|{'--:|' * (len(COLUMNS) - 2)}---|"


def row(one):
    name, *cells = (column.text(one) for column in COLUMNS)
    larger = "\\*" if one.chip != chips.KILOBOT else ""
    return f"| `{name}`{larger} | {' | '.join(cells)} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="put the table into docs/in-c.md")
    parser.add_argument("brains", nargs="*", metavar="BRAIN", help="a name or a file (default: all shipped brains)")
    options = parser.parse_args()
    table = "\n".join([HEAD, *(row(cost(load(name))) for name in options.brains or shipped())])
    print(table)
    if options.write:
        before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
        PAGE.write_text(f"{before}{BEGIN}\n\n{table}\n\n{END}{rest.partition(END)[2]}", encoding="utf-8")


if __name__ == "__main__":
    main()
