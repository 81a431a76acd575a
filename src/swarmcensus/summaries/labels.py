"""Names of brains in tables and figures: labels of their study or of the user, else their own names."""

import json
from collections.abc import Collection, Mapping
from itertools import chain
from typing import Any

import numpy as np
import xarray as xr

from swarmcensus.brains.library import TITLES, namesakes
from swarmcensus.support.errors import OptionError, ResultsError
from swarmcensus.support.formatting import distinct_texts
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import in_shell
from swarmcensus.support.toml_text import read_toml

LABELS = "labels"  # the table of a study file, and the attribute with the user's own


def labels_in(results: xr.Dataset) -> dict[str, str]:
    """The labels of the studies that results are of, and of `with_labels`, by brains' names.

    Merged studies may give one label to two brains, which then keep their own names.
    """
    labels, known = _all_labels(results), _brains_in(results)
    while (same := namesakes(known, labels)) and labels.keys() & same[:2]:
        labels = {name: label for name, label in labels.items() if name not in same[:2]}
    return labels


def _brains_in(results: xr.Dataset) -> list[str]:
    return list(dict.fromkeys(np.atleast_1d(results["brain"].values).tolist())) if "brain" in results else []


def studies_in(results: xr.Dataset) -> list[dict[str, Any]]:
    """The tables of the studies that results are of."""
    texts = json.loads(results.attrs["merged"]) if "merged" in results.attrs else [results.attrs.get("study", "")]
    return [read_toml(text, "study") for text in texts]


def groups_in(results: xr.Dataset) -> dict[str, str]:
    """The groups of settings that studies of these results name, each with its expression."""
    return {name: expression for study in studies_in(results) for name, expression in study.get("groups", {}).items()}


def is_set(results: xr.Dataset, parameter: str) -> bool:
    """Whether a study of these results gives a brain's parameter a value."""
    given = [study.get("swarm", {}).get("brain") for study in studies_in(results)]
    brains = chain.from_iterable(one if isinstance(one, list) else [one] for one in given)
    return any(isinstance(brain, dict) and parameter in brain for brain in brains)


def _all_labels(results: xr.Dataset) -> dict[str, str]:
    labels = {name: label for study in studies_in(results) for name, label in study.get(LABELS, {}).items()}
    try:
        return labels | {str(k): str(label) for k, label in json.loads(results.attrs.get(LABELS, "{}")).items()}
    except (ValueError, TypeError, AttributeError, RecursionError):
        raise ResultsError.named("the attribute", LABELS, "should be names of brains, as JSON") from None


def with_labels(results: xr.Dataset, labels: Mapping[str, str]) -> xr.Dataset:
    """Results with these names of brains. Raises InputError for an unknown brain, and for one name of two brains."""
    known = _brains_in(results)
    for name, label in labels.items():
        what = f"--label {name}={label}" if in_shell() else f"labels={{{name!r}: {label!r}}}"
        if name not in known:
            there = f"{did_you_mean(name, known)}the brains here are {', '.join(known)}"
            raise OptionError(f"{what}: {there}", key="labels", value=name)
        if not isinstance(label, str) or not label.strip() or not label.isprintable():
            raise OptionError(f"{what}: a label should be a line of text", key="labels", value=label)
    labelled = results.assign_attrs({LABELS: json.dumps(dict(labels))})
    if same := namesakes(known, _all_labels(labelled)):
        both = "{} and {} would both be called {!r}: give them two labels".format(*same)
        raise OptionError(both, key="labels", value=same[2])
    return labelled


def contender_names(
    results: xr.Dataset, parameters: Mapping[str, Collection[str]], shown: Mapping[str, Collection[str]] = {}
) -> list[str]:
    """The name of each setting's contender: its brain, and those of its `parameters` that vary or are `shown`."""
    brains = results["brain"].values.tolist()
    names = [str(name) for name in brains]
    for brain, several in parameters.items():
        rows = [k for k, name in enumerate(brains) if name == brain]
        for name in several:
            values = results[name].values[rows].tolist()
            if len(set(map(repr, values))) > 1 or name in shown.get(brain, ()):
                distinct = list(dict.fromkeys(values))
                text = dict(zip(distinct, distinct_texts(distinct), strict=True))
                for k, value in zip(rows, values, strict=True):
                    names[k] += f" {name}={text.get(value, value)}"
    return names


def titles_in(*results: xr.Dataset) -> dict[str, str]:
    """Names of brains in figures: their labels in these results, or the titles of shipped brains."""
    titles = dict(TITLES)
    for each in results:
        titles |= labels_in(each)
    return titles


def renamed_contender(contender: str, names: Mapping[str, str]) -> str:
    """A contender, which is a brain and perhaps its parameters, with its brain's other name."""
    brain = max((name for name in names if contender == name or contender.startswith(f"{name} ")), key=len, default="")
    return names[brain] + contender[len(brain) :] if brain else contender
