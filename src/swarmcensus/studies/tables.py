"""The tables and keys of a study file, and the messages for wrong ones."""

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, TypeAlias, get_args, get_type_hints

from pydantic import BaseModel, Field, ValidationError, create_model, model_validator

from swarmcensus.studies.fields import Metrics, Name, SeveralTables, Times, Trials
from swarmcensus.studies.members import Members
from swarmcensus.studies.settings import KEYS, Schedule, Swarm, World
from swarmcensus.studies.toml_text import to_toml_value
from swarmcensus.support.errors import StudyError, pydantic_message
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.times import in_ticks
from swarmcensus.support.toml_types import Number, OrElse, TomlTable
from swarmcensus.worlds import Change, Fault

UNNAMED = "study"  # what a study is called that has no name and comes from no file


def _case() -> Any:
    """The table of a case: every key that spans the grid, none of them required."""
    fields: dict[str, Any] = {}
    for table in (Swarm, World, Schedule):
        for name, kind in get_type_hints(table, include_extras=True).items():
            if name in KEYS and KEYS[name].spans:
                fields[name] = (kind | None, Field(default=None, description=KEYS[name].meaning))
    meaning = "Values in place of some of the tables' above: another grid, in addition to the full one."
    return create_model("Case", __base__=TomlTable, __doc__=meaning, **fields)


if TYPE_CHECKING:
    Case: TypeAlias = Any  # its keys are those of the tables
else:
    Case = _case()


class Measure(TomlTable):
    """What is measured: convergence within delta, decisions among bins at checkpoints, estimates and metrics."""

    delta: Annotated[Number, Field(gt=0.0, allow_inf_nan=False)] = 0.01
    """A robot has converged once its estimate moves by less than this from then on."""
    bins: Annotated[int, Field(strict=True, ge=1, le=10_000)] = 10
    """B: [0, 1] is divided into this many equal bins, among which robots decide."""
    checkpoints: Times | None = None
    """Rounds, ticks or times after which decisions are recorded."""
    local: Annotated[bool, Field(strict=True)] = False
    """Also measure the local estimate, after every single observation."""
    estimates: Annotated[bool, Field(strict=True)] = False
    """Also keep each robot's estimate at the checkpoints."""
    truth: Literal["nominal", "floor"] = "nominal"
    """The truth for errors and decisions: f, or the black share of the drawn floor."""
    metrics: Metrics = ()
    """Further measures: shipped metrics or metric files."""


class Tables(TomlTable):
    """The study file as a whole."""

    name: Name = UNNAMED
    """The title of the results and of figures; without one, the name of the study file."""
    seed: Annotated[int, Field(strict=True, ge=0, lt=2**63)] = 0
    """The same seed gives the same numbers."""
    trials: Trials
    """Repetitions of each setting, or a rule that adds trials until they suffice."""
    swarm: Swarm
    """The robots."""
    world: World
    """Their world."""
    schedule: Schedule = Schedule()
    """How long."""
    measure: Measure = Measure()
    """What is measured."""
    faults: Annotated[tuple[Fault, ...], SeveralTables] = ()
    """Robots that fail."""
    case: Annotated[tuple[Case, ...], SeveralTables] = ()
    """Values that go together, in addition to the full grid."""
    members: Annotated[tuple[Members, ...], SeveralTables] = ()
    """Robots that differ from the others."""
    labels: dict[str, Name] = Field(default={})
    """What tables and figures call brains, as "mine.py" = "My brain"; this changes no numbers."""
    groups: dict[str, str] = Field(default={})
    """Names of groups of settings, each with an expression as --where takes it; this changes no numbers."""

    @model_validator(mode="after")
    def _times_in_ticks(self) -> Self:
        tick = self.world.body.tick
        topologies = [*self.world.topology, *(t for case in self.case for t in case.topology or ())]
        common = tick if all(t.moves for t in topologies) else None  # for keys that all settings share

        def converted(table: Any, key: str, where: str, tick: float | None) -> Any:
            values = getattr(table, key)
            if values is None:
                return table
            ticks = [in_ticks(v, tick, f"{where}.{key}") for v in values]
            return table if ticks == values else table.model_copy(update={key: ticks})

        def changes(table: Any, where: str) -> Any:
            values = table.fill_ratio or []
            if not any(isinstance(v, Change) for v in values):
                return table
            ticks = [v.in_ticks(common, f"{where}.fill_ratio") if isinstance(v, Change) else v for v in values]
            return table.model_copy(update={"fill_ratio": ticks})

        def times_of(fault: Fault, where: str) -> dict[str, int]:
            times = {"at": fault.at} | ({} if fault.until is None else {"until": fault.until})
            return {key: in_ticks(value, common, f"{where}.{key}") for key, value in times.items()}

        faults = (f.model_copy(update=times_of(f, f"faults[{n}]")) for n, f in enumerate(self.faults))
        return self.model_copy(
            update={
                "schedule": converted(self.schedule, "ticks", "schedule", tick),
                "world": changes(self.world, "world"),
                "case": tuple(
                    changes(converted(case, "ticks", f"case[{n}]", tick), f"case[{n}]")
                    for n, case in enumerate(self.case)
                ),
                "measure": converted(self.measure, "checkpoints", "measure", common),
                "faults": tuple(faults),
            }
        )


