"""Tests that take long carry the marker `long`; something quicker beside each holds a promise of the same kind.

`@pytest.mark.long(but=["ring"])` marks a test for all its parameters but those with these ids, and `only=` for none but
those; `but_every=3` for all but the first, the fourth, the seventh ...
"""

import collections

import pytest

LEFT_OUT = "long tests were left out: `pytest -n 2` runs them too"


def in_two_sizes(name, quick, long):
    """A parameter of a test, or several: small values, and large ones where there is time."""
    if isinstance(name, str):
        quick, long = (quick,), (long,)
    sizes = [pytest.param(*quick, id="quick"), pytest.param(*long, id="long", marks=pytest.mark.long)]
    return pytest.mark.parametrize(name, sizes)


def is_meant(mark, item, number):
    """Whether a marker is for this parameter of a test, the so-manyth from 0 on."""
    if "but_every" in mark.kwargs:
        return number % mark.kwargs["but_every"] != 0
    if "only" in mark.kwargs:
        return item.callspec.id in mark.kwargs["only"]
    return not mark.kwargs or item.callspec.id not in mark.kwargs["but"]


class Long:
    """Takes the marker from the parameters that it is not for, and tells at the end of a run what was left out."""

    def __init__(self, config):
        self.config = config
        self.left_out = 0

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_modifyitems(self, items):
        unknown, seen = {}, collections.Counter()
        for item in items:
            number = seen[item.function]
            seen[item.function] += 1
            for mark in item.iter_markers("long"):
                named = {*mark.kwargs.get("but", ()), *mark.kwargs.get("only", ())}
                if named:
                    test = item.nodeid.removesuffix(f"[{item.callspec.id}]")
                    unknown[test] = unknown.get(test, named) - {item.callspec.id}
            item.own_markers = [
                mark for mark in item.own_markers if mark.name != "long" or is_meant(mark, item, number)
            ]
        unknown = {test: names for test, names in unknown.items() if names}
        if unknown and not any("::" in word for word in self.config.args):
            raise pytest.UsageError(f"long tests are named by parameters that they have not: {unknown}")

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
            terminal.write_line(f"{self.left_out} {LEFT_OUT}")
