"""The tables and keys of a study file, and the messages for wrong ones."""

import re
from collections.abc import Iterator
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import BaseModel, Field, ValidationError, model_validator

from swarmcensus.basics.errors import pydantic_message
from swarmcensus.basics.forms import Number, Table
from swarmcensus.basics.hints import did_you_mean
from swarmcensus.basics.times import in_ticks
from swarmcensus.studies.fields import (
    Accuracies,
    Beliefs,
    Brains,
    Delays,
    FillRatios,
    Floors,
    Formats,
    Metrics,
    Name,
    Positives,
    Precisions,
    SeveralTables,
    Shares,
    Times,
    Topologies,
    Trials,
    Wholes,
)
from swarmcensus.studies.members import Members
from swarmcensus.studies.precision import Until
from swarmcensus.studies.toml_text import to_toml_value
from swarmcensus.worlds.bodies import Body
from swarmcensus.worlds.changes import Change
from swarmcensus.worlds.faults import Fault

UNNAMED = "study"  # what a study is called that has no name and comes from no file


class Swarm(Table):
    """The robots: their brains, their number, their sensors, and what they assume about these."""

    brain: Brains = Field(default=["minimalistic"], validate_default=True)
    """A shipped brain's name or the path of a brain file; {file = "...", prior = 1} gives it parameters."""
    robots: Wholes
    """N, how many."""
    accuracy: Accuracies
    """The true b and w of the sensors, as 0.8, "U(0.525, 0.975)" or {black = 0.9, white = 0.6}."""
    assumed_accuracy: Beliefs | None = None
    """The b and w that robots assume; by default the true ones."""
    precision: Precisions = Field(default=["double"])
    """The precision of the robots' arithmetic: "double", or "single" as most boards have it."""


class World(Table):
    """The robots' world: who hears whom, the share of black, and how often and how late messages get through.

    `density` or `side`, `floor` and `body` are for robots that move (topology "moving"); `message_delay`, in rounds, is
    for fixed networks.
    """

    topology: Topologies
    """Who hears whom: a network, or "moving" for robots that walk in an arena."""
    fill_ratio: FillRatios
    """f, the fraction of the floor that is black, or a change as {from = 0.9, to = 0.1, at = 500}."""
    link_success: Shares = Field(default=[1.0])
    """The probability that a message gets through."""
    message_delay: Delays = Field(default=[0])
    """How many rounds late messages are on fixed networks."""
    message: Formats = Field(default=["double"])
    """How the numbers of a message are sent: "float32", "float16", "ratio16", "ratio8"; "double" rounds nothing."""
    feedback: Annotated[bool, Field(strict=True)] = True
    """Whether what rounding takes of a message is added to the next one."""
    density: Positives | None = None
    """D = N π r² / L² of robots that move."""
    side: Positives | None = None
    """The side L of the arena in metres, in place of a density."""
    floor: Floors | None = None
    """What lies under robots that move: "tiles", {clusters = 0.2}, "half", an image."""
    body: Body = Body()
    """The body of robots that move."""


class Schedule(Table):
    """How long: communication rounds (C), and observations in each (R); ticks for robots that move."""

    rounds: Wholes = Field(default=[1000])
    """C, communication rounds on fixed networks."""
    observations_per_round: Wholes = Field(default=[10])
    """R, observations of each robot before each exchange."""
    ticks: Times = Field(default=[10_000])
    """How long robots move: a number of ticks, or a time such as "17 min"."""


class Case(Table):
    """Values in place of some of the tables' above: another grid, beside the full one."""

    brain: Brains | None = None
    robots: Wholes | None = None
    accuracy: Accuracies | None = None
    assumed_accuracy: Beliefs | None = None
    precision: Precisions | None = None
    topology: Topologies | None = None
    fill_ratio: FillRatios | None = None
    link_success: Shares | None = None
    message_delay: Delays | None = None
    message: Formats | None = None
    density: Positives | None = None
    side: Positives | None = None
    floor: Floors | None = None
    rounds: Wholes | None = None
    observations_per_round: Wholes | None = None
    ticks: Times | None = None


class Measure(Table):
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


class Tables(Table):
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
    """Values that go together, beside the full grid."""
    members: Annotated[tuple[Members, ...], SeveralTables] = ()
    """Robots that differ from the others."""
    labels: dict[str, Name] = Field(default={})
    """What tables and figures call brains, as "mine.py" = "My brain"; this changes no numbers."""

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


def explain(error: ValidationError, name: str, model: type[BaseModel] = Tables, given: Any = None) -> str:
    """The first error as a sentence that names file, key and value, and says what would be right.

    `given` is what was checked: if it has one value in place of a list, the key gets no index.
    """
    first = min(error.errors(), key=lambda e: e["type"] != "extra_forbidden")
    place = first["loc"]
    key = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in _as_given(place, given)).lstrip(".")
    more = f" (and {error.error_count() - 1} more)" if error.error_count() > 1 else ""
    if first["type"] == "extra_forbidden":
        known = list(Until.model_fields) if place[0] == "trials" else _known_keys(model, place[:-1])
        hint = did_you_mean(str(first["loc"][-1]), known)
        return f"{name}: unknown key {key}: {hint}known here: {', '.join(known)}{more}"
    if first["type"] == "missing":
        return f"{name}: {key} is missing{more}"
    message = pydantic_message(first["msg"])
    message = re.sub(r"should be a valid dictionary or instance of \w+", "should be a table", message)
    if not key:
        return f"{name}: {message}{more}"
    value = first["input"]
    if first["type"] == "literal_error" and isinstance(value, str):
        hint = did_you_mean(value, re.findall("'(.*?)'", first["ctx"]["expected"]))
        message += f": {hint.rstrip()}" if hint else ""
    shown = to_toml_value(value) if isinstance(value, str | int | float | list | dict) else repr(value)
    if hasattr(value, "nodes"):  # of networkx
        shown = f"graph {value.name!r}" if getattr(value, "name", "") else "a graph"
    return f"{name}: {key} = {shown[:200]}: {message}{more}"


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
        kind = model.model_fields[part].annotation
        model = next(k for k in (kind, *get_args(kind)) if isinstance(k, type) and issubclass(k, BaseModel))
    return list(model.model_fields)
