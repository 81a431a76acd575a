"""Sensors that wear or warm up: `{start = 0.9, drift = -1e-5, least = 0.6}`, an accuracy that drifts by the round."""

from collections.abc import Mapping
from dataclasses import dataclass

from swarmcensus.basics.hints import did_you_mean
from swarmcensus.worlds.spreading import Spread, parse_spread

KEYS = ("start", "drift", "least", "most")
BLIND, PERFECT = 0.5, 1.0  # where a drift ends that says nothing else
FORM = "{start = 0.9, drift = -1e-5, least = 0.6}"


@dataclass(frozen=True)
class Drift:
    """What an accuracy gains from each round (or tick) to the next, below 0 where it is lost, and where it stays."""

    slope: float
    bound: float

    def __str__(self) -> str:
        """As in the dataset, after what it starts from: "drift=-1e-05 least=0.6"."""
        return " ".join(f"{key}={value}" for key, value in self.form.items())

    @property
    def form(self) -> dict[str, float]:
        """As in a study file, beside its start."""
        return {"drift": self.slope, "least" if self.slope < 0.0 else "most": self.bound}

    @property
    def numbers(self) -> tuple[float, float, float]:
        """What is gained a round, the least and the greatest."""
        return (self.slope, self.bound, 1.0) if self.slope < 0.0 else (self.slope, 0.0, self.bound)


def parse_drift(value: Mapping[str, object]) -> tuple[Spread, Drift]:
    """Read the accuracies that robots start from, and how they drift. Raises ValueError with what would be right."""
    for key in value:
        if key not in KEYS:
            raise ValueError(f"unknown key {key}: {did_you_mean(str(key), KEYS)}an accuracy that drifts is {FORM}")
    for key in KEYS[:2]:
        if key not in value:
            raise ValueError(f"{key} is missing: an accuracy that drifts is {FORM}")
    start, slope = parse_spread(value["start"]), _number("drift", value["drift"], -1.0)
    if slope == 0.0:
        raise ValueError("drift = 0 is none: give the accuracy as a plain number or spread")
    falls = slope < 0.0
    key, other = ("least", "most") if falls else ("most", "least")
    if other in value:
        raise ValueError(f"{other} means nothing where the drift is {'below' if falls else 'above'} 0: give {key}")
    bound = _number(key, value.get(key, BLIND if falls else PERFECT), 0.0)
    low, high = start.ends()
    if (low <= bound) if falls else (high >= bound):
        way = "above" if falls else "below"
        raise ValueError(f"start = {start} should lie {way} {key} = {bound}, where the drift ends")
    return start, Drift(slope, bound)


def _number(key: str, value: object, least: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not least <= value <= 1.0:
        raise ValueError(f"{key} should be a number in [{least:g}, 1]")
    return float(value)
