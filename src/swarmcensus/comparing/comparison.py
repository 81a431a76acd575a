"""Which brain is better in which world, by how much, for which cost, and what trials do not tell: `sc.compare`."""

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.formatting import counted
from swarmcensus.basics.hints import did_you_mean
from swarmcensus.basics.options import option
from swarmcensus.comparing import groups, tables
from swarmcensus.comparing.contenders import NONE, Field, field_of
from swarmcensus.comparing.pair_tests import ALPHA, Asked, Contest, contests, pairs_of
from swarmcensus.comparing.standings import Standings
from swarmcensus.comparing.verdicts import verdict
from swarmcensus.results import measures, selecting
from swarmcensus.results.cautions import settled_at_start
from swarmcensus.results.measures import COSTS, SIZES, Measure
from swarmcensus.results.store import load
from swarmcensus.results.summaries import asked_anew, done, failed_trials
from swarmcensus.statistics.bootstrap import centres
from swarmcensus.statistics.corrections import fewest_trials

Floats = NDArray[np.float64]

STILL = 0.5  # of a contender's robots have K = 0: that is told


class Comparison(Standings):
    """Contenders in worlds: `table`, `pairs`, `ranks` and `duels` are pandas tables, `verdict` says it in sentences.

    Printed, it is these sentences and the cautions.
    """

    @property
    def verdict(self) -> list[str]:
        """Who is best in how many worlds, who is not told apart from it, and what that costs, a sentence each."""
        return verdict(self)

    @property
    def table(self) -> Any:
        """A pandas table with a row for each world and contender.

        Of each measure there are its value, the ends of its 95 % interval (`_low`, `_high`), its `_rank` in the world
        and its `_standing`: "best" is told apart from all others, "level" is first or not told apart from the first,
        "behind" is told apart from it; of contenders held against one of them "better", "level" or "worse". Then come
        costs and sizes.
        """
        return tables.table(self)

    @property
    def pairs(self) -> Any:
        """A pandas table with a row for each measure, world and pair of contenders: the difference `one` - `other`."""
        return tables.pairs(self)

    @property
    def ranks(self) -> Any:
        """A pandas table with a row for each measure and contender: its average rank, and where it is first."""
        return tables.ranks(self)

    @property
    def duels(self) -> Any:
        """A pandas table with a row for each measure and pair: who is ahead in how much of the worlds they all met."""
        return tables.duels(self)

    def by(self, *axes: str) -> Any:
        """A pandas table: for each combination of these axes' values and contender, how often it stands where.

        Held against one, each other contender has of each measure its value by that of the one (`_ratio`), of shares
        their difference (`_difference`): the median over these worlds, and the worst. Raises InputError where worlds do
        not differ in such an axis.
        """
        return groups.groups(self, axes)

    def __str__(self) -> str:
        """What came of it, in sentences."""
        return "\n".join([*self.verdict, *(f"caution: {one}" for one in self.cautions)])


def compare(
    results: xr.Dataset | str | Path,
    metric: str | Sequence[str] = (),
    where: str | None = None,
    against: str | None = None,
) -> Comparison:
    """Compare brains, and a brain's parameters, within each world, paired trial by trial (docs/comparing.md).

    `metric` names the measures that are compared and corrected for, as "correct" or ["final_error", "my_metric:low"];
    by default they are the final error, the convergence, the right decisions, consensus where brains decide, and
    metrics of files. `where` picks settings, as in `swarmcensus show`. With `against`, a contender or a brain that is
    but one, all others are held against it alone, which takes fewer tests. Raises InputError, as where there is nothing
    to compare.
    """
    return compared(load(results) if isinstance(results, str | Path) else results, metric, where, against, {})


def compared(
    whole: xr.Dataset,
    metric: str | Sequence[str],
    where: str | None,
    against: str | None,
    shown: Mapping[str, Collection[str]],
) -> Comparison:
    """The same with parameters, brain by brain, that names of contenders have even where all have the same value."""
    data = selecting.where(whole, where)
    selecting.require(data, "convergence_round", "rounds", dimensions=("setting", "trial"))
    field, cautions = field_of(data, whole, shown)
    if not isinstance(against, str | None):
        raise InputError(f"{option('against', against)}: should be the name of a contender")
    mark = None if against is None else _marked(against, field.contenders)
    some, unsaid = measures.chosen(data, metric)
    numbers = [field.spread(measures.numbers(data, one.name)) for one in some]
    if all(np.isnan(one).all() for one in numbers):
        what = f"has numbers of {', '.join(one.label for one in some)}" if done(data).any() else "has been run"
        raise InputError(f"there is nothing to compare: no trial of these settings {what}")
    asked = zip(numbers, some, strict=True)
    found = contests([Asked(each, one.statistic, one.low, one.share) for each, one in asked], against=mark)
    costs = {
        name: centres(field.spread(measures.numbers(data, name)), "mean")
        for name in COSTS
        if not measures.lacks(data, name)
    }
    sizes = {name: field.spread(data[name].values.astype(np.float64)) for name in SIZES if name in data}
    settings = np.where(field.place == NONE, NONE, data["setting"].values[field.place])
    cautions += [*unsaid, *_cautions(data, field, some, numbers, found, costs)]
    title = str(data.attrs.get("title", ""))
    return Comparison(title, field, some, found, costs, sizes, settings, cautions, mark)


