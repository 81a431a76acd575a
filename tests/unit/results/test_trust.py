"""Whatever is changed in a results file is noticed; nothing is opened or run that only such a file names."""

import contextlib
import json
import shutil

import h5py
import numpy as np
import pytest
import xarray as xr

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.cli.commands import main
from swarmcensus.results import MAY_DIFFER, netcdf
from swarmcensus.results.store import load_packed
from swarmcensus.results.values import ALL_VARIABLES
from swarmcensus.runs import verifying
from swarmcensus.support import plugins
from swarmcensus.support.errors import InputError
from swarmcensus.worlds import networks, pictures
from tests.support.places import DATA
from tests.support.small import study_of

OTHER_NAN = np.array(0xFFF8000000000001, np.uint64).view(np.float64).item()
NUMBERS = {"f": (0.125, np.nan, OTHER_NAN, np.inf, -np.inf, 1e300, 0.0, -0.0), "i": (7, -1, 0, -2), "u": (7, 0)}
TYPES = {"f": ("f4", ">f8", "i8"), "i": ("i2", "f8", "u8", ">i8"), "u": ("i4", "f8"), "O": ()}


def same(one, other):
    """Whether two arrays are the same to the last bit, type and all."""
    if one.dtype != other.dtype or one.shape != other.shape:
        return False
    return one.tolist() == other.tolist() if one.dtype.kind == "O" else one.tobytes() == other.tobytes()


def places_in(values):
    """Indices of each kind of place: the first and the last, what is missing, infinite or nothing, and what is not."""
    flat = values.ravel()
    if flat.dtype.kind == "O":
        return sorted({0, flat.size - 1})
    missing = flat == -1 if flat.dtype.kind == "i" else np.isnan(flat.astype(np.float64))
    kinds = (missing, ~missing, np.isinf(flat.astype(np.float64)), flat == 0)
    found = [where[k] for kind in kinds if (where := np.flatnonzero(kind)).size for k in (0, -1)]
    return sorted({0, flat.size - 1, *map(int, found)})


def arrays(values):
    """Other arrays in the place of this one: what was done, and the array."""
    for place in places_in(values):
        old = values.ravel()[place]
        texts = ("other", "", f"{old} ", str(old).swapcase())
        for new in texts if values.dtype.kind == "O" else NUMBERS[values.dtype.kind]:
            changed = values.ravel().copy()
            changed[place] = new
            yield f"[{place}] = {new!r}", changed.reshape(values.shape)
    for axis in range(values.ndim):
        yield f"reversed along {axis}", np.flip(values, axis)
    if values.dtype.kind == "f":
        yield "the next numbers", np.nextafter(values, 2.0)
        yield "all NaN", np.full_like(values, np.nan)
        yield "negative", -values
    if values.dtype.kind == "i":
        yield "all -1", np.full_like(values, -1)
    with np.errstate(invalid="ignore"):
        for kind in TYPES[values.dtype.kind]:
            yield f"as {kind}", values.astype(kind)


def of_attribute(value):
    """Other values of an attribute; None takes it away."""
    yield None
    yield from (str(value), f"{value} ", "", np.float64(0.5), np.int64(7), [1, 2])
    if isinstance(value, str) and value[:1] in "[{":
        yield json.dumps(json.loads(value), indent=1)
    elif not isinstance(value, str):
        yield from (value + type(value)(1), float(value), -value)


def attributes(attrs):
    """Other attributes: what was done, and all of them."""
    for key, value in attrs.items():
        for other in of_attribute(value):
            kind = type(value.item() if isinstance(value, np.generic) else value)
            if not isinstance(other, kind) or np.any(other != value):
                changed = {k: v for k, v in (attrs | {key: other}).items() if v is not None}
                yield key, f"{key} = {str(other)[-20:]!r}", changed
    yield "note", "note added", attrs | {"note": "x"}


