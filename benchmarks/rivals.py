"""Shipped rivals in the studies of studies/rivals, and the cost of wrong beliefs: python benchmarks/rivals.py QUESTION.

With `--write` a question writes its file of benchmarks/tables, of which docs/rivals.md, docs/rivals-claims.md and
docs/paper.md show a part.
"""

from statistics import NormalDist

import harness
import numpy as np
import pandas as pd

import swarmcensus as sc
from swarmcensus.analysis.explaining.wrong_beliefs import costs
from swarmcensus.theory import asymptote

DRAWN = "N(0.0,0.05)"


def results(name):
    """The results of a shipped study."""
    study = sc.Study.load(harness.ROOT / "studies" / f"{name}.toml")
    return sc.run(study.with_(trials=harness.trials(study.trials)))


def by_setting(values, name):
    """A frame with the coordinates of each setting, and one number of it."""
    return values.to_dataframe(name).rename(columns={"fill_ratio": "f", "topology": "network"})


def error_of(data):
    """The median distance of final estimates from the fill ratio, in each setting."""
    return abs(data["final_estimate"] - data["fill_ratio"]).median(["trial", "robot"])


def wrong_robots(members):
    """The number of members that `1 black.py, not honest` and the like begin with."""
    return int(str(members).split()[0]) if members else 0


def tell(name, table, write):
    """Print a table, and write it to its file."""
    print(table.to_string(index=False))
    if write:
        harness.write_csv(name, table.columns, table.values)


@harness.question(unasked=False)
def consensus(write=False):
    """Errors of consensus protocols with none to three liars among twelve robots, on three networks."""
    data = results("rivals/consensus")
    spread = (data["final_estimate"].max("robot") - data["final_estimate"].min("robot")).median("trial")
    table = by_setting(error_of(data), "error")
    table["spread"] = spread.values
    table["liars"] = [wrong_robots(members) for members in table["members"]]
    table = table.pivot_table(["error", "spread"], ["network", "brain"], "liars", sort=False).map("{:.4f}".format)
    table.columns = [f"{what} with {liars}" for what, liars in table.columns]
    table = table.loc[["full", *(name for name in table.index.unique("network") if name != "full")]]
    tell("rivals-consensus", table.reset_index(), write)


@harness.question(unasked=False)
def opinions(write=False):
    """The percentage of trials with a right consensus, of rules for opinions and dancers."""
    data = results("rivals/opinions")
    table = by_setting(100 * data["consensus_right"].mean("trial"), "right")
    skewed = np.where(table["debiased"] == 0, "skewed", "corrected")
    table["world"] = np.where(table["accuracy"] == "1.0", "perfect", skewed) + " " + table["f"].astype(str)
    table = table.pivot_table("right", "brain", "world", sort=False).round().astype(int)
    tell("rivals-opinions", table.reset_index(), write)


@harness.question(unasked=False)
def unknown(write=False):
    """Errors of robots of which some are told a wrong accuracy."""
    data = results("rivals/unknown-sensors")
    table = by_setting(error_of(data), "error")
    table["wrong"] = [wrong_robots(members) for members in table["members"]]
    table = table.pivot_table("error", ["f", "wrong"], "brain", sort=False).map("{:.4f}".format)
    tell("rivals-unknown-sensors", table.reset_index().sort_values("f", ascending=False, kind="stable"), write)


@harness.question(unasked=False)
def strobel(write=False):
    """Mean errors of linear consensus and W-MSR among robots that always say 0."""
    data = results("rivals/strobel-2020")
    error = abs(data["final_estimate"] - data["true_fill_ratio"]).mean(["trial", "robot"])
    table = by_setting(error, "error").pivot_table("error", "liars", "brain", sort=False).map("{:.3f}".format)
    tell("strobel-2020", table.reset_index(), write)


@harness.question(unasked=False)
def beliefs(write=False):
    """Errors of robots that are wrong about their sensors, on a network and moving, and their closed form."""
    fixed, moving = (chosen(costs(results(name))) for name in ("wrong-beliefs", "wrong-beliefs-moving"))
    heads = ("accuracy", "belief", "f", "error", "low", "high", "moving robots", "low (moving)", "high (moving)")
    found = []
    for one, other in zip(fixed, moving, strict=True):
        belief = one.belief.partition("=")[2]
        formula = drawn_formula(float(one.accuracy), one.fill_ratio) if belief == DRAWN else one.predicted
        numbers = (*one[4:7], *other[4:7], formula)
        found.append((one.accuracy, belief, one.fill_ratio, *(f"{number:.4f}" for number in numbers)))
    tell("wrong-beliefs", pd.DataFrame(found, columns=[*heads, "formula"]), write)


def chosen(found):
    """The costs that both studies have, and the page speaks of."""
    return [one for one in found if one.accuracy != "0.775" and one.error in (-0.05, 0.0, 0.05, None)]


def drawn_formula(b, f):
    """The median error of robots alone with drawn errors, after endless observation."""
    drawn = np.array([NormalDist(0, 0.05).inv_cdf((k + 0.5) / 10001) for k in range(10001)])
    return np.median(np.abs(asymptote(b, b, b + drawn, b + drawn, f) - f))


if __name__ == "__main__":
    harness.answer(globals())
