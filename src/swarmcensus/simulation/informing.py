"""What a bound knows of its trial: when the fill ratio changes, and how sensors drift."""

from swarmcensus.studies import Setting


def schedule_of(setting: Setting, *, alone: bool = False) -> dict[str, float]:
    """The initial values of an oracle's fields that hold the schedule; empty if there is none, and for other brains.

    The schedule has when the fill ratio changes, not from what to what, and the drift of the swarm's accuracy. `alone`
    is for robots that end a round after each reading.
    """
    brain, drift, change = setting.brain, setting.accuracy.drift, setting.change
    if not brain.is_oracle or (drift is None and change is None):
        return {}
    schedule = {"fuses": float(setting.observations_per_round if alone else 1)}
    if change is not None:
        schedule |= {"change": float(setting.course[2]), "until": float(setting.course[3])}
    if drift is not None:
        schedule |= dict(zip(("drift", "least", "most"), drift.numbers, strict=True))
    return {name: value for name, value in schedule.items() if name in brain.memory}
