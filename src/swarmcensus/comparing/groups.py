"""A comparison of many worlds in few rows: who is better in how many of those that share a value of an axis."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.hints import did_you_mean
from swarmcensus.basics.options import option
from swarmcensus.comparing.standings import AGAINST, RANKED, Standings


def groups(found: Standings, axes: Sequence[str]) -> Any:
    """See `Comparison.by`."""
    import pandas as pd

    ways = RANKED if found.against is None else AGAINST
    rows = []
    for values, worlds in worlds_by(found, axes).items():
        for k, name in enumerate(found.contenders):
            met = worlds[found.settings[worlds, k] >= 0]
            if not met.size or k == found.against:
                continue
            row: dict[str, Any] = dict(zip(axes, values, strict=True)) | {"contender": name, "worlds": met.size}
            for one, contest in zip(found.measures, found.contests, strict=True):
                standing = found.standing(contest)[met, k]
                row |= {f"{one.name}_{way}": int((standing == way).sum()) for way in ways}
                if found.against is not None:
                    mine, other = contest.values[met, k], contest.values[met, found.against]
                    gaps = _gaps(mine, other, one.share)
                    row[f"{one.name}_{gap_of(one.share)}"] = float(np.median(gaps)) if gaps.size else np.nan
                    row[f"{one.name}_worst"] = float(gaps.max() if contest.low else gaps.min()) if gaps.size else np.nan
            rows.append(row)
    return pd.DataFrame(rows)


def gap_of(share: bool) -> str:
    """What is said of a contender's numbers beside those of whom it is held against: shares may well be 0."""
    return "difference" if share else "ratio"


def _gaps(mine: NDArray[np.float64], other: NDArray[np.float64], share: bool) -> NDArray[np.float64]:
    with np.errstate(invalid="ignore", divide="ignore"):  # 0 beside 0, never beside never
        gaps = mine - other if share else mine / other
    return np.asarray(gaps[~np.isnan(gaps)])


def worlds_by(found: Standings, axes: Sequence[str]) -> dict[tuple[Any, ...], NDArray[np.intp]]:
    """The worlds of each combination of values, in the order of the worlds. Raises InputError."""
    names = list(dict.fromkeys(name for world in found.field.worlds for name in world))
    for name in axes:
        if name in found.field.common:
            raise InputError(f"{option('by', name)}: all worlds have the same, {found.field.common[name]}")
        if name not in names:
            hint = did_you_mean(name, names)
            raise InputError(f"{option('by', name)}: {hint}worlds differ in {', '.join(names) or 'nothing'}")
    keys = [tuple(world.get(name) for name in axes) for world in found.field.worlds]
    return {key: np.array([w for w, other in enumerate(keys) if other == key]) for key in dict.fromkeys(keys)}
