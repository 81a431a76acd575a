"""A study: a grid of settings, from a study file or from Python."""

import itertools
import math
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Self

from pydantic import (
    ValidationError,
)

from swarmcensus.errors import InputError
from swarmcensus.networks import MOVING
from swarmcensus.patterns import Floor, Picture
from swarmcensus.precision import Until
from swarmcensus.settings import Setting
from swarmcensus.study_tables import Tables, explain
from swarmcensus.toml_text import read_toml, to_toml

MOST_VALUES = 2**31  # of each variable in a dataset, all robots of all trials
MOST_SETTINGS = 1_000_000


class Study:
    """A grid of settings, each run for a number of trials."""

    def __init__(self, **tables: Any) -> None:
        """Build a study from the study file's tables as keywords. Raises InputError, naming key and value."""
        self._fill(tables, None, "study", {})

    def _fill(self, tables: dict[str, Any], text: str | None, where: str, context: Mapping[str, Any]) -> None:
        try:
            checked = Tables.model_validate(tables, context=dict(context))
        except ValidationError as error:
            raise InputError(explain(error, where)) from None
        self.name, self.seed = checked.name, checked.seed
        self.until = checked.trials if isinstance(checked.trials, Until) else None
        self.trials: int = checked.trials.at_most if isinstance(checked.trials, Until) else checked.trials
        self.swarm, self.world = checked.swarm, checked.world
        self.schedule, self.measure = checked.schedule, checked.measure
        self.faults = checked.faults
        self.text = text if text is not None else to_toml(tables)
        count = self._count()
        if count > MOST_SETTINGS:
            raise InputError(f"{where}: its lists span {count:,} settings; {MOST_SETTINGS:,} is the most")
        settings = self.settings()
        kept = len(self.checkpoints) if self.measure.estimates else 1
        values = len(settings) * self.trials * max(self.swarm.robots) * kept
        if values > MOST_VALUES:
            raise InputError(
                f"{where}: {len(settings)} settings of {self.trials} trials make {values:,} values to keep; "
                f"{MOST_VALUES:,} is the most: fewer trials, settings{', checkpoints' * (kept > 1)} or robots"
            )
        if len(set(settings)) < len(settings):
            seen: set[Setting] = set()
            twice = next(s for s in settings if s in seen or seen.add(s))  # type: ignore[func-returns-value]
            raise InputError(f"{where}: a value stands twice in a list, and so does the setting {twice}")
        for accuracy in self.swarm.accuracy:
            if accuracy.is_blind:
                warnings.warn(
                    f"{where}: accuracy {accuracy} carries no information: "
                    "such a sensor says the same of black and white",
                    stacklevel=2,
                )

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a study file. Brain files, edge lists and images are looked for beside it."""
        try:
            text = Path(path).read_text(encoding="utf-8-sig")
        except (OSError, UnicodeDecodeError, ValueError) as error:
            raise InputError(f"study file {path}: cannot be read as text: {error}") from error
        return cls.parse(text, where=f"study file {path}", context={"base": Path(path).parent})

    @classmethod
    def parse(cls, text: str, *, where: str = "study", context: Mapping[str, Any] = {}) -> Self:
        """Read a study from TOML text.

        `context` may hold `base` (the folder of brain files, edge lists and images), and `brains`, `edges` and
        `images` (known by name, so that no file is read). Raises InputError, naming file, key and value.
        """
        study = cls.__new__(cls)
        study._fill(read_toml(text, where), text, where, context)
        return study

    def with_(self, **changes: Any) -> Self:
        """The same study with another seed or number of trials; None leaves a value as it is."""
        changes = {k: v for k, v in changes.items() if v is not None}
        if not changes:
            return self
        study = type(self).__new__(type(self))
        study._fill({**read_toml(self.text, "study"), **changes}, None, "study", self.context)
        return study

    @property
    def context(self) -> dict[str, Any]:
        """What `parse` must know to read the study's text again without its files."""
        return {
            "brains": {b.name: b for b in self.swarm.brain},
            "edges": {t.source: t.edges for t in self.world.topology if t.source},
            "images": {p.source: p.grey for p in self.pictures},
        }

    def stages(self) -> Iterator[int]:
        """After how many trials of a setting it is looked at whether there are enough: once, but for a rule."""
        return self.until.stages() if self.until else iter([self.trials])

    @property
    def pictures(self) -> list[Picture]:
        """The images of floors, each file once."""
        return list({f.picture.source: f.picture for f in self.world.floor or () if f.picture}.values())

    @property
    def checkpoints(self) -> list[int]:
        """The rounds at which decisions are recorded: by default 1, 2, 5, 10, 20, 50 ... and the last."""
        if self.measure.checkpoints is not None:
            return sorted(set(self.measure.checkpoints))
        lengths = self._lengths
        steps = {m * 10**k for k in range(10) for m in (1, 2, 5)}
        asked = {self.until.checkpoint} if self.until and self.until.checkpoint else set()
        return sorted({s for s in steps if s < max(lengths)} | lengths | asked)

    @property
    def _lengths(self) -> set[int]:
        """How many rounds, or ticks, settings have."""
        moving = {t.name == MOVING for t in self.world.topology}
        return {*(self.schedule.rounds if False in moving else ()), *(self.schedule.ticks if True in moving else ())}

    def _count(self) -> int:
        """How many settings there are."""
        swarm, world, schedule = self.swarm, self.world, self.schedule
        moving = sum(t.name == MOVING for t in world.topology)
        fixed = len(world.topology) - moving
        lists = [swarm.brain, swarm.robots, swarm.accuracy, swarm.assumed_accuracy, world.fill_ratio]
        return math.prod(len(v or (None,)) for v in (*lists, world.link_success)) * int(
            fixed * len(schedule.rounds) * len(schedule.observations_per_round)
            + moving * len(world.density or ()) * len(world.floor or [None]) * len(schedule.ticks)
        )

    def settings(self) -> list[Setting]:
        """Every combination of the study's values: brain, topology, robots and accuracy vary slowest."""
        swarm, world, schedule = self.swarm, self.world, self.schedule
        fixed = [(c, r, None, None, self.faults) for c in schedule.rounds for r in schedule.observations_per_round]
        moving = [
            (ticks, 1, density, world.body, self.faults, floor)
            for density in world.density or ()
            for floor in world.floor or [Floor()]
            for ticks in schedule.ticks
        ]
        return [
            Setting(*values, *length)
            for values in itertools.product(
                swarm.brain,
                world.topology,
                swarm.robots,
                swarm.accuracy,
                swarm.assumed_accuracy or [None],
                world.fill_ratio,
                world.link_success,
            )
            for length in (moving if values[1].name == MOVING else fixed)
        ]
