"""The types of the values in a study file."""

import functools
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

from pydantic import AfterValidator, BeforeValidator, Field, ValidationInfo

from swarmcensus import brains
from swarmcensus.brains import Format, Precision, adversary, metrics
from swarmcensus.studies.precision import Until
from swarmcensus.support.hints import did_you_mean, did_you_mean_any
from swarmcensus.support.plugins import combinations
from swarmcensus.support.times import OR_TIME
from swarmcensus.support.toml_types import (
    LISTED,
    OrElse,
    Robots,
    Several,
    Share,
    T,
    Text,
)
from swarmcensus.worlds import (
    OR_CHANGE,
    OR_SPREAD,
    Accuracy,
    Body,
    Change,
    Floor,
    Least,
    Misjudgement,
    Positive,
    Topology,
    parse_accuracies,
    parse_beliefs,
    parse_floors,
    parse_topologies,
    spanned_fills,
)

if TYPE_CHECKING:
    import networkx as nx

    from swarmcensus.support.toml_types import Checked, Int, Many, Real

LARGEST = 2**31 - 1  # trials, robots and rounds are 32-bit numbers in addresses


def _tables(value: object, info: ValidationInfo) -> object:
    if not isinstance(value, list | tuple):
        raise ValueError(f"should be a list of tables, each under [[{info.field_name}]]")
    return value


def _context(info: ValidationInfo, key: str, default: Any) -> Any:
    return (info.context or {}).get(key, default)


def _parsed(parse: Callable[[Any, Any, Any], object], key: str, kind: str) -> BeforeValidator:
    """Reads a value with a parser of **worlds**, which takes the value, the study's folder and what is read already.

    That is under a key of the context, or a file of a plugin of this kind.
    """

    def read(value: object, info: ValidationInfo) -> object:
        files = {file.name: file for file in _context(info, "plugins", ()) if file.kind == kind}
        return parse(value, _context(info, "base", Path()), _context(info, key, {}) | files)

    return BeforeValidator(read)


BrainOrAdversary = brains.Brain | brains.Adversary


def _sweep(value: object, info: ValidationInfo, read: Callable[[object, ValidationInfo], Any]) -> list[Any]:
    """A brain or adversary with its parameters: one for each combination of their values."""
    if not isinstance(value, Mapping):
        return [read(value, info)]
    if "file" not in value:
        right = 'a brain with parameters is a table such as {file = "my_brain.py", prior = [1, 10]}'
        raise ValueError(f"{did_you_mean_any(value, ['file'])}file is missing: {right}")
    brain = read(value["file"], info)

    def is_vector(name: str, one: Any) -> bool:
        is_long = brains.length(brain.parameters.get(name, 0.0)) > 0
        return is_long and not all(isinstance(inner, list | tuple) for inner in one)

    every, _ = combinations({str(name): one for name, one in value.items() if name != "file"}, is_vector)
    return [brain.with_parameters(dict(one)) for one in every]


def _file(value: object, info: ValidationInfo, what: str) -> Any:
    """A brain or metric: itself, one that is read already, or the file or shipped one of this name."""
    kind, place = {"brain": (brains.Brain, brains), "metric": (metrics.Metric, metrics)}[what]
    if isinstance(value, kind):
        return value
    if not isinstance(value, str | Path):
        raise ValueError(f"a {what} is a shipped {what}'s name or the path of a {what} file")
    known, base = _context(info, f"{what}s", {}), _context(info, "base", Path())
    if str(value) in known:
        return known[str(value)]
    if base is None and str(value) not in place.PLUGINS:
        hint = did_you_mean(str(value), place.PLUGINS.names)
        raise ValueError(f"{hint}this {what}'s source is not stored here, and no file is opened here")
    return place.load(value, base)


def _brain_or_adversary(value: object, info: ValidationInfo) -> Any:
    if isinstance(value, brains.Adversary):
        return value
    known, base, name = _context(info, "adversaries", {}), _context(info, "base", Path()), str(value)
    if name in known:
        return known[name]
    is_brain = name in _context(info, "brains", {}) or name in brains.PLUGINS.shipped
    if not isinstance(value, str | Path) or is_brain or (base is None and name not in adversary.PLUGINS):
        return _file(value, info, "brain")
    if adversary.exists(name, base):
        return adversary.load(name, base)
    hint = did_you_mean(name, adversary.PLUGINS.names)
    if hint and name not in brains.PLUGINS and not ((base or Path()) / name).is_file():
        known = ", ".join(adversary.PLUGINS.names)
        raise ValueError(f"brain {name!r}: {hint}neither a brain nor an adversary ({known}), nor a file")
    return _file(value, info, "brain")


