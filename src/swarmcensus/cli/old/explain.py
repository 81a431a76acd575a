"""The command `explain`: measurements next to theory. Imports wait until the command needs them."""

import argparse
import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from swarmcensus.cli.options import Command, Group, add_shared

from swarmcensus.cli.output import present
from swarmcensus.cli.source import MOST_ROWS, add_limit_option, add_source_options, again, read
from swarmcensus.support.formatting import counted, fixed
from swarmcensus.support.options import misplaced

if TYPE_CHECKING:
    from swarmcensus.analysis import Explanation, Interval
    from swarmcensus.support.printed_tables import Column

NAMES = {
    "alone": "a robot alone",
    "neighbourhood": "its neighbourhood",
    "mixed": "mixed sums",
    "swarm": "the whole swarm",
}  # lines of theory, in the order of the table
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
    add_shared(sub, setting="default: all")
    add_limit_option(sub, "; in a pipe: all")


def explain(options: argparse.Namespace) -> int:
    """Explain one setting, or compare all with theory."""
    from swarmcensus.analysis import one_setting
    from swarmcensus.results import asked_anew, say_partial

    if options.setting is None:
        return _all(options)
    for name in ("where", "limit"):
        if getattr(options, name) is not None:
            raise misplaced(name, None, "does not go with --setting, which shows one setting")
    data = read(options).stored
    explanation = one_setting.explain(data, options.setting)
    say_partial(data, options.results)
    present(
        options,
        "explanation",
        lambda: explanation._asdict() | {"asked_anew": asked_anew(data)},
        lambda: records(explanation),
        lambda: show(explanation, str(options.results)),
        lambda: sentences(explanation),
    )
    return 0


def _all(options: argparse.Namespace) -> int:
    from swarmcensus.cli.tables import head

    from swarmcensus.analysis import agreement
    from swarmcensus.cli import explain_table
    from swarmcensus.results import asked_anew

    if options.json and options.limit is not None:
        raise misplaced("limit", options.limit, "does not go with --json, which has all settings")
    stored, data = read(options)
    result = agreement(data)
    title, line = head(stored, options.results), again(options, "explain")
    limit = MOST_ROWS if options.limit is None else options.limit
    present(
        options,
        "agreement",
        lambda: result._asdict() | {"asked_anew": asked_anew(data)},
        lambda: explain_table.records(result)[: options.limit or None],
        lambda: explain_table.show(result, data, title, line, limit),
        lambda: [*explain_table.coverage(result), *([explain_table.verdict_of(result)] if result.exact else [])],
    )
    return 0


def show(explanation: "Explanation", path: str) -> None:
    """Print what one setting measured and what theory expects, then what its error consists of."""
    from swarmcensus.support import terminal
    from swarmcensus.support.printed_tables import Table

    title = f"{path}, setting {explanation.setting}: {explanation.what}; {counted(explanation.trials, 'trial')}"
    when = f"after {explanation.rounds:,} {explanation.unit}"
    notes = [f"error: the median of |x - f|; error, sd, bias: {when}"]
    notes += [f"{NAMES[name]}: {MEANS[name]}" for name in NAMES if name in explanation.theory]
    terminal.show(Table(_columns(explanation), title=title, notes=lambda _: notes))
    for sentence in sentences(explanation):
        terminal.console().print(sentence)


def sentences(explanation: "Explanation") -> "Iterator[str]":
    """K, what the error consists of, and what theory has no line for."""
    k, low, high = explanation.convergence_round
    yield f"K: {fixed(k)} {explanation.unit}" + (f" [{fixed(low)}, {fixed(high)}]" if math.isfinite(low) else "")
    total = sum(explanation.terms.values())
    if explanation.terms and total < NEGLIGIBLE:
        yield f"mean squared error: {total:.3g}, due to rounding or a prior: nothing limits it"
    elif explanation.terms:
        value, low, high = explanation.efficiency
        ends = f" [{low:.3g}, {high:.3g}]" if math.isfinite(low) else ""
        yield f"efficiency: {value:.3g}{ends}, the bound of the whole swarm over the mean squared error"
        parts = ", ".join(f"{name} {100 * part / total:.0f} %" for name, part in explanation.terms.items())
        yield f"mean squared error: {explanation.squared_error[0]:.3g}, made of {parts}"
        yield f"What limits it most is {explanation.limit}"
    for why in dict.fromkeys(explanation.absent.values()):
        names = [NAMES[name] for name, reason in explanation.absent.items() if reason == why]
        missing = "no line of theory" if len(names) == len(NAMES) else f"no line for {', '.join(names)}"
        yield f"{missing}: {why}"


def records(explanation: "Explanation") -> "list[dict[str, Any]]":
    """A flat record for what was measured, and one for each line of theory; `right_K` is the share at round K."""
    from swarmcensus.support.printed_tables import with_ends

    checkpoints = explanation.checkpoints
    right = {f"right_{k}": interval for k, interval in zip(checkpoints, explanation.right, strict=True)}
    error = {"error": explanation.median_error, "sd": explanation.sd, "bias": explanation.bias}
    measured = with_ends({"line": "measured"} | error | right)
    return [measured] + [
        {"line": name, "error": line.median_error[-1], "sd": line.sd[-1], "bias": line.bias[-1]}
        | {f"right_{k}": line.right[place] for place, k in enumerate(checkpoints)}
        for name, line in explanation.theory.items()
    ]


def _columns(explanation: "Explanation") -> "list[Column]":
    """The columns of the table; a narrow terminal has fewer checkpoints between the first and the last."""
    from swarmcensus.support.printed_tables import Column

    last = len(explanation.checkpoints) - 1
    few = min(last, MOST_CHECKPOINTS - 1)
    shown = [last - round(k * last / few) for k in range(few, -1, -1)] if few > 0 else [last] * (last >= 0)
    known = math.isfinite(explanation.median_error[1])
    lines = [(NAMES[name], explanation.theory[name]) for name in NAMES if name in explanation.theory]
    interval = ["[95 %]"] * known
    columns = [Column("", ["measured", *interval, *(name for name, _ in lines)], number=False)]
    for name, measured, end in (
        ("error", explanation.median_error[0], _ends(explanation.median_error, _number)),
        ("sd", explanation.sd, ""),
        ("bias", explanation.bias, ""),
    ):
        field = "median_error" if name == "error" else name
        theory = [_number(float(getattr(line, field)[-1])) for _, line in lines]
        columns.append(Column(name, [_number(measured), *[end] * known, *theory]))
    for place, k in enumerate(shown):
        head = f"right % at {explanation.checkpoints[k]:,}" if place == 0 else f"at {explanation.checkpoints[k]:,}"
        cells = [_percent(explanation.right[k][0]), *[_ends(explanation.right[k], _percent)] * known]
        spare = len(shown) - place if 0 < place < len(shown) - 1 else 0
        columns.append(Column(head, [*cells, *(_percent(float(line.right[k])) for _, line in lines)], spare=spare))
    return columns


def _number(value: float) -> str:
    return f"{round(value, 4) + 0.0:.4f}"  # no -0.0000


def _percent(value: float) -> str:
    return f"{100.0 * value:.1f}"


def _ends(interval: "Interval", form: Callable[[float], str]) -> str:
    return f"[{form(interval[1])}, {form(interval[2])}]" if math.isfinite(interval[1]) else ""


COMMANDS = (
    Command(
        "explain", "Compare results with theory, and show what limits the error.",
        Group.STUDIES, 6, explain, add_explain_options, table=True,
    ),
)  # fmt: skip
