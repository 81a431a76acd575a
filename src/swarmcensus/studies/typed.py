"""A study's tables as editors and type checkers see them. tools/typed_tables.py writes this file."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, Protocol, Required, TypeAlias, TypedDict, TypeVar

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from swarmcensus.brains import Adversary, Brain
from swarmcensus.brains.metrics import Metric
from swarmcensus.worlds import Accuracy, Change, Floor, Misjudgement, Topology

T = TypeVar("T")


class Column(Protocol):
    """Values of pandas or xarray."""

    def to_numpy(self) -> Any:
        """The values as an array."""


Whole: TypeAlias = int | np.integer[Any]
Real: TypeAlias = float | np.integer[Any] | np.floating[Any]
Several: TypeAlias = T | Sequence[T] | NDArray[Any] | Column


class UntilTable(TypedDict, total=False):
    """A rule: run trials until the half-width of the 95 % interval over trials is small enough."""

    until: Required[str]
    """The measure and its half-width, as "convergence_error median +- 0.001"."""
    at_least: Whole
    """Trials before the first look. Default: 30."""
    at_most: Whole
    """Trials after which the run ends in any case. Default: 1000."""


class BodyTable(TypedDict, total=False):
    """Shape, motion, sensors and radio of a robot, in SI units; a disc with two wheels."""

    speed: Real
    """m/s, straight. Default: 0.14."""
    turn_speed: Real
    """m/s of each wheel, against each other, when turning on the spot. Default: 0.14."""
    wheel_distance: Real
    """m, between the wheels. Default: 0.1054."""
    radius: Real
    """m, of the body, a disc. Default: 0.0704."""
    tick: Real
    """s, between two decisions. Default: 0.1."""
    wheel_lag: Real
    """Of a tick, until new wheel speeds take hold. Default: 0.1."""
    straight_mean: Real
    """Ticks of a straight run: floor of an exponential. Default: 15.0."""
    turn_most: Whole
    """Ticks of a turn: uniform from 0. Default: 10."""
    proximity_range: Real
    """m from the body's edge, along 8 rays. Default: 0.12."""
    proximity_near: Real
    """m, below which a ray reads 1. Default: 0.04."""
    avoid_above: Real
    """Length of the mean reading from which there is an obstacle. Default: 0.01."""
    avoid_within: Real
    """Degrees from straight ahead, where an obstacle counts. Default: 100.0."""
    sensor: tuple[Real, Real]
    """m ahead and to the left of the centre: the ground sensor. Default: [0.0614, 0.01]."""
    tile: Real
    """m, the side of a floor tile. Default: 0.01."""
    radio_range: Real
    """m between centres. Default: 0.7."""
    line_of_sight: bool
    """Whether a body in between stops a message. Default: True."""
    message_delay: Whole | str
    """Ticks, or a time: how old a message is when it is heard. Default: 1."""


class SwarmTable(TypedDict, total=False):
    """The robots: their brains, their number, their sensors, and what they assume about these."""

    brain: Several[str | Mapping[str, Any] | Path | Brain]
    """A shipped brain's name or the path of a brain file; {file = "...", prior = 1} gives it parameters.

    Default: "minimalistic".
    """
    robots: Required[Several[Whole]]
    """N, how many."""
    accuracy: Required[Several[Real | str | Mapping[str, Any] | Accuracy]]
    """The true b and w of the sensors, as 0.8, "U(0.525, 0.975)" or {black = 0.9, white = 0.6}."""
    assumed_accuracy: Several[Real | str | Mapping[str, Any] | Accuracy | Misjudgement]
    """The b and w that robots assume; by default the true ones."""
    precision: Several[Literal["double", "single"]]
    """The precision of the robots' arithmetic: "double", or "single" as most boards have it. Default: "double"."""


class WorldTable(TypedDict, total=False):
    """The robots' world: who hears whom, the share of black, and how often and how late messages get through."""

    topology: Required[Several[str | Mapping[str, Any] | Path | nx.Graph | Topology]]
    """Who hears whom: a network, or "moving" for robots that walk in an arena."""
    fill_ratio: Required[Several[Real | Mapping[str, Any] | Change]]
    """f, the fraction of the floor that is black, or a change as {from = 0.9, to = 0.1, at = 500}."""
    link_success: Several[Real]
    """The probability that a message gets through. Default: 1.0."""
    missing_links: Several[Real]
    """The probability that two neighbours on a fixed network never hear each other in a trial. Default: 0.0."""
    message_delay: Several[Whole]
    """How many rounds late messages are on fixed networks. Default: 0."""
    message: Several[Literal["double", "float32", "float16", "ratio16", "ratio8"]]
    """How the numbers of a message are sent: "float32", "float16", "ratio16", "ratio8"; "double" rounds nothing.

    Default: "double".
    """
    feedback: bool
    """Whether what rounding takes of a message is added to the next one. Default: True."""
    density: Several[Real]
    """D = N π r² / L² of robots that move."""
    side: Several[Real]
    """The side L of the arena in metres, in place of a density."""
    floor: Several[str | Mapping[str, Any] | Path | Floor]
    """What lies under robots that move: "tiles", {clusters = 0.2}, "half", an image."""
    body: BodyTable
    """The body of robots that move."""


class ScheduleTable(TypedDict, total=False):
    """How long: communication rounds (C), and observations in each (R); ticks for robots that move."""

    rounds: Several[Whole]
    """C, communication rounds on fixed networks. Default: 1000."""
    observations_per_round: Several[Whole]
    """R, observations of each robot before each exchange. Default: 10."""
    ticks: Several[Whole | str]
    """How long robots move: a number of ticks, or a time such as "17 min". Default: 10000."""


