"""Where a study does not give a brain what its file says that it needs (`brains/requirements.py`), in sentences."""

import functools
import warnings
from collections.abc import Iterable, Iterator

import numpy as np

from swarmcensus.brains import Brain, names_in
from swarmcensus.studies.settings import Setting
from swarmcensus.support.formatting import counted
from swarmcensus.worlds import Accuracy, Topology

MOST_ROBOTS = 10_000  # of networks whose neighbours are counted


def warn_of_needs(settings: Iterable[Setting], bins: int) -> None:
    """Warn of brains that are used outside their range, for the line that called the caller."""
    for sentence in unmet_needs(settings, bins):
        warnings.warn(sentence, stacklevel=3)


def unmet_needs(settings: Iterable[Setting], bins: int) -> list[str]:
    """A line for each honest brain that is used outside its range; `bins` are those of the study's question."""
    found: dict[str, dict[str, list[str]]] = {}
    worlds = dict.fromkeys(
        (brain, s.rounds, s.topology, s.robots, s.accuracy, s.fill_ratio, "round" if s.body is None else "tick")
        for s in settings
        for brain in _honest(s)
        if brain.needs
    )
    for brain, rounds, topology, robots, accuracy, fill_ratio, unit in sorted(worlds, key=lambda world: world[1]):
        there = found.setdefault(brain.name, {})
        lacks = {
            **_lacks_rounds(brain, rounds, unit),
            **_lacks_robots(brain, topology, robots),
            **_lacks_sensors(brain, accuracy),
            **_lacks_question(brain, bins),
            **_lacks_doubt(brain, fill_ratio),
        }
        for key, sentence in lacks.items():
            said, parameters = there.setdefault(key, [sentence]), _parameters(brain, key)
            if parameters and parameters not in said:
                said.append(parameters)
    return [f"{name} {'. It '.join(map(_phrase, needs.values()))}" for name, needs in found.items() if needs]


def _phrase(said: list[str]) -> str:
    """What a brain lacks, and the values of parameters with which it does."""
    sentence, *parameters = said
    more = f", and with {'; '.join(parameters[1:])}" if parameters[1:] else ""
    return sentence + (f" ({parameters[0]}{more})" if parameters else "")


def _honest(setting: Setting) -> Iterator[Brain]:
    yield setting.brain
    for member in setting.members:
        if member.honest and isinstance(member.brain, Brain):
            yield member.brain


def _lacks_rounds(brain: Brain, rounds: int, unit: str) -> dict[str, str]:
    lacks, has = {}, f"this study has {rounds:,}"
    if rounds <= (silent := brain.needs.get("silent", -1.0)):
        lacks["silent"] = f"says nothing before {unit} {int(silent) + 1:,}; {has}"
    if rounds < (least := brain.needs.get("rounds", 0.0)):
        lacks["rounds"] = f"needs {counted(round(least), unit)}; {has}"
    if rounds != (length := round(brain.needs.get("length", rounds))):
        lacks["length"] = f"is made for an answer after {unit} {length:,}; {has}"
    return lacks


def _lacks_robots(brain: Brain, topology: Topology, robots: int) -> dict[str, str]:
    lacks = {}
    if robots < (least := brain.needs.get("robots", 0.0)):
        lacks["robots"] = f"needs {counted(round(least), 'robot')}; this study has {robots:,}"
    least, mutual = brain.needs.get("neighbours", 0.0), brain.needs.get("mutual", 0.0)
    if not (least or mutual) or topology.moves or robots > MOST_ROBOTS:
        return lacks
    there = robots - 1.0
    if not topology.is_full:
        there, both_ways = _neighbours(topology, robots)
        if mutual and not both_ways:
            lacks["mutual"] = f"needs robots that hear each other; some links of {topology} go one way only"
    if there < least:
        lacks["neighbours"] = f"needs {least:g} neighbours; most robots of {topology} have {there:g} or fewer"
    return lacks


@functools.lru_cache(maxsize=64)
def _neighbours(topology: Topology, robots: int) -> tuple[float, bool]:
    """How many robots most robots hear, and whether all links go both ways; once for all settings of a network."""
    links = topology.links(robots, 0, 0, 1, lossless=True, sums=False)
    to, back = links.receivers * robots + links.senders, links.senders * robots + links.receivers
    both_ways = np.array_equal(np.sort(to), np.sort(back))
    return float(np.median(np.bincount(links.receivers, minlength=robots))), both_ways


def _lacks_sensors(brain: Brain, accuracy: Accuracy) -> dict[str, str]:
    if brain.needs.get("equal_sensors") and accuracy.white is not None and accuracy.white != accuracy.black:
        return {"equal_sensors": f"takes b and w to be equal, so an accuracy of {accuracy} biases its estimates"}
    exact = accuracy.drift is None and all(d.is_number and d.numbers[0] == 1.0 for d in accuracy.distributions)
    if exact or not brain.needs.get("perfect_sensors"):
        return {}
    return {"perfect_sensors": f"takes readings for the truth, so an accuracy of {accuracy} biases its estimates"}


def _lacks_question(brain: Brain, bins: int) -> dict[str, str]:
    if bins == 2 or not brain.needs.get("binary"):
        return {}
    return {"binary": f"answers whether f is above one half; this study asks for one of {bins:,} bins"}


def _lacks_doubt(brain: Brain, fill_ratio: float) -> dict[str, str]:
    place = fill_ratio * brain.needs.get("steps", 0.0) - 0.5
    if abs(place - round(place)) > 1e-9:
        return {}
    steps = round(brain.needs["steps"])
    better = f"chooses among the middles of {steps} steps, and f = {fill_ratio:g} is one: it errs less than at other f"
    return {"steps": better}


def _parameters(brain: Brain, key: str) -> str:
    """The parameters that a need depends on, and their values."""
    expression = brain.contents.needs.get(key)
    shown = [f"{name} = {brain.parameters[name]:g}" for name in names_in(expression)] if expression else []
    return ", ".join(shown)