def plain_text(value: str) -> str:
    """A text without control characters, for names. Raises ValueError."""
    if not value.isprintable():
        raise ValueError("a name is printed and drawn: it should have no control characters")
    return value


Name = Annotated[Text, AfterValidator(plain_text)]
Whole = Annotated[int, Field(strict=True, ge=1, le=LARGEST)]

Trials = Annotated[Whole, OrElse(Until, Mapping, Until)]

BRAINS = BeforeValidator(functools.partial(_sweep, read=functools.partial(_file, what="brain")))
MEMBERS_BRAINS = BeforeValidator(functools.partial(_sweep, read=_brain_or_adversary))
METRIC = BeforeValidator(functools.partial(_file, what="metric"))
JOINED = AfterValidator(lambda lists: [value for one in lists for value in one])

# for keys that span a grid: one value, or a list of them
if TYPE_CHECKING:  # as editors complete and check them; once checked, each is a list
    Written: TypeAlias = str | Mapping[str, Any] | Path
    Wholes: TypeAlias = Checked[Many[Int], list[int]]
    Times: TypeAlias = Checked[Many[Int | str], list[int]]
    MaybeTimes: TypeAlias = Checked[Many[Int | str] | None, list[int] | None]
    Shares: TypeAlias = Checked[Many[Real], list[float]]
    Precisions: TypeAlias = Checked[Many[Precision], list[Precision]]
    Formats: TypeAlias = Checked[Many[Format], list[Format]]
    Delays: TypeAlias = Checked[Many[Int], list[int]]
    FillRatios: TypeAlias = Checked[Many[Real | str | Mapping[str, Any] | Change], list[float]]
    MaybePositives: TypeAlias = Checked[Many[Real] | None, list[float] | None]
    Brains: TypeAlias = Checked[Many[Written | brains.Brain], list[Any]]
    MaybeBrainsOrAdversaries: TypeAlias = Checked[Many[Written | BrainOrAdversary] | None, list[Any] | None]
    Topologies: TypeAlias = Checked[Many[Written | nx.Graph | Topology], list[Topology]]
    MaybeFloors: TypeAlias = Checked[Many[Written | Floor] | None, list[Floor] | None]
    Accuracies: TypeAlias = Checked[Many[Real | str | Mapping[str, Any] | Accuracy], list[Accuracy]]
    MaybeAccuracies: TypeAlias = Checked[Many[Real | str | Mapping[str, Any] | Accuracy] | None, list[Accuracy] | None]
    MaybeBeliefs: TypeAlias = Checked[
        Many[Real | str | Mapping[str, Any] | Accuracy | Misjudgement] | None, list[Accuracy | Misjudgement] | None
    ]
    Sizes: TypeAlias = Checked[Many[Real], list[int | float]]
    MaybeSpeeds: TypeAlias = Checked[Many[Real] | None, list[float] | None]
    Metrics: TypeAlias = Checked[Many[str | Path | metrics.Metric], tuple[metrics.Metric, ...]]
    BodyTable: TypeAlias = Checked[Body | Mapping[str, Any], Body]
else:
    Spanning = Annotated[Several[T], JOINED]  # values, each of which may be a table that spans several
    BodyTable = Body
    Wholes = Several[Whole]
    Times = Several[Annotated[Whole, OR_TIME]]
    MaybeTimes = Times | None
    Shares = Several[Share]
    Precisions = Several[Precision]
    Formats = Several[Format]
    Delays = Several[Annotated[int, Field(strict=True, ge=0, le=1000)]]
    FillRatio = Annotated[Share, OR_CHANGE, OR_SPREAD]
    FillRatios = Spanning[Annotated[list[FillRatio], _parsed(spanned_fills, "", "spread")]]
    MaybePositives = Several[Positive] | None
    Brains = Spanning[Annotated[Any, BRAINS]]
    MaybeBrainsOrAdversaries = Spanning[Annotated[Any, MEMBERS_BRAINS]] | None
    Topologies = Spanning[Annotated[Any, _parsed(parse_topologies, "edges", "topology")]]
    MaybeFloors = Spanning[Annotated[Any, _parsed(parse_floors, "images", "floor")]] | None
    Accuracies = Spanning[Annotated[Any, _parsed(parse_accuracies, "", "spread")]]
    MaybeAccuracies = Accuracies | None
    MaybeBeliefs = Spanning[Annotated[Any, _parsed(parse_beliefs, "", "spread")]] | None
    Sizes = Several[Robots]
    MaybeSpeeds = Several[Least] | None
    Metrics = Annotated[tuple[Annotated[metrics.Metric, METRIC], ...], LISTED]
SeveralTables = BeforeValidator(_tables)
