"""Which liars a mission may have."""

from typing import Any

from swarmcensus.brains import Adversary, worn


def check_liars(mission: Any) -> None:
    """Raise ValueError where nobody could lie, or nobody be right, or a liar fits no brain."""
    known, free = mission.known, mission.free
    if known.lie is not None and not known.lying:
        raise ValueError("known.lie: nobody lies: say what share of robots may (known.lying)")
    for one in known.lie or ():
        if not isinstance(one, Adversary):
            raise ValueError(f"known.lie = {one.name!r}: that is a brain, and not an adversary, such as shouter")
    if known.lying + known.failing >= 1.0:
        raise ValueError(
            f"known.lying = {known.lying:g} and known.failing = {known.failing:g} leave no robot that works and is "
            "honest: together they should be less than 1"
        )
    if known.lying and free.robots is not None and free.robots[1] == 1:
        raise ValueError(f"known.lying = {known.lying:g}: of one robot nobody is left to lie to it")
    for brain in mission.brains if known.lying else ():
        for lie in mission.lies if not brain.is_oracle else ():
            try:
                worn(lie, brain)
            except ValueError as error:
                raise ValueError(f"known.lie = {lie.told!r}: {error}") from None
