"""The command `explain`: measurements next to theory."""

from swarmcensus.cli.parameters import Results, Setting, Where
from swarmcensus.cli.source import read
from swarmcensus.support.answers import Answer
from swarmcensus.support.options import command as shell_line, option_conflict


def explain(results: Results, /, *, where: Where = None, setting: Setting = None) -> Answer:
    """Compare results with theory, and show what limits the error."""
    if setting is not None and where is not None:
        raise option_conflict("where", None, "does not go with --setting, which shows one setting")
    stored, data = read(results, where)
    from swarmcensus.analysis import explain as explanation_of
    from swarmcensus.results import say_partial
    from swarmcensus.summaries import Summary

    found = explanation_of(data, setting)
    if setting is None:
        found.title = Summary(stored, data, path=results).title
        found.next = shell_line("swarmcensus", "explain", results, "--setting", data["setting"].values[0])
    else:
        found.title = f"{results}, {found.title}"
        say_partial(data, results)
    return found