def study_error(error: ValidationError, where: str, model: type[BaseModel] = Tables, given: Any = None) -> StudyError:
    """The first error, with a sentence that names file, key and value, and says what would be right.

    `given` is what was checked: if it has one value in place of a list, the key gets no index.
    """
    first = min(error.errors(), key=lambda e: e["type"] != "extra_forbidden")
    place, key = first["loc"], _key(first["loc"], given)
    more = f" (and {error.error_count() - 1} more)" if error.error_count() > 1 else ""
    if first["type"] == "extra_forbidden":
        known = _known_keys(model, place[:-1])
        hint = did_you_mean(str(first["loc"][-1]), known)
        return StudyError.within(where, f"unknown key {key}: {hint}known here: {', '.join(known)}{more}", key)
    if first["type"] == "missing":
        keys = [_key(one["loc"], given) for one in error.errors() if one["type"] == "missing"]
        rest = error.error_count() - len(keys)
        what = f"{key} is" if len(keys) == 1 else f"{', '.join(keys[:-1])} and {keys[-1]} are"
        return StudyError.within(where, f"{what} missing" + f" (and {rest} more)" * (rest > 0), key)
    message = pydantic_message(first["msg"])
    message = re.sub(r"should be a valid dictionary or instance of \w+", "should be a table", message)
    value = first["input"]
    if not key:  # of a check of several values, which names one
        cause = first.get("ctx", {}).get("error")
        named = (cause.key, cause.value) if isinstance(cause, StudyError) else ()
        return StudyError.within(where, message + more, *named)
    if first["type"] == "literal_error" and isinstance(value, str):
        hint = did_you_mean(value, re.findall("'(.*?)'", first["ctx"]["expected"]))
        message += f": {hint.rstrip()}" if hint else ""
    if isinstance(value, str):  # a brain's error names it too
        message = re.sub(rf"^\w+ {re.escape(repr(value))}: ", "", message)
    shown = to_toml_value(value) if isinstance(value, str | int | float | list | dict) else repr(value)
    if hasattr(value, "nodes"):  # of networkx
        shown = f"graph {value.name!r}" if getattr(value, "name", "") else "a graph"
    return StudyError.within(where, f"{key} = {shown[:200]}: {message}{more}", key, value)


def _key(place: tuple[int | str, ...], given: Any) -> str:
    """The key at a place of a study: world.topology[1].k."""
    return "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in _as_given(place, given)).lstrip(".")


def _as_given(place: tuple[int | str, ...], given: Any) -> Iterator[int | str]:
    for part in place:
        if isinstance(part, int) and given is not None and not isinstance(given, list | tuple):
            continue
        yield part
        try:
            given = given[part]
        except (TypeError, KeyError, IndexError):
            given = None


def _known_keys(model: type[BaseModel], path: tuple[int | str, ...]) -> list[str]:
    for part in (part for part in path if isinstance(part, str)):
        field = model.model_fields[part]
        others = [mark.other for mark in field.metadata if isinstance(mark, OrElse)]
        kinds = (field.annotation, *get_args(field.annotation), *others)
        model = next(k for k in kinds if isinstance(k, type) and issubclass(k, BaseModel))
    return list(model.model_fields)
