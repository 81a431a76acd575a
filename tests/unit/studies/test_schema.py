"""The schema and the loader say the same of each key of study files, value by value."""

import copy
import functools
import itertools
import json
import re
import tomllib

import jsonschema
import pytest
from PIL import Image
from pydantic import ValidationError

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.studies import json_schema as of_studies
from swarmcensus.studies.json_schema import schema
from swarmcensus.studies.tables import Tables
from swarmcensus.support.files import shipped_studies
from tests.support.pages import PAGES, blocks
from tests.support.second import changed

ATOMS = [
    0, 1, 2, -1, 3, 10**12, 2**63, 0.0, 1.0, 2.0, 0.5, 1.5, -0.5, 1e300, 1e-12, True, False,
    "", " ", "x", "1", "0.5", "-0.5", "10 s", "1 parsec", "ring", "minimalistic", "shouter", "clusters", "tiles",
    "moving", "talking", "floor", "majority", "mean-error", "watts_strogatz_graph", "U(0.6, 0.8)", "N(0.7,.1)",
    "U(0.6)", "W(1, 2)", "U(0.6", "a\tb", "correct@3 mean ± 0.1", "correct mean +- 0.1",
]  # fmt: skip
LISTS = [
    [], [1], [0.5], ["x"], [True], ["ring"], [1, 2], [0.5, 0.6], [1, 1], [1, 2, 3], [1, "x"], [[]], [[1, 2]], [[1, 1]],
    {}, {"x": 1}, {"name": "x"}, {"name": "ring"}, {"file": "x"}, {"black": 0.5}, [{}], [{"x": 1}],
]  # fmt: skip
VALUES = [*ATOMS, *LISTS]

STUDY = {
    "trials": 1,
    "swarm": {"robots": 5, "accuracy": 0.7},
    "world": {"topology": "moving", "fill_ratio": 0.5, "density": 1},
    "wanted": {"right": 10},
}
PARAMETERS = 'PARAMETERS = {"prior": 1.0, "weights": (1.0, 2.0)}\n'
FORMS = {  # tables that a key may be, each with the keys that are tried
    "swarm.brain": [({"file": "own.py", "prior": [1, 2], "weights": [1, 2]}, ["file", "prior"])],
    "swarm.accuracy": [
        ({"black": 0.9, "white": 0.6}, ["black", "other"]),
        ({"start": 0.9, "drift": -0.1, "least": 0.1}, ["start", "drift", "least", "most"]),
        ({"start": 0.1, "drift": 0.1, "most": 0.9}, ["start", "drift", "least", "most"]),
    ],
    "swarm.assumed_accuracy": [({"error": 0.1}, ["error", "other"])],
    "world.fill_ratio": [({"from": 0.9, "to": 0.1, "at": 3, "until": 2**31 - 1}, ["from", "to", "at", "until", "x"])],
    "world.topology": [
        ({"name": "star", "edges": [[0, 1]], "directed": True}, ["name", "edges", "directed", "x"]),
        ({"file": "links.csv", "directed": True}, ["file", "directed", "x"]),
        ({"networkx": "watts_strogatz_graph", "k": 4, "p": 0.1}, ["networkx", "k", "seed"]),
        ({"name": "ring"}, ["name", "x"]),
        ({"name": "small-world", "neighbours": [4, 6], "label": "x"}, ["neighbours", "rewired", "label", "x"]),
    ],
    "world.floor": [
        ({"clusters": 0.2}, ["clusters", "half", "x"]),
        ({"image": "x.png", "mode": "dither"}, ["image", "mode"]),
        ({"name": "half", "label": "x"}, ["label", "length"]),
    ],
    "trials": [
        ({"until": "correct@3 mean +- 0.1", "at_least": 6, "at_most": 9}, ["until", "at_least", "at_most", "x"])
    ],
}
TABLES = {"swarm": "Swarm", "world": "World", "schedule": "Schedule", "measure": "Measure", "wanted": "Wanted"}
LISTED = {
    "faults": ("Fault", {"at": 1, "robots": 1, "stop": "moving"}),
    "members": ("Members", {"robots": 1, "honest": False}),
    "case": ("Case", {"robots": 7}),
}
# a name may be that of a file, which a schema does not open
FILES = {"brain", "topology", "metrics", "file", "image", "lie"}
OTHERS = {  # what only a file, or another key of the same table, can tell
    "swarm.brain.prior": [[[1, 2]], [[1, 1]]],
    "swarm.accuracy.start": [1e-12, "1"],
    "swarm.accuracy.most": [1e-12],
    "world.fill_ratio.until": [2, 2.0],
    "faults.0.blank": [True],
    "wanted.error": [1e-12],  # not with right
}


def put(tables, path, value):
    """The same with one value in place of what is there."""
    found = copy.deepcopy(tables)
    *above, key = path
    inner = found
    for part in above:
        inner = inner.setdefault(part, {}) if isinstance(inner, dict) else inner[part]
    inner[key] = value
    return found


