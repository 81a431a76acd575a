"""A comparison of many worlds in few rows: standings counted over worlds that share the values of some axes."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from swarmcensus.analysis.comparing.standings import AGAINST, RANKED, Standings
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import wrong_option

if TYPE_CHECKING:
    import pandas as pd


def groups(standings: Standings, axes: Sequence[str]) -> "pd.DataFrame":
    """See `Comparison.by`."""
    import pandas as pd

    ways = RANKED if standings.against is None else AGAINST
    rows = []
    for values, worlds in worlds_by(standings, axes).items():
        for k, name in enumerate(standings.contenders):
            met = worlds[standings.settings[worlds, k] >= 0]
            if not met.size or k == standings.against:
                continue
            row: dict[str, Any] = dict(zip(axes, values, strict=True)) | {"contender": name, "worlds": met.size}
            for measure, contest in zip(standings.measures, standings.contests, strict=True):
                standing = standings.standing(contest)[met, k]
                row |= {f"{measure.name}_{way}": int((standing == way).sum()) for way in ways}
                if standings.against is not None:
                    own, reference = contest.values[met, k], contest.values[met, standings.against]
                    gaps = _gaps(own, reference, measure.share)
                    row[f"{measure.name}_{gap_name(measure.share)}"] = float(np.median(gaps)) if gaps.size else np.nan
                    row[f"{measure.name}_worst"] = (
                        float(gaps.max() if contest.low else gaps.min()) if gaps.size else np.nan
                    )
            rows.append(row)
    return pd.DataFrame(rows)


def gap_name(share: bool) -> str:
    """How a contender's values are compared with the reference's: shares, which may be 0, by difference."""
    return "difference" if share else "ratio"


def _gaps(own: NDArray[np.float64], reference: NDArray[np.float64], share: bool) -> NDArray[np.float64]:
    with np.errstate(invalid="ignore", divide="ignore"):  # both may be 0, or both infinite
        gaps = own - reference if share else own / reference
    return np.asarray(gaps[~np.isnan(gaps)])


def worlds_by(standings: Standings, axes: Sequence[str]) -> dict[tuple[Any, ...], NDArray[np.intp]]:
    """The worlds of each combination of values, in the order of the worlds. Raises InputError."""
    names = list(dict.fromkeys(name for world in standings.grid.worlds for name in world))
    for name in axes:
        if name in standings.grid.common:
            raise wrong_option("by", name, f"all worlds have the same, {standings.grid.common[name]}")
        if name in standings.grid.factor:
            raise wrong_option("by", name, "it is the factor that is compared, so worlds do not differ in it")
        if name not in names:
            hint = did_you_mean(name, names)
            raise wrong_option("by", name, f"{hint}worlds differ in {', '.join(names) or 'nothing'}")
    keys = [tuple(world.get(name) for name in axes) for world in standings.grid.worlds]
    return {key: np.array([w for w, world_key in enumerate(keys) if world_key == key]) for key in dict.fromkeys(keys)}
