"""What a bound knows of its trial: the schedule of the floor and of the sensors, as parameters of its brain."""

from swarmcensus.brains import Brain
from swarmcensus.studies.settings import Setting


def informed(brain: Brain, setting: Setting, *, alone: bool = False) -> Brain:
    """An oracle with those of its parameters that say when the fill ratio changes and how the swarm's sensors drift.

    Other brains, and oracles where nothing changes, stay as they are. `alone` is for robots that end a round after each
    reading.
    """
    drift, change = setting.accuracy.drift, setting.change
    if not brain.is_oracle or (drift is None and change is None):
        return brain
    known = {"fuses": float(setting.observations_per_round if alone else 1)}
    if change is not None:
        known |= {"change": float(setting.course[2]), "until": float(setting.course[3])}
    if drift is not None:
        known |= dict(zip(("drift", "least", "most"), drift.numbers, strict=True))
    return brain.with_parameters({name: value for name, value in known.items() if name in brain.parameters})