def _marked(name: str, contenders: list[str]) -> int:
    """The place of the contender of this name, or of the only one of this brain."""
    found = [one for one in contenders if one == name] or [one for one in contenders if one.startswith(f"{name} ")]
    if len(found) != 1:
        hint = did_you_mean(name, contenders)
        what = (
            f"these are several, {', '.join(found)}: name one" if found else f"{hint}there are {', '.join(contenders)}"
        )
        raise InputError(f"{option('against', name)}: {what}")
    return contenders.index(found[0])


def _cautions(
    data: xr.Dataset,
    field: Field,
    some: list[Measure],
    compared: list[Floats],
    found: list[Contest],
    costs: dict[str, Floats],
) -> list[str]:
    """What should be known of a comparison before it is believed, a sentence each."""
    cautions = []
    failed = len(failed_trials(data))
    if failed:
        cautions.append(f"{counted(failed, 'trial')} failed, and no trial that failed is compared")
    counts = found[0].trials[field.place != NONE]
    if counts.min() < counts.max():
        cautions.append(
            f"contenders have {counts.min()} to {counts.max():,} trials: those are compared that both of a pair have, "
            "and over all worlds those that all have in all of them"
        )
    for one, numbers in zip(some, compared, strict=True):
        lacking = np.isnan(numbers).all(axis=2) & (field.place != NONE)
        if lacking.any():
            names = [name for name, lacks in zip(field.contenders, lacking.any(axis=0), strict=True) if lacks]
            cautions.append(
                f"{one.label}: there are no numbers of {', '.join(names)} in {_worlds(lacking.any(axis=1))}"
            )
    tests = sum(int((~np.isnan(part)).sum()) for one in found for part in (one.corrected, one.duels_corrected))
    least, most = fewest_trials(tests, ALPHA), max(int((~np.isnan(n)).sum(axis=2).max()) for n in compared)
    if most < least:
        cautions.append(
            f"{counted(most, 'trial')} cannot tell anything apart among {counted(tests, 'test')}: run {least} or more, "
            "or compare fewer measures or worlds"
        )
    pairs = [(field.contenders[one], field.contenders[other]) for one, other in pairs_of(len(field.contenders))]
    cautions += [
        f"{one.label}: {first} and {second} are the same in every trial that both have"
        for one, contest in zip(some, found, strict=True)
        if one.unit == "1" and not one.share  # others are equal by chance
        for (first, second), alike in zip(pairs, contest.alike, strict=True)
        if alike
    ]
    lacks = dict.fromkeys(one for name in COSTS if name not in costs for one in measures.lacks(data, name))
    lacks |= dict.fromkeys(name for name in SIZES if name not in data)
    if lacks:
        cautions.append(f"these results do not say what brains cost: they have no {', no '.join(lacks)}")
    if "anonymous" in data:
        seen = field.spread(data["anonymous"].values.astype(np.float64))
        named = [name for k, name in enumerate(field.contenders) if (seen[:, k] == 0).any()]
        if len(named) == 1:
            cautions.append(f"{named[0]} is not anonymous: it uses its robot's name")
        elif named:
            cautions.append(f"{', '.join(named)} are not anonymous: they use their robots' names")
    if any(one.name == "convergence_round" for one in some):
        still = np.asarray(field.spread(settled_at_start(data)) >= STILL)
        named = [name for k, name in enumerate(field.contenders) if still[:, k].any()]
        if named:
            where = _worlds(np.asarray(still.any(axis=1)))
            cautions.append(
                f"{', '.join(named)}: in {where} half of the robots or more have K = 0: their estimates never moved by "
                "delta, and K does not tell how soon they learn"
            )
        if "delta" in asked_anew(data):
            cautions.append("K was asked anew of kept estimates, and is one of the checkpoints")
    return cautions


def _worlds(which: NDArray[np.bool_]) -> str:
    numbers = np.flatnonzero(which).tolist()
    several = ", ".join(map(str, numbers[:8])) + (", ..." if len(numbers) > 8 else "")
    return f"world{'s' * (len(numbers) > 1)} {several}"