def study_places():
    """Every key of the study file, and of tables that a value may be: where it is, and a right study around it."""
    told = of_studies.schema()
    for key in [*told["properties"], "x"]:
        yield (key,), STUDY
    for table, name in TABLES.items():
        for key in [*told["$defs"][name]["properties"], "x"]:
            yield (table, key), STUDY
    for key in [*told["$defs"]["Body"]["properties"], "x"]:
        yield ("world", "body", key), STUDY
    for table, (name, one) in LISTED.items():
        for key in [*told["$defs"][name]["properties"], "x"]:
            yield (table, 0, key), {**STUDY, table: [one]}
    for name, forms in FORMS.items():
        path = tuple(name.split("."))
        for table, keys in forms:
            for key in keys:
                yield (*path, key), put(STUDY, path, table)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    found = tmp_path_factory.mktemp("files")
    (found / "own.py").write_text(changed(("MEMORY =", f"{PARAMETERS}MEMORY =")))
    (found / "links.csv").write_text("i,j\n0,1\n")
    Image.new("L", (2, 2)).save(found / "x.png")
    return found


def names_a_file(value):
    if isinstance(value, dict):
        return [*value] == ["file"]
    texts = value if isinstance(value, list) else [value]
    return bool(texts) and all(isinstance(one, str) for one in texts)


def with_whole_numbers(value):
    """The same with 1 for 1.0: to JSON, and so to a schema, they are one number."""
    if isinstance(value, list):
        return [with_whole_numbers(one) for one in value]
    return int(value) if isinstance(value, float) and value.is_integer() else value


def disagreements(places, checker, right_in_tables, whole):
    """Where a schema refuses what is right, or lets through what it could refuse."""
    for path, base in places:
        where = ".".join(map(str, path))
        assert checker.is_valid(base)
        assert right_in_tables(base)
        for value in VALUES:
            tables = put(base, path, value)
            let_through, right = checker.is_valid(tables), right_in_tables(tables)
            if right and not let_through and not refuses(whole, tables):
                yield f"refused: {where} = {value!r}"
            if let_through and not right:
                as_json = right_in_tables(put(base, path, with_whole_numbers(value)))
                of_a_file = path[-1] in FILES and names_a_file(value)
                if not (as_json or of_a_file or value in OTHERS.get(where, [])):
                    yield f"let through: {where} = {value!r}"


def refuses(load, tables):
    try:
        load(copy.deepcopy(tables))
    except sc.InputError:
        return True
    return False


def checked_by(model, context):
    """Whether each of the tables is right by itself: what is wrong with the whole has no place."""

    def right(tables):
        try:
            model.model_validate(copy.deepcopy(tables), context=context)
        except ValidationError as error:
            return not any(one["loc"] for one in error.errors())
        except sc.InputError:
            return False
        return True

    return right


@pytest.fixture(scope="module")
def read_once():
    return {name: brains.load(name) for name in ("minimalistic", "commons", "steadfast")}


@functools.cache
def checker_of(files):
    return jsonschema.Draft7Validator(files.schema())


def by_table(places):
    """Keys of tables table by table, and those that are in none."""
    ordered = sorted(places, key=table_of)
    return [pytest.param([*some], id=name or "top") for name, some in itertools.groupby(ordered, table_of)]


def table_of(place):
    return ".".join(map(str, place[0][:-1]))


@pytest.mark.long(but_every=2)
@pytest.mark.parametrize("places", by_table(study_places()))
def test_of_studies_the_schema_says_what_the_loader_says(folder, read_once, places):
    checker = checker_of(of_studies)
    right = checked_by(Tables, {"base": folder, "brains": read_once})
    assert list(disagreements(places, checker, right, lambda tables: sc.Study(**tables))) == []


# ---- the JSON schema of study files lets every study through, and marks what is none, where an editor can know


PLAIN = {"trials": 1, "swarm": {"robots": 5, "accuracy": 0.7}, "world": {"topology": "ring", "fill_ratio": 0.5}}


@pytest.fixture(scope="module")
def checker():
    found = schema()
    jsonschema.Draft7Validator.check_schema(found)
    return jsonschema.Draft7Validator(found)


@pytest.mark.parametrize("name", shipped_studies())
def test_every_shipped_study_is_let_through(checker, name):
    checker.validate(tomllib.loads(shipped_studies()[name].read_text(encoding="utf-8")))


def test_what_pages_show_of_studies_is_let_through(checker):
    shown = [tomllib.loads(text) for page in PAGES for text in blocks(page, "toml")]
    studies = [one for one in shown if "jobs" not in one]
    assert len(studies) > 10
    for one in studies:
        whole = copy.deepcopy(PLAIN)
        for key, value in one.items():
            whole[key] = whole[key] | value if isinstance(whole.get(key), dict) else value
        checker.validate(whole)


def test_every_key_and_table_says_what_it_means_in_the_shell_too(accepted):
    found = schema()
    for table in (found, *found["$defs"].values()):
        for key, told in table["properties"].items():
            assert re.match(r"\S.*\.$", told["description"], re.DOTALL), key
    assert json.loads(accepted("new", "study", "--schema").out) == found


def test_names_are_offered(checker):
    told = json.dumps(checker.schema)
    assert all(f'"{name}"' in told for name in ("commons", "scale-free", "shouter", "clusters", "mean-error"))
