"""The JSON schema of study files lets every study through, and marks what is none, where an editor can know."""

import copy
import json
import re
import tomllib

import jsonschema
import pytest

from swarmcensus.cli.commands import main
from swarmcensus.studies.json_schema import schema
from swarmcensus.support.files import shipped_studies
from tests.support.pages import PAGES, blocks

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


def test_every_key_and_table_says_what_it_means_in_the_shell_too(capsys):
    found = schema()
    for table in (found, *found["$defs"].values()):
        for key, told in table["properties"].items():
            assert re.match(r"\S.*\.$", told["description"], re.DOTALL), key
    assert main(["new", "study", "--schema"]) == 0
    assert json.loads(capsys.readouterr().out) == found


def test_names_are_offered(checker):
    told = json.dumps(checker.schema)
    assert all(f'"{name}"' in told for name in ("commons", "scale-free", "shouter", "clusters", "mean-error"))
