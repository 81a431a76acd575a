"""Tests that take long carry the marker `long`; something quicker beside each holds a promise of the same kind.

`@pytest.mark.long(but=["ring"])` marks a test for all its parameters but those with these ids, and `only=` for none but
those; `but_every=3` for all but the first, the fourth, the seventh ...
"""

import collections
import functools

import pytest


def in_two_sizes(name, quick, long):
    """A parameter of a test, or several: small values, and large ones where there is time."""
    if isinstance(name, str):
        quick, long = (quick,), (long,)
    sizes = [pytest.param(*quick, id="quick"), pytest.param(*long, id="long", marks=pytest.mark.long)]
    return pytest.mark.parametrize(name, sizes)


def is_meant(mark, item, number):
    """Whether a marker is for this parameter of a test, the so-manyth from 0 on."""
    [(word, given)] = mark.kwargs.items() or [("only", [item.callspec.id] if hasattr(item, "callspec") else None)]
    if word == "but_every":
        return number % given != 0
    return given is None or (item.callspec.id in given) == (word == "only")


def fault_of(items, named):
    """What is wrong with the markers of one test's parameters, if anything; ids only where not some are `named`."""
    ids = [item.callspec.id for item in items if hasattr(item, "callspec")]
    for mark in items[0].iter_markers("long"):
        if not mark.args and not mark.kwargs:
            continue
        [word, given] = next(iter(mark.kwargs.items()), (None, None))
        right = isinstance(given, int) and given > 1 if word == "but_every" else isinstance(given, list)
        if mark.args or len(mark.kwargs) != 1 or word not in ("but", "only", "but_every") or not right:
            return "long takes one of but=[ids], only=[ids], but_every=2 or more"
        if not ids:
            return f"long({word}=...) is for tests with parameters"
        if all(mark not in item.own_markers for item in items):
            return f"long({word}=...) belongs to a test, not to a class or a file"
        if word != "but_every" and not named and (wrong := [one for one in given if one not in ids]):
            return f"long({word}=...) names {', '.join(map(repr, wrong))}: the ids are {', '.join(map(repr, ids))}"
    return None


class Long:
    """Takes the marker from the parameters that it is not for, and tells at the end of a run what was left out."""

    def __init__(self, config):
        self.config = config
        self.left_out = 0

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_modifyitems(self, items):
        named = any("::" in word for word in self.config.args)
        tests = collections.defaultdict(list)
        for item in items:
            tests[item.nodeid.partition("[")[0]].append(item)
        for parameters in tests.values():
            fault = fault_of(parameters, named)
            for number, item in enumerate(parameters):
                marks = item.own_markers
                item.own_markers = [
                    m for m in marks if m.name != "long" or (not fault and is_meant(m, item, number))
                ]  # fmt: skip
                if fault:  # an error here would be none of xdist's business: it says less
                    item.runtest = functools.partial(pytest.fail, fault, pytrace=False)

    def pytest_deselected(self, items):
        if "not long" not in self.config.option.markexpr or self.config.option.keyword:
            return  # it is not told whether -m or -k left them out
        self.left_out += sum(item.get_closest_marker("long") is not None for item in items)

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node):
        self.left_out = max(self.left_out, getattr(node, "workeroutput", {}).get("left_out", 0))

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_sessionfinish(self):
        if hasattr(self.config, "workeroutput"):
            self.config.workeroutput["left_out"] = self.left_out
        yield
        terminal = self.config.pluginmanager.get_plugin("terminalreporter")
        if terminal and self.left_out:
            were = "long tests were" if self.left_out > 1 else "long test was"
            terminal.write_line(f"{self.left_out} {were} left out: `pytest -n 2` runs all tests")