def alterations(data):
    """Every way in which variables and attributes of a dataset are changed: what was done, and the dataset with it."""
    for name, variable in data.variables.items():
        for how, values in arrays(variable.values):
            if not same(values, variable.values):
                yield f"{name} {how}", data.assign({name: (variable.dims, values, variable.attrs, variable.encoding)})
        yield f"{name} removed", data.drop_vars(name)
        yield f"{name} twice", data.assign({f"{name}_too": variable})
        if variable.ndim > 1:
            yield f"{name} transposed", data.assign({name: variable.transpose(*reversed(variable.dims))})
        if name not in data.dims:
            moved = data.reset_coords(name) if name in data.coords else data.set_coords(name)
            yield f"{name} a coordinate or not", moved
        for _, how, attrs in attributes(variable.attrs):
            changed = data.copy()
            changed[name].attrs = attrs
            yield f"{name}: {how}", changed
    for key, how, attrs in attributes(data.attrs):
        yield f"attribute {key}: {how}", data.drop_attrs(deep=False).assign_attrs(attrs)


PLAIN = """
name = "apart"
seed = 3
trials = {trials}
swarm = {{robots = [2, 3], accuracy = [0.7, "U(0.6, 0.9)"], assumed_accuracy = 0.75}}
world = {{topology = ["ring", "full"], fill_ratio = [0.3, 0.6], link_success = 0.9}}
schedule = {{rounds = [4, 8], observations_per_round = 2}}
[measure]
checkpoints = [2, 8]
local = true
estimates = true
"""
RULE = '{until = "convergence_error median +- 0.05", at_least = 6, at_most = 9}'


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
def liars(here, monkeypatch):
    """A file of a brain that decides and ends, with parameters, in both worlds, some robots of another brain."""
    monkeypatch.chdir(DATA)
    sc.save(sc.run(sc.Study.load("second.toml"), jobs=1), here / "second.nc")
    return here / "second.nc"


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


def damage(raw, chance):
    """A file with a flipped bit, another byte or zeros in some place, or cut short."""
    at, how = int(chance.integers(len(raw))), int(chance.integers(4))
    size = 1 if how < 2 else int(chance.integers(1, 200))
    new = [bytes([raw[at] ^ 1 << int(chance.integers(8))]), chance.bytes(1), bytes(len(raw[at : at + size])), b""][how]
    return raw[:at] + new + (raw[at + size :] if how < 3 else b"")


KINDS = ("kinds", "measures", "rule", "merged", "liars")
IDS = [*KINDS, "some of rule"]


@pytest.mark.long(but=["some of rule"])
@pytest.mark.parametrize(("name", "count"), [*((name, 30) for name in KINDS), ("rule", 3)], ids=IDS)
def test_damage_is_found_or_changes_nothing(name, count, request, files, copies, tmp_path):
    whole = request.getfixturevalue(name) if name == "liars" else files / f"{name}.nc"
    sound, raw, chance = sc.load(whole), whole.read_bytes(), np.random.default_rng(count)
    refused = 0
    for _ in range(count):
        (tmp_path / "x.nc").write_bytes(damage(raw, chance))
        try:
            assert sc.load(tmp_path / "x.nc").identical(sound)
        except InputError:
            refused += 1
    assert refused >= count / 2


def noticed(results):
    try:
        found = sc.verify(results, 1.0, jobs=1)
    except InputError:
        return True
    return bool(found.differences or found.labels or found.notes or found.cautions)


def may_differ(what):
    """Whether the table of what may differ names what was changed, or it is a blank at the end of the study."""
    name, _, how = what.removeprefix("attribute ").partition(":")
    allowed = {name for one in MAY_DIFFER for name in one.names} - {"trials_done", "trials_total"}
    return what.startswith("attribute ") and (name in allowed or (name == "study" and how.endswith(" '")))


@pytest.mark.long(but=["some of rule"])
@pytest.mark.parametrize(("name", "first", "step"), [
    *((name, 6 * k, 30) for k, name in enumerate(KINDS)), ("rule", 0, 300)
], ids=IDS)  # fmt: skip
def test_edits_saved_with_new_hashes_are_found(name, first, step, request, files, quick, untraced, tmp_path):
    """Of variables, coordinates and attributes, in each way, unless it leaves nothing else to read."""
    path = request.getfixturevalue(name) if name == "liars" else files / f"{name}.nc"
    data, missed = load_packed(path), []
    assert not noticed(path)
    for what, changed in [*alterations(data)][first::step]:
        try:
            sc.save(changed, tmp_path / "x.nc")
            again = load_packed(tmp_path / "x.nc")
        except InputError:
            continue
        if not (again.identical(data) or noticed(again) or may_differ(what)):
            missed.append(what)
    assert missed == []