class CaseTable(TypedDict, total=False):
    """Values in place of some of the tables' above: another grid, in addition to the full one."""

    brain: Several[str | Mapping[str, Any] | Path | Brain]
    """A shipped brain's name or the path of a brain file; {file = "...", prior = 1} gives it parameters."""
    robots: Several[Whole]
    """N, how many."""
    accuracy: Several[Real | str | Mapping[str, Any] | Accuracy]
    """The true b and w of the sensors, as 0.8, "U(0.525, 0.975)" or {black = 0.9, white = 0.6}."""
    assumed_accuracy: Several[Real | str | Mapping[str, Any] | Accuracy | Misjudgement]
    """The b and w that robots assume; by default the true ones."""
    precision: Several[Literal["double", "single"]]
    """The precision of the robots' arithmetic: "double", or "single" as most boards have it."""
    topology: Several[str | Mapping[str, Any] | Path | nx.Graph | Topology]
    """Who hears whom: a network, or "moving" for robots that walk in an arena."""
    fill_ratio: Several[Real | Mapping[str, Any] | Change]
    """f, the fraction of the floor that is black, or a change as {from = 0.9, to = 0.1, at = 500}."""
    link_success: Several[Real]
    """The probability that a message gets through."""
    missing_links: Several[Real]
    """The probability that two neighbours on a fixed network never hear each other in a trial."""
    message_delay: Several[Whole]
    """How many rounds late messages are on fixed networks."""
    message: Several[Literal["double", "float32", "float16", "ratio16", "ratio8"]]
    """How the numbers of a message are sent: "float32", "float16", "ratio16", "ratio8"; "double" rounds nothing."""
    density: Several[Real]
    """D = N π r² / L² of robots that move."""
    side: Several[Real]
    """The side L of the arena in metres, in place of a density."""
    floor: Several[str | Mapping[str, Any] | Path | Floor]
    """What lies under robots that move: "tiles", {clusters = 0.2}, "half", an image."""
    rounds: Several[Whole]
    """C, communication rounds on fixed networks."""
    observations_per_round: Several[Whole]
    """R, observations of each robot before each exchange."""
    ticks: Several[Whole | str]
    """How long robots move: a number of ticks, or a time such as "17 min"."""


class MeasureTable(TypedDict, total=False):
    """What is measured: convergence within delta, decisions among bins at checkpoints, estimates and metrics."""

    delta: Real
    """A robot has converged once its estimate moves by less than this from then on. Default: 0.01."""
    bins: Whole
    """B: [0, 1] is divided into this many equal bins, among which robots decide. Default: 10."""
    checkpoints: Several[Whole | str]
    """Rounds, ticks or times after which decisions are recorded."""
    local: bool
    """Also measure the local estimate, after every single observation. Default: False."""
    estimates: bool
    """Also keep each robot's estimate at the checkpoints. Default: False."""
    truth: Literal["nominal", "floor"]
    """The truth for errors and decisions: f, or the black share of the drawn floor. Default: "nominal"."""
    metrics: Several[str | Path | Metric]
    """Further measures: shipped metrics or metric files."""


class FaultTable(TypedDict, total=False):
    """Some robots stop moving, sensing or talking at round (or tick) `at`, and begin again at `until`, if given."""

    at: Required[Whole | str]
    """The first round, tick or time with the fault."""
    robots: Required[Whole | Real | Mapping[str, Any]]
    """How many fail, drawn for each trial: a number, or a fraction of the swarm; or which, as {named = [3, 5]}."""
    stop: Several[Literal["moving", "sensing", "talking"]]
    """What they stop doing."""
    do: Literal["kill", "restart", "stop", "cut"]
    """What happens to processes: they are killed, restarted, stopped, or cut off from the others."""
    blank: bool
    """Whether a robot that is started again has lost its memory. Default: False."""
    until: Whole | str
    """The first round, tick or time without the fault."""


class MembersTable(TypedDict, total=False):
    """Robots that differ from the others: each key but `honest` may be a list, which spans the grid."""

    robots: Required[Several[Whole | Real]]
    """How many: a number, or a fraction of the swarm."""
    brain: Several[str | Mapping[str, Any] | Path | Brain | Adversary]
    """Their brain, or an adversary."""
    accuracy: Several[Real | str | Mapping[str, Any] | Accuracy]
    """The true b and w of their sensors."""
    assumed_accuracy: Several[Real | str | Mapping[str, Any] | Accuracy | Misjudgement]
    """The b and w that they assume."""
    speed: Several[Real]
    """How fast they move, in m/s."""
    honest: bool
    """Whether metrics count them. Default: True."""


class StudyTables(TypedDict, total=False):
    """The study file as a whole."""

    name: str
    """The title of the results and of figures; without one, the name of the study file. Default: "study"."""
    seed: Whole
    """The same seed gives the same numbers. Default: 0."""
    trials: Required[Whole | UntilTable]
    """Repetitions of each setting, or a rule that adds trials until they suffice."""
    swarm: Required[SwarmTable]
    """The robots."""
    world: Required[WorldTable]
    """Their world."""
    schedule: ScheduleTable
    """How long."""
    measure: MeasureTable
    """What is measured."""
    faults: Sequence[FaultTable]
    """Robots that fail."""
    case: Sequence[CaseTable]
    """Values that go together, in addition to the full grid."""
    members: Sequence[MembersTable]
    """Robots that differ from the others."""
    labels: Mapping[str, str]
    """What tables and figures call brains, as "mine.py" = "My brain"; this changes no numbers."""
    groups: Mapping[str, str]
    """Names of groups of settings, each with an expression as --where takes it; this changes no numbers."""
