"""Whatever is changed in a results file is noticed; nothing is opened or run that only such a file names."""

from pathlib import Path

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import verifying
from swarmcensus.errors import InputError

DATA = Path(__file__).parent / "data"
PLAIN = """
name = "apart"
seed = 3
trials = {trials}
[swarm]
robots = [2, 3]
accuracy = [0.7, "U(0.6, 0.9)"]
assumed_accuracy = 0.75
[world]
topology = ["ring", "full"]
fill_ratio = [0.3, 0.6]
link_success = 0.9
[schedule]
rounds = [4, 8]
observations_per_round = 2
[measure]
checkpoints = [2, 8]
local = true
estimates = true
"""
RULE = '{until = "convergence_error median +- 0.05", at_least = 6, at_most = 9}'

# Attributes of a file that nothing can be held against: who made it, and when.
EXEMPT = {
    "python_version": "of the maker", "library_versions": "of the maker", "machine": "of the maker",
    "processor": "of the maker", "started": "time", "finished": "time", "wall_seconds": "time", "cpu_seconds": "time",
}  # fmt: skip
OF_NETCDF = ("CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST", "_Netcdf4Dimid", "_Netcdf4Coordinates")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A file that holds all kinds of settings, one with all that can be measured, one of a rule, and a merged one."""
    here = tmp_path_factory.mktemp("trust")
    sc.save(sc.run(sc.Study.load(DATA / "results.toml"), jobs=1), here / "kinds.nc")
    for name, trials in (("measures", 2), ("rule", RULE)):
        text = PLAIN.format(trials=trials)
        if name == "rule":
            text = text.replace("local = true\nestimates = true\n", "").replace('["ring", "full"]', '"ring"')
            text = text.replace("[0.3, 0.6]", "0.3").replace("[2, 3]", "3")
        sc.save(sc.run(sc.Study.parse(text), jobs=1), here / f"{name}.nc")
    one, two = PLAIN.format(trials=2), PLAIN.format(trials=1).replace("[2, 8]", "[4]").replace("0.3, 0.6", "0.6, 0.9")
    parts = [sc.run(sc.Study.parse(text.replace("local = true\n", "")), jobs=1) for text in (one, two)]
    sc.save(sc.merge(parts), here / "merged.nc")
    return here


@pytest.fixture
def quick(monkeypatch):
    """Trials that were run again once are not run a third time: the same study gives the same numbers."""
    known, recompute = {}, verifying.recompute

    def remembered(study, settings, wanted, *rest):
        key = study.text, tuple(settings), wanted.tobytes(), rest[0]
        if key not in known:
            known[key] = recompute(study, settings, wanted, *rest)
        return known[key]

    monkeypatch.setattr(verifying, "recompute", remembered)


def noticed(results):
    try:
        found = sc.verify(results, 1.0, jobs=1)
    except InputError:
        return True
    return bool(found.differences or found.labels or found.notes)


def others(values):
    """Other arrays of the same shape and kind."""
    flat = values.ravel()
    kinds = {"O": ("other", ""), "U": ("other", ""), "i": (7, -1, 0), "u": (7, 0), "f": (0.125, np.nan, 1e300)}
    for place in (0, flat.size - 1):
        for value in kinds[values.dtype.kind]:
            changed = flat.copy()
            changed[place] = value
            yield f"[{place}] = {value!r}", changed.reshape(values.shape)
    for axis in range(values.ndim):
        yield f"reversed along {axis}", np.flip(values, axis)
    if values.dtype.kind == "f":
        yield "the next numbers", np.nextafter(values, 2.0)


def changes(data):
    """Every way in which something of a dataset is changed: what is changed, and the dataset with it."""
    for name, variable in data.variables.items():
        for how, values in others(variable.values):
            pairs = zip(values.ravel(), variable.values.ravel(), strict=True)
            if not all(a == b or (a != a and b != b) for a, b in pairs):
                yield f"{name} {how}", data.assign({name: (variable.dims, values, variable.attrs)})
        yield f"{name} removed", data.drop_vars(name)
        yield f"{name} twice", data.assign({f"{name}_too": variable})
        for key, value in variable.attrs.items():
            for other in (value + type(value)("1"), None):
                changed = data.copy()
                changed[name].attrs = {k: v for k, v in (variable.attrs | {key: other}).items() if v is not None}
                yield f"{name}:{key} = {other}", changed
    for key, value in data.attrs.items():
        for other in (value + type(value)("1"), value * 0, None):
            kept = {k: v for k, v in (data.attrs | {key: other}).items() if v is not None}
            if key not in EXEMPT:
                yield f"{key} = {other}", data.drop_attrs(deep=False).assign_attrs(kept)


@pytest.mark.parametrize("name", ["kinds", "measures", "rule", "merged"])
def test_whatever_is_changed_is_noticed(name, files, quick):
    """Every variable, coordinate and attribute that is in the file, in several ways each."""
    data = sc.load(files / f"{name}.nc")
    assert not noticed(data)
    ways = dict(changes(data))
    assert len(ways) > 150
    assert [what for what, changed in ways.items() if not noticed(changed)] == []