@pytest.mark.parametrize("how", ["value", "type", "attribute", "new", "gone", "fill", "note"])
def test_a_file_that_another_program_edits_is_refused(how, small_file, tmp_path):
    path = shutil.copy(small_file, tmp_path / "x.nc")
    with h5py.File(path, "r+") as file:
        if how == "value":
            file["final_estimate"][0, 0, 0] += 1e-9
        elif how == "type":
            old = file["rounds"][()]
            del file["rounds"]
            file.create_dataset("rounds", data=old.astype("f8"))
        elif how in ("attribute", "fill"):
            file["convergence_round"].attrs["_FillValue" if how == "fill" else "units"] = np.int32(3)
        elif how == "new":
            file.create_dataset("mine", data=np.arange(3))
        elif how == "gone":
            del file["correct"]
        else:
            file.attrs["note"] = "mine"
    with pytest.raises(InputError, match=r"x\.nc: .*(damaged or edited|no dimension|damaged\?)"):
        sc.load(path)


@pytest.mark.parametrize(("key", "value"), [("_FillValue", np.int32(3)), ("coordinates", "brain")])
def test_what_other_programs_read_a_file_by_is_as_it_was_written(key, value, small_file, tmp_path, monkeypatch):
    data = load_packed(small_file)
    edited = netcdf._as_kept(data)
    edited["convergence_round"].attrs[key] = value
    with monkeypatch.context() as patch:
        patch.setattr(netcdf, "_as_kept", lambda data: edited)
        netcdf.write(data, tmp_path / "x.nc", hashed=True)
    with pytest.raises(InputError, match=f"damaged or edited .*: {key} of convergence_round is .*, and should be "):
        sc.load(tmp_path / "x.nc")


def test_a_file_without_hashes_says_what_to_do(small_file, tmp_path):
    path = shutil.copy(small_file, tmp_path / "x.nc")
    with h5py.File(path, "r+") as file:
        del file.attrs["sha256"]
    with pytest.raises(InputError, match=r"it has no hashes, .*: make it again from its study, as with"):
        sc.load(path)


def test_hashes_do_not_depend_on_how_a_file_keeps_its_content(small_file, small_results, tmp_path):
    """Here not packed, in one piece each, and in the other order of bytes."""
    path = shutil.copy(small_file, tmp_path / "x.nc")
    with h5py.File(path, "r+") as file:
        for name in ("convergence_round", "final_estimate"):
            old, attrs = file[name][()], {k: v for k, v in file[name].attrs.items() if k != "DIMENSION_LIST"}
            dims = [file[name].dims[k][0].name for k in range(old.ndim)]
            del file[name]
            made = file.create_dataset(name, data=old.astype(old.dtype.newbyteorder(">")))
            made.attrs.update(attrs)
            for k, dim in enumerate(dims):
                made.dims[k].attach_scale(file[dim])
    assert sc.load(path).identical(small_results)


def test_another_version_is_not_called_the_same(files, tmp_path, accepted):
    sc.save(sc.load(files / "rule.nc").assign_attrs(swarmcensus_version="0.0.9"), tmp_path / "x.nc")
    said = accepted("verify", tmp_path / "x.nc", "--all").out
    assert "the numbers are the same to the last bit; the file is of version 0.0.9, and this is 0." in said


def test_merge_refuses_labels_that_are_not_of_the_study(files):
    data = sc.load(files / "kinds.nc")
    data["fill_ratio"].values[0] = 0.9
    with pytest.raises(InputError, match=r"results 2: .* setting 0: fill_ratio is 0.9 in the file and 0.55 by its"):
        sc.merge([sc.load(files / "kinds.nc"), data])


def test_a_setting_that_is_there_twice_is_found(files, tmp_path):
    data = sc.load(files / "rule.nc")
    twice = data.isel(setting=[0, 0]).assign_coords(setting=("setting", [0, 0], data["setting"].attrs))
    twice["correct"].values[1] = 1.0
    sc.save(twice, tmp_path / "x.nc")
    assert "a setting is in the file more than once" in sc.verify(tmp_path / "x.nc", 1.0, jobs=1).labels


