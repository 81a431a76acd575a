"""The README's table of five brains, in the worlds of the leaderboard: python benchmarks/first_page.py."""

import tomllib

import harness
import numpy as np

import swarmcensus as sc
from swarmcensus.studies.study import Study
from swarmcensus.support.files import shipped_study
from swarmcensus.support.toml_text import to_toml

BRAINS = {  # and where another is better
    "census": "robots that may lie, black in large patches, small or early changes, or radios that pause",
    "commons": "robots that may lie, or a floor that changes",
    "steadfast": "black in large patches, or poor sensors and little time",
    "minimalistic": "a small error of all robots",
    "alone": "robots that can talk",
}
HEADS = ["brain", "error", "worst robot", "rounds", "bytes", "among liars", "not for"]


def rows_of(table):
    """A row a brain: means over worlds, the median over worlds of rounds, and the tail among liars."""
    fixed = table[table["fill_ratio_change"] == ""]
    for name, unfit in harness.few([*BRAINS.items()]):
        one = fixed[fixed["brain"] == name]
        honest, lying = one[one["liars"] == 0], one[one["liars"] > 0]
        rounds = honest["agreement_round"].median()
        yield [
            name,
            f"{honest['final_error'].mean():.4f}",
            f"{honest['worst_error'].mean():.4f}",
            f"{rounds:.0f}" if np.isfinite(rounds) else "–",
            f"{(one['bytes_sent'] / one['rounds']).mean():.0f}",
            f"{lying['error_90'].mean():.4f}",
            unfit,
        ]


@harness.question
def five(write=False):
    """Error, worst robot, rounds, bytes, and error among liars: three minutes on two cores.

    With --write, they go into benchmarks/tables/five-brains.csv and the README.
    """
    worlds = tomllib.loads(shipped_study("leaderboard.toml").read_text(encoding="utf-8"))
    worlds["swarm"]["brain"] = harness.few([*BRAINS])
    worlds["trials"] = harness.trials(worlds["trials"])
    rows = [*rows_of(sc.summary(sc.run(Study.parse(to_toml(worlds)))))]
    table = harness.table("Five brains in the worlds of the leaderboard", *HEADS)
    for row in rows:
        table.add_row(*row)
    harness.show(table)
    if write:
        harness.write_csv("five-brains", HEADS, rows)


if __name__ == "__main__":
    harness.answer(globals())
