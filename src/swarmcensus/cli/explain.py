"""The command `explain`: measurements beside theory. Imports wait until the command needs them."""

import argparse
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from swarmcensus.basics.formatting import counted
from swarmcensus.cli.options import from_zero
from swarmcensus.cli.output import answer
from swarmcensus.cli.source import MOST_ROWS, add_limit_option, add_source_options, again, read

if TYPE_CHECKING:
    from swarmcensus.explaining.one_setting import Explanation, Interval

NAMES = {
    "alone": "a robot alone",
    "neighbourhood": "its neighbourhood",
    "mixed": "mixed sums",
    "swarm": "the whole swarm",
}  # lines of theory, in the order that they are shown
MEANS = {
    "alone": "exact, for a robot that hears nobody",
    "neighbourhood": "the smallest error of any unbiased estimate from the readings of a robot and its neighbours",
    "mixed": "running sums of evidence, mixed and divided on the same network",
    "swarm": "the smallest error of any unbiased estimate from all readings",
}
NEGLIGIBLE = 1e-12  # a squared error of this size is due to rounding or to a prior
MOST_CHECKPOINTS = 6  # shown in the table


def add_explain_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `explain`."""
    add_source_options(sub)
    sub.add_argument(
        "--setting", type=from_zero, metavar="N", help="explain this setting, by its number in 'show' (default: all)"
    )
    add_limit_option(sub)


def explain(options: argparse.Namespace) -> int:
    """Explain one setting, or compare all with theory."""
    from swarmcensus.basics.errors import InputError
    from swarmcensus.explaining import one_setting
    from swarmcensus.results.partial import say_partial
    from swarmcensus.results.summaries import asked_anew

    if options.setting is None:
        return _all(options)
    for name in ("where", "limit"):
        if getattr(options, name) is not None:
            raise InputError(f"--{name} does not go with --setting, which shows one setting")
    data = read(options).stored
    explanation = one_setting.explain(data, options.setting)
    say_partial(data, options.results)
    if options.json:
        answer("explanation", explanation._asdict() | {"asked_anew": asked_anew(data)})
    else:
        show(explanation, str(options.results))
    return 0


def _all(options: argparse.Namespace) -> int:
    from swarmcensus.basics.errors import InputError
    from swarmcensus.cli import explain_table
    from swarmcensus.cli.tables import head
    from swarmcensus.explaining.agreement import agreement
    from swarmcensus.results.summaries import asked_anew

    if options.json and options.limit is not None:
        raise InputError(f"--limit {options.limit} does not go with --json, which has all settings")
    stored, data = read(options)
    result = agreement(data)
    if options.json:
        answer("agreement", result._asdict() | {"asked_anew": asked_anew(data)})
        return 0
    limit = MOST_ROWS if options.limit is None else options.limit
    explain_table.show(result, data, head(stored, options.results), again(options, "explain"), limit)
    return 0


def show(explanation: "Explanation", path: str) -> None:
    """Print what one setting measured and what theory expects, then what its error consists of."""
    from swarmcensus.basics.terminal import UNFOLDED, console

    out = console()
    out.print(f"{path}, setting {explanation.setting}: {explanation.what}; {counted(explanation.trials, 'trial')}")
    for most in range(MOST_CHECKPOINTS, 0, -1):  # as many checkpoints as the terminal has room for
        rows = _table(explanation, most)
        if rows.__rich_measure__(out, out.options.update(max_width=UNFOLDED)).maximum <= out.width:
            break
    out.print(rows)
    out.print(
        f"error: the median of |x - f|; error, sd, bias: after {explanation.rounds:,} {explanation.unit}", style="dim"
    )
    for name in (name for name in NAMES if name in explanation.theory):
        out.print(f"{NAMES[name]}: {MEANS[name]}", style="dim")
    k, low, high = explanation.convergence_round
    out.print(f"K: {k:,.0f} {explanation.unit}" + (f" [{low:,.0f}, {high:,.0f}]" if math.isfinite(low) else ""))
    total = sum(explanation.terms.values())
    if explanation.terms and total < NEGLIGIBLE:
        out.print(f"mean squared error: {total:.3g}, due to rounding or a prior: nothing limits it")
    elif explanation.terms:
        value, low, high = explanation.efficiency
        ends = f" [{low:.3g}, {high:.3g}]" if math.isfinite(low) else ""
        out.print(f"efficiency: {value:.3g}{ends}, the bound of the whole swarm over the mean squared error")
        parts = ", ".join(f"{name} {100 * part / total:.0f} %" for name, part in explanation.terms.items())
        out.print(f"mean squared error: {explanation.squared_error[0]:.3g}, made of {parts}")
        out.print(f"What limits it most is {explanation.limit}")
    for why in dict.fromkeys(explanation.absent.values()):
        names = [NAMES[name] for name, reason in explanation.absent.items() if reason == why]
        missing = "no line of theory" if len(names) == len(NAMES) else f"no line for {', '.join(names)}"
        out.print(f"{missing}: {why}")


def _table(explanation: "Explanation", most: int) -> Any:
    from swarmcensus.basics.terminal import table

    last = len(explanation.checkpoints) - 1
    few = min(last, most - 1)
    shown = [last - round(k * last / few) for k in range(few, -1, -1)] if few > 0 else [last] * (last >= 0)
    heads = [("", False), ("error", True), ("sd", True), ("bias", True)]
    heads += [(f"right % at {explanation.checkpoints[k]:,}", True) for k in shown[:1]]
    heads += [(f"at {explanation.checkpoints[k]:,}", True) for k in shown[1:]]
    rows = [
        ["measured", _number(explanation.median_error[0]), _number(explanation.sd), _number(explanation.bias)]
        + [_percent(explanation.right[k][0]) for k in shown]
    ]
    if math.isfinite(explanation.median_error[1]):
        ends = [_ends(explanation.right[k], _percent) for k in shown]
        rows.append(["[95 %]", _ends(explanation.median_error, _number), "", "", *ends])
    for name, line in ((name, explanation.theory[name]) for name in NAMES if name in explanation.theory):
        numbers = [_number(float(part[-1])) for part in (line.median_error, line.sd, line.bias)]
        rows.append([NAMES[name], *numbers, *(_percent(float(line.right[k])) for k in shown)])
    return table(heads, rows)


def _number(value: float) -> str:
    return f"{round(value, 4) + 0.0:.4f}"  # no -0.0000


def _percent(value: float) -> str:
    return f"{100.0 * value:.1f}"


def _ends(interval: "Interval", form: Callable[[float], str]) -> str:
    return f"[{form(interval[1])}, {form(interval[2])}]" if math.isfinite(interval[1]) else ""