@pytest.mark.interpreted
@pytest.mark.parametrize(("name", "by", "excused"), [
    ("convergence_error", 0.001, 1), ("convergence_error", 0.2, 0), ("messages_heard", 1.0, 0)
])  # fmt: skip
def test_what_a_card_may_change_is_counted_and_never_called_the_same(name, by, excused):
    """Of a brain that uses exp; counts of messages and large errors are no card's."""
    study = study_of("bayes-bots", 9, 0.8, rounds=15, trials=4, seed=0, fill_ratio=0.35)
    data = sc.run(study, jobs=1).assign_attrs(device="A card").copy(deep=True)
    assert sc.verify(data, 1.0, jobs=1).sentences[0].endswith("the same to the last bit")
    data[name].values[0, 2, 0] += by
    found = sc.verify(data, 1.0, jobs=1)
    assert (found.excused, len(found.differences)) == (excused, 1 - excused)
    said = "the same, but for 1 value that cards and processors compute differently" if excused else "1 differ"
    assert said in " ".join(found.sentences)


class TestTrialsThatAreHidden:
    """Whoever counts trials anew cannot hide that some are gone."""

    def hidden(self, data, gone, **attributes):
        """A dataset without the trials that are `gone`, an index of (setting, trial)."""
        kept = xr.DataArray(data["convergence_round"].values[:, :, 0] >= 0, dims=("setting", "trial"))
        kept[gone] = False
        names = [name for name in ALL_VARIABLES if name in data]
        blank = {name: data[name].where(kept).transpose(*data[name].dims) for name in names}
        done = int(kept.sum())
        return data.assign(blank).assign_attrs({"trials_done": done, "trials_total": done} | attributes)

    def test_one_that_the_attributes_own_to_is_named(self, files, tmp_path, accepted):
        sc.save(self.hidden(sc.load(files / "kinds.nc"), (3, 1), trials_total=48), tmp_path / "x.nc")
        said = accepted("verify", tmp_path / "x.nc", "--all").out
        assert "47 of 47 trials run again" in said
        assert "caution: 1 of 48 trials are not in the file; the run was cut off, or somebody took out trials" in said

    def test_a_total_that_hides_it_is_not_the_studys(self, files):
        [total, missing] = sc.verify(self.hidden(sc.load(files / "kinds.nc"), (3, 1)), 1.0).labels
        assert "trials_total is 47 in the file and 48 by its study" in total
        assert missing.startswith("setting 3: of its 2 trials some are missing")

    def test_in_merged_results_of_a_rule(self, files):
        data = sc.merge([files / "rule.nc"])
        assert not noticed(data)
        found = sc.verify(self.hidden(data, np.s_[:, ::2]), 1.0)
        assert "some are missing, and none is said to be" in found.labels[0]

    def test_said_to_have_failed_though_it_runs(self, files):
        failed = json.dumps([{"setting": 2, "trial": 1, "why": "a worker was lost"}])
        data = self.hidden(sc.load(files / "kinds.nc"), (2, 1), failed=failed, trials_total=48)
        assert [(d.setting, d.trial, d.stored) for d in sc.verify(data, 1.0).differences] == [(2, 1, -1)]


def test_a_label_that_is_the_title_of_another_brain_is_named():
    text = study_of(["alone", "swift"], trials=1).text + '\n[labels]\nalone = "Swift"\nswift = "Alone"\n'
    first, _ = sc.verify(sc.run(sc.Study.parse(text), jobs=1), 1.0).cautions
    assert first == "labels call alone 'Swift', which is what swift is called elsewhere"


def test_half_a_trial_is_not_merged(files):
    """As Ctrl-C may leave a trial without its local estimates."""
    half = sc.load(files / "measures.nc")
    for name in ("local_convergence_step", "local_convergence_error"):
        half[name].loc[{"trial": 1}] = np.nan
    half.attrs["trials_done"] = half.sizes["setting"]
    merged = sc.merge([half])
    assert not (merged["convergence_round"].values[:, 1] >= 0).any()
    assert (merged.attrs["trials_done"], sc.verify(merged, 1.0).labels) == (half.sizes["setting"], [])


