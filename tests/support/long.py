"""Tests that take long carry the marker `long`; something quicker beside each holds a promise of the same kind.

`@pytest.mark.long(but=["ring"])` marks a test for all its parameters but those with these ids, and `only=` for none but
those; `but_every=3` for all but the first, the fourth, the seventh ...
"""

import itertools

import pytest


def in_two_sizes(name, quick, long):
    """A parameter of a test, or several: small values, and large ones where there is time."""
    if isinstance(name, str):
        quick, long = (quick,), (long,)
    sizes = [pytest.param(*quick, id="quick"), pytest.param(*long, id="long", marks=pytest.mark.long)]
    return pytest.mark.parametrize(name, sizes)


def is_meant(ids, number, *, but=None, only=None, but_every=None):
    """Whether a marker is for this one of a test's parameters. Raises ValueError where it names an id that is not."""
    if but_every is not None:
        return number % but_every != 0
    if wrong := {*(but or only or [])} - {*ids}:
        raise ValueError(f"long names {', '.join(sorted(wrong))}: the ids are {', '.join(ids)}")
    return ids[number] not in but if but else only is None or ids[number] in only


class Long:
    """Takes the marker from the parameters that it is not for."""

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_modifyitems(self, config, items):
        for name, same in itertools.groupby(items, lambda item: item.nodeid.partition("[")[0]):
            parameters = list(same)
            ids = [item.callspec.id if hasattr(item, "callspec") else "" for item in parameters]
            for number, item in enumerate(parameters):
                try:
                    item.own_markers = [
                        mark for mark in item.own_markers
                        if mark.name != "long" or is_meant(ids, number, *mark.args, **mark.kwargs)
                    ]  # fmt: skip
                except (TypeError, ValueError) as error:
                    if not any("::" in word for word in config.args):  # which may leave ids out
                        raise ValueError(f"{name}: {error}") from error
