"""What brains are called in tables and figures: by labels of their study or of the user, else by their own names."""

import json
import tomllib
from collections.abc import Mapping

import xarray as xr

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.hints import did_you_mean
from swarmcensus.basics.options import in_shell
from swarmcensus.brains.library import TITLES

LABELS = "labels"  # the table of a study file, and the attribute with the user's own


def labels_in(results: xr.Dataset) -> dict[str, str]:
    """The labels of the studies that results are of, and of `with_labels`, by brains' names."""
    texts = json.loads(results.attrs["merged"]) if "merged" in results.attrs else [results.attrs.get("study", "")]
    labels: dict[str, str] = {}
    for text in texts:
        labels |= tomllib.loads(text).get(LABELS, {})
    labels |= json.loads(results.attrs.get(LABELS, "{}"))
    return labels


def with_labels(results: xr.Dataset, labels: Mapping[str, str]) -> xr.Dataset:
    """Results whose brains are called so. Raises InputError for an unknown brain, and for one name of two brains."""
    known = list(dict.fromkeys(results["brain"].values.tolist()))
    for name, label in labels.items():
        what = f"--label {name}={label}" if in_shell() else f"labels={{{name!r}: {label!r}}}"
        if name not in known:
            raise InputError(f"{what}: {did_you_mean(name, known)}the brains here are {', '.join(known)}")
        if not isinstance(label, str) or not label.strip() or not label.isprintable():
            raise InputError(f"{what}: a label should be a line of text")
    labelled = results.assign_attrs({LABELS: json.dumps(dict(labels))})
    called = labels_in(labelled)
    by_label: dict[str, str] = {}
    for name in known:
        other = by_label.setdefault(called.get(name, name), name)
        if other != name:
            raise InputError(
                f"{other} and {name} would both be called {called.get(name, name)!r}: give them two labels"
            )
    return labelled


def titles_in(*results: xr.Dataset) -> dict[str, str]:
    """What figures call brains: their labels in these results, or the titles of shipped brains."""
    titles = dict(TITLES)
    for each in results:
        titles |= labels_in(each)
    return titles


def renamed(contender: str, names: Mapping[str, str]) -> str:
    """A contender, which is a brain and perhaps its parameters, with its brain's other name."""
    brain = max((name for name in names if contender == name or contender.startswith(f"{name} ")), key=len, default="")
    return names[brain] + contender[len(brain) :] if brain else contender