def test_a_round_trip_changes_no_type(files, tmp_path):
    data = sc.merge([sc.load(files / "kinds.nc")])
    sc.save(data, tmp_path / "x.nc")
    again = sc.load(tmp_path / "x.nc")
    assert {name: one.dtype for name, one in data.variables.items()} == {n: v.dtype for n, v in again.variables.items()}
    assert {again[name].dtype.kind for name in ("brain", "topology", "accuracy", "floor", "fingerprint")} == {"O"}
    assert all(type(value) is type(data.attrs[key]) for key, value in again.attrs.items())
    assert {type(value) for one in again.variables.values() for value in one.attrs.values()} <= {str, int}


def test_minus_zero_is_not_the_same_to_the_last_bit(files):
    data = sc.load(files / "kinds.nc")
    place = tuple(np.argwhere(data["correct"].values == 0.0)[0])
    data["correct"].values[place] = -0.0
    assert len(sc.verify(data, 1.0).differences) == 1


@pytest.mark.parametrize(("how", "said"), [
    ("elsewhere", "the numbers of fill_ratio are not in the file"), ("linked", "fill_ratio is a link")
])  # fmt: skip
def test_no_other_file_is_read(how, said, tmp_path):
    """HDF5 can keep an array in any file: whoever merged such results would copy that file into them."""
    path, other = tmp_path / "x.nc", tmp_path / "other"
    shutil.copy(DATA / "results-3.nc", path)
    with h5py.File(path, "r+") as file:
        old = file["fill_ratio"]
        shape, kind = old.shape, old.dtype
        del file["fill_ratio"]
        if how == "elsewhere":
            other.write_bytes(bytes(8 * shape[0]))
            file.create_dataset("fill_ratio", shape, kind, external=[(str(other), 0, 8 * shape[0])])
        else:
            file["fill_ratio"] = h5py.ExternalLink(str(other), "x")
    with pytest.raises(InputError, match=f"x.nc: {said}$"):
        sc.load(path)


class TestNothingElseIsOpened:
    """Study texts in results name files that are there; none of them is opened or run."""

    @pytest.fixture
    def here(self, here, monkeypatch):
        for file in ("office.csv", "leaf.png"):
            shutil.copy(DATA / file, here / f"other-{file}")
        for module, name in ((networks, "read_edges"), (pictures, "read_image")):
            monkeypatch.setattr(module, name, lambda path, *_: pytest.fail(f"{path} was opened"))
        return here

    @pytest.mark.long(but_every=4)
    @pytest.mark.parametrize("command", ["verify x.nc", "replay x.nc --setting 0 --trial 0", "merge x.nc --out y.nc"])
    @pytest.mark.parametrize(("old", "new", "said"), [
        ('"office.csv"', '"other-office.csv"', "these edges are not stored here"),
        ('"leaf.png"', '"other-leaf.png"', "this image is not stored here"),
        ("[swarm]", '[swarm]\nbrain = "mine.py"', "this brain's source is not stored here"),
    ])  # fmt: skip
    def test_in_any_command(self, command, old, new, said, files, here, refused):
        (here / "mine.py").write_text("raise SystemExit('was run')")
        data = sc.load(files / "kinds.nc")
        sc.save(data.assign_attrs(study=data.attrs["study"].replace(old, new)), "x.nc")
        assert f"{said}, and no file is opened here" in refused(*command.split())


