"""What a results file has to have: attributes, and variables with their types and dimensions, each declared once.

`netcdf` checks it before anything large is read. Whether the content is what its study gives, `runs.verifying` says.
"""

from collections.abc import Container, Mapping
from typing import Annotated, Any

import numpy as np
import xarray as xr
from pydantic import BaseModel, Field, FiniteFloat, Json, ValidationError
from typing_extensions import TypedDict

from swarmcensus.results.values import AGREEMENT, ALL_VARIABLES, VARIABLES
from swarmcensus.studies import COORDINATES
from swarmcensus.support.errors import ResultsError
from swarmcensus.support.quantities import PER_ROBOT, PER_SETTING, PER_TRIAL, stored

FORMAT = "swarmcensus results 3"
TEXTS = tuple(name for name, kind in COORDINATES.items() if kind.always and kind.type == "text")
NUMBERS = tuple(name for name, kind in COORDINATES.items() if kind.always and kind.type != "text")
INDICES = ("setting", "trial", "robot", "checkpoint")
BRAIN_FACTS = tuple(name for name, quantity in stored("setting").items() if quantity.kind is np.int64)

Declared = tuple[tuple[str, ...], Any]  # dimensions, and a type of NumPy or a family of them
NEEDED: dict[str, Declared] = {
    **{name: ((name,), np.integer) for name in INDICES},
    **dict.fromkeys(TEXTS, (PER_SETTING, np.object_)),
    **dict.fromkeys(NUMBERS, (PER_SETTING, np.number)),
    **dict.fromkeys(BRAIN_FACTS, (PER_SETTING, np.integer)),
    "fingerprint": (PER_SETTING, np.object_),
    **{name: (dims, kind) for name, (dims, kind, *_) in (VARIABLES | AGREEMENT).items()},
}
POSSIBLE: dict[str, Declared] = {
    "honest": (PER_SETTING, np.integer),
    "half_width": (PER_SETTING, np.float64),
    **{name: (dims, kind) for name, (dims, kind, *_) in ALL_VARIABLES.items()},
}


class Source(TypedDict):
    """A file of code."""

    sha256: str
    source: str


class MetricSource(Source):
    """A metric file, which gives a variable."""

    name: str


class Addition(TypedDict):
    """Something of another package."""

    package: str
    version: str
    sha256: str


class Failure(TypedDict):
    """A trial that failed."""

    setting: int
    trial: int
    why: str


Seconds = Annotated[FiniteFloat, Field(ge=0.0)]


class Attributes(BaseModel, strict=True):
    """The attributes of results; others may be there too."""

    format: str
    title: str
    study: str
    brains: Json[dict[str, Source]]
    swarmcensus_version: str
    truth: str
    seed: int
    bins: int
    delta: FiniteFloat
    trials_done: int
    trials_total: int
    adversaries: Json[dict[str, Source]] = {}
    plugin_files: Json[dict[str, Source]] = {}
    metrics: Json[dict[str, MetricSource]] = {}
    additions: Json[dict[str, Addition]] = {}
    parameters: Json[dict[str, list[str]]] = {}
    accuracies: Json[dict[str, tuple[float, float, float]]] = {}
    merged: Json[list[str]] = []
    failed: Json[list[Failure]] = []
    share: Annotated[str, Field(pattern=r"^[1-9]\d{0,9}/[1-9]\d{0,9}$")] = "1/1"
    device: str = ""
    wall_seconds: Seconds = 0.0
    cpu_seconds: Seconds = 0.0

    @property
    def texts(self) -> list[str]:
        """The texts of all studies of which these are the results."""
        return self.merged or [self.study]


def attributes_of(attrs: Mapping[Any, Any]) -> Attributes:
    """The attributes of results, checked. Raises ResultsError that names the first one that is wrong."""
    plain = {k: v.item() if isinstance(v, np.generic) else v for k, v in attrs.items()}
    try:
        return Attributes.model_validate(plain)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        key = str(first["loc"][0])
        where = ".".join(map(str, first["loc"]))
        why = f"the attribute {where}: {first['msg'][:1].lower()}{first['msg'][1:]}"
        raise ResultsError(why, key=key, value=plain.get(key)) from None


def check(attrs: Mapping[Any, Any], variables: Mapping[Any, Declared]) -> None:
    """Raise ResultsError if something in results is missing, or has another type or other dimensions.

    `variables` have dimensions and types. Others than those that are declared may be there too, of numbers or texts.
    """
    watched = attributes_of(attrs).metrics
    for name in (name for name in (*NEEDED, *watched) if name not in variables):
        raise ResultsError(f"{name} is missing", key=name)
    for name, (dims, kind) in variables.items():
        allowed, family = _declared(name, dims, watched, np.object_ if kind == np.object_ else np.number)
        if dims != allowed or not np.issubdtype(kind, family):
            title = "text" if family is np.object_ else family.__name__
            raise ResultsError(f"{name} should be {title} ({', '.join(allowed)})", key=name)


def _declared(name: str, dims: tuple[str, ...], watched: Container[str], family: Any) -> Declared:
    """The dimensions and the type that a variable should have; those of others are free."""
    what, _, of = name.partition("_")
    if name in watched:
        return dims if dims == PER_TRIAL else PER_ROBOT, np.float64
    if what in ("edges", "floor") and of:
        plane = (f"edge_{of}", "end") if what == "edges" else (f"row_{of}", f"column_{of}")
        return plane, np.integer if what == "edges" else np.unsignedinteger
    return (NEEDED | POSSIBLE).get(name, (dims, family))


def check_dataset(data: xr.Dataset) -> None:
    """Raise ResultsError as `check` does."""
    text = np.dtype(object)
    kinds = {name: text if one.dtype.kind in "UT" else one.dtype for name, one in data.variables.items()}
    check(data.attrs, {name: (tuple(map(str, one.dims)), kinds[name]) for name, one in data.variables.items()})
