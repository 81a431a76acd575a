"""The tables and keys of a study file, and the messages for wrong ones."""

from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, TypeAlias, get_type_hints

from pydantic import Field, create_model, model_validator

from swarmcensus.studies.fields import MaybeTimes, Metrics, Name, SeveralTables, Trials
from swarmcensus.studies.members import Members
from swarmcensus.studies.settings import KEYS, Schedule, Swarm, World
from swarmcensus.studies.wanted import Wanted
from swarmcensus.support.times import Time, in_ticks
from swarmcensus.support.toml_types import Number, TomlTable, usual
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
    """What is measured, and when."""

    delta: Annotated[Number, Field(gt=0.0, allow_inf_nan=False)] = 0.01
    """A robot has converged once its estimate moves by less than this from then on."""
    bins: Annotated[int, Field(strict=True, ge=1, le=10_000)] = 10
    """B: [0, 1] is divided into this many equal bins, among which robots decide."""
    checkpoints: MaybeTimes = usual(None)
    """Rounds, ticks or times after which decisions are recorded."""
    local: Annotated[bool, Field(strict=True)] = False
    """Also measure the local estimate, after every single observation."""
    estimates: Annotated[bool, Field(strict=True)] = False
    """Also keep each robot's estimate at the checkpoints."""
    truth: Literal["nominal", "floor"] = "nominal"
    """The truth for errors and decisions: f, or the black share of the drawn floor."""
    metrics: Metrics = usual(())
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
    wanted: Wanted = Wanted()
    """What robots should know at the end."""
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

        def plain(value: Any, tick: float | None, place: str) -> Any:
            if isinstance(value, list):
                return [plain(one, tick, place) for one in value]
            if isinstance(value, Change):
                return value.in_ticks(tick, place)
            return in_ticks(value, tick, place) if isinstance(value, Time) else value

        def converted(table: Any, where: str, **clocks: float | None) -> Any:
            ticks = {key: plain(getattr(table, key), clock, f"{where}.{key}") for key, clock in clocks.items()}
            return table.model_copy(update={key: v for key, v in ticks.items() if v != getattr(table, key)})

        cases = (converted(c, f"case[{n}]", ticks=tick, fill_ratio=common) for n, c in enumerate(self.case))
        faults = (converted(f, f"faults[{n}]", at=common, until=common) for n, f in enumerate(self.faults))
        in_place = {
            "schedule": converted(self.schedule, "schedule", ticks=tick),
            "world": converted(self.world, "world", fill_ratio=common),
            "case": tuple(cases),
            "measure": converted(self.measure, "measure", checkpoints=common),
            "faults": tuple(faults),
        }
        return self.model_copy(update=in_place)