class TestBrainFiles:
    SOURCE = brains.load("minimalistic").source

    @pytest.fixture
    def here(self, here, monkeypatch):
        (here / "work").mkdir()
        monkeypatch.chdir("work")
        return here / "work"

    def results(self, name):
        return sc.run(study_of(name, robots=3, accuracy=0.8, rounds=5, trials=1, fill_ratio=0.5), jobs=1)

    @pytest.mark.parametrize("name", ["mine.py", "brains/mine.py"])
    def test_one_that_lies_where_the_study_said_is_taken(self, name, here):
        (here / name).parent.mkdir(exist_ok=True)
        (here / name).write_bytes(b"\xef\xbb\xbf" + self.SOURCE.replace("\n", "\r\n").encode())
        data = self.results(name)
        assert not sc.verify(data, 1.0).differences
        assert sc.replay(data, 0, 0)["estimate"].values[-1, 0] == data["final_estimate"].values[0, 0, 0]

    @pytest.mark.parametrize("how", ["changed", "gone", "folder"])
    def test_one_with_another_source_is_not_run(self, how, here):
        (here / "mine.py").write_text(self.SOURCE)
        data = self.results("mine.py")
        (here / "mine.py").unlink()
        if how == "changed":
            (here / "mine.py").write_text("raise SystemExit('was run')")
        elif how == "folder":
            (here / "mine.py").mkdir()
        says = "has changed since the results" if how == "changed" else "are run only if they lie below"
        with pytest.raises(InputError, match=says):
            sc.verify(data, 1.0)

    def test_one_outside_the_current_folder_is_not_run(self, here, monkeypatch):
        (here.parent / "mine.py").write_text(self.SOURCE)
        (here / "link.py").symlink_to(here.parent / "mine.py")
        found = [self.results(name) for name in ("../mine.py", str(here.parent / "mine.py"), "link.py")]
        for data in found:
            with pytest.raises(InputError, match="are run only if they lie below"):
                sc.verify(data, 1.0)
        data = self.results(["minimalistic", "../mine.py"])  # whatever the sample
        monkeypatch.setattr(verifying, "recompute", None)  # no trial is run before
        for seed in range(1, 5):
            with pytest.raises(InputError, match="are run only if they lie below"):
                sc.verify(data, 0.1, seed=seed)

    def test_a_file_that_is_given_is_compared_before_it_is_run(self, here):
        (here / "mine.py").write_text(self.SOURCE)
        data = self.results("mine.py")
        (here / "mine.py").write_text("raise SystemExit('was run')")
        with pytest.raises(InputError, match="not the source that these results were made with"):
            sc.verify(data, 1.0, brain_file="mine.py")


PROGRAM = """
name = "programs"
trials = 2
swarm = {{brain = "alone", robots = 4, accuracy = [0.8, "{0}two.py(0.6, 0.9)"]}}
world = {{topology = [{{file = "{0}net.py", share = 1}}, "{0}net.py"], fill_ratio = 0.3, density = 3}}
schedule = {{rounds = 5, ticks = 9}}
[[case]]
topology = "moving"
floor = [{{file = "{0}hill.py", slope = 1}}, "{0}hill.py"]
"""
FILES = {
    "net.py": """from typing import Annotated, Literal
from pydantic import Field
ONE = 1
Steps = Annotated[int, Field(ge=1)]
def edges(robots, *, step: Steps = ONE, share: float | None = None, how: Literal["a", "b"] = "a"):
    return [(i, (i + step) % robots) for i in range(robots)]
""",
    "hill.py": """def score(arena, chance, *, slope: float = 0.5):
    return lambda tiles: chance.noise(tiles) + slope * tiles[..., 0]
""",
    "two.py": """import numpy
def quantile(u, low, high):
    return numpy.where(u < 0.5, low, high)
""",
}


class TestPrograms:
    """Files of topologies, floors and spreads: only what makes trials again runs them, and names them."""

    @pytest.fixture(scope="class")
    def made(self, tmp_path_factory):
        """A folder with these files and results of them, by each way to name them."""
        here = tmp_path_factory.mktemp("programs")
        (here / "work").mkdir()
        for name, source in FILES.items():
            (here / name).write_text(f"import pathlib\npathlib.Path({str(here / 'ran')!r}).touch()\n{source}")
            shutil.copy(here / name, here / "work")
            (here / "work" / f"to-{name}").symlink_to(here / name)
        with contextlib.chdir(here / "work"):
            for way, start in (("here", ""), ("above", "../"), ("absolute", f"{here}/"), ("linked", "to-")):
                sc.save(sc.run(sc.Study.parse(PROGRAM.format(start)), jobs=1), f"{way}.nc")
        return here

    @pytest.fixture
    def here(self, made, monkeypatch):
        monkeypatch.chdir(made / "work")
        (made / "ran").unlink(missing_ok=True)
        return made

    @pytest.mark.parametrize("command", [
        "show here.nc", "compare here.nc --factor floor", "explain here.nc", "explain here.nc --setting 0",
        "explain here.nc --setting 1", "explain here.nc --setting 4", "merge here.nc --out m.nc", "export here.nc",
        "status here.nc", "plot here.nc --out p.svg",
    ])  # fmt: skip
    def test_what_only_reads_runs_none(self, command, here, accepted):
        accepted(*command.split())
        assert not (here / "ran").exists()

    def test_what_makes_trials_again_names_them(self, here, accepted):
        """Merged ones too, which were read and not run: nothing differs."""
        assert main(["merge", "here.nc", "--out", "m.nc", "--fresh"]) == 0
        for file in ("here.nc", "m.nc"):
            plugins.name_what_runs.cache_clear()
            said = accepted("verify", file, "--all").err
            assert all(f" file {here / 'work' / name}, " in said for name in FILES)

    @pytest.mark.parametrize("way", ["above", "absolute", "linked"])
    @pytest.mark.parametrize("command", ["verify", "replay --setting 0 --trial 0", "plot --kind arena --out p.svg"])
    def test_those_outside_the_folder_are_not_run(self, way, command, here, capsys):
        first, *rest = command.split()
        assert main([first, f"{way}.nc", *rest]) == 2
        assert "are run only if they lie below the current folder" in capsys.readouterr().err
        assert not (here / "ran").exists()

    def test_one_of_which_only_running_tells_the_keys_is_not_guessed(self, here, tmp_path):
        source = (here / "net.py").read_text().replace("= ONE", "= len('a')")
        (tmp_path / "net.py").write_text(source)
        for name in ("hill.py", "two.py"):
            shutil.copy(here / name, tmp_path)
        with contextlib.chdir(tmp_path):
            data = sc.run(sc.Study.parse(PROGRAM.format("")), jobs=1)
            with pytest.raises(InputError, match=r"net\.py: only running it would tell .* of its key step"):
                sc.merge([data])


class TestFormat:
    """Files of the format, kept: they are read for good."""

    @pytest.mark.interpreted
    def test_a_trial_of_a_kept_file_is_what_it_was(self):
        data = sc.load(DATA / "results-3.nc")
        lived = sc.replay(data, 1, 1)["estimate"].values[-1]
        assert (lived == data["final_estimate"].values[1, 1, : lived.size]).all()

    @pytest.mark.long
    def test_all_that_is_done_with_results_is_done_with_it(self, here, capsys):
        shutil.copy(DATA / "results-3.nc", "r.nc")
        data = sc.load("r.nc")
        assert load_packed("r.nc")["convergence_round"].values[0, 0].tolist()[-1] == -1
        assert np.isnan(data["convergence_round"].values[0, 0, -1])  # three robots of four
        for command in ("verify r.nc --all", "replay r.nc --setting 1 --trial 1", "plot r.nc --where robots==3",
                        "plot r.nc --kind arena", "export r.nc", "status r.nc", "merge r.nc --out m.nc",
                        "verify m.nc --all"):  # fmt: skip
            assert main(command.split()) == 0, command
        said = capsys.readouterr().out
        assert said.count("48 of 48 trials run again: the ") == said.count("same to the last bit") == 2
        assert "48 of 48 trials done" in said

    def test_a_run_goes_on_from_a_kept_file(self, tmp_path):
        for file in DATA.iterdir():
            shutil.copy(file, tmp_path)
        study = sc.Study.load(tmp_path / "results.toml").with_(trials=3)
        data, whole = sc.run(study, jobs=1, out=tmp_path / "results-3.nc"), sc.run(study, jobs=1)
        assert data.drop_attrs().identical(whole.drop_attrs())
        assert sc.load(tmp_path / "results-3.nc").identical(data)

    def test_another_format_is_refused(self, files, tmp_path):
        sc.save(sc.load(files / "kinds.nc").assign_attrs(format="swarmcensus results 2"), tmp_path / "x.nc")
        with pytest.raises(InputError, match=r"x\.nc: its format is 'swarmcensus results 2', and this version"):
            sc.load(tmp_path / "x.nc")
