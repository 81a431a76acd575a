"""What a page may show: the settings of a study or of results, with other values of a study's keys.

A page chooses brains, floors and adversaries by name. It can read no files, except those that the server was given.
"""

import functools
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmcensus import brains
from swarmcensus.checks import caution
from swarmcensus.live.robots import memory_names
from swarmcensus.simulation import Stepped, Trace, warn_of_connections
from swarmcensus.studies import Setting, Study, addresses, read_value, short_key, to_text, warn_of_needs
from swarmcensus.support.errors import InputError, StudyError
from swarmcensus.support.files import check_no_log
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import option_conflict
from swarmcensus.worlds import FileEdges, Topology, wiring

if TYPE_CHECKING:  # imported late: without it the page of a study appears half a second sooner
    import xarray as xr

    from swarmcensus.live.recordings import LoggedRecording

MOST_ROBOTS, MOST_ROUNDS = 20_000, 1_000_000
MOST_TILES = 1_000_000  # along a side of the arena
MOST_CONNECTED = 2_000  # robots of a fully connected network
SHOWN: dict[str, Any] = {
    "swarm": {"brain": "commons", "robots": 25, "accuracy": 0.75},
    "world": {"topology": "moving", "density": 4.0, "fill_ratio": 0.55, "body": {"tile": 0.1}},
    "schedule": {"ticks": 10_000},
}  # the swarm that is shown without a study
FLOORS = {"tiles": "tiles", "half": "half", "{clusters = 0.3}": "clusters(0.3)", "{stripes = 0.5}": "stripes(0.5)"}
KEYS = ("setting", "trial", "seed", "beside", "of")  # of the page; all others are a study's
BESIDE = "beside."  # before the name of a parameter of the second brain
PLAYED = (
    "tick", "robot", "side", "plot", "colour", "zoom", "centre", "follow", "log", "full", "speed",
)  # fmt: skip  # what concerns the view
PART = r"(0(\.\d+)?|1(\.0+)?)"
DRAWN_BY = {  # of PLAYED, what the page alone needs: the pattern of a value, and what is right
    "colour": ("off|belief|error", "one of off, belief, error"),  # the signed error, the estimate, the absolute error
    "zoom": (r"[1-9](\.\d+)?|[1-3]\d(\.\d+)?|40", "a number from 1 to 40"),
    "centre": (f"{PART},{PART}", "two numbers from 0 to 1, such as 0.25,0.5"),
    "speed": (r"[1-9]\d{0,3}(\.\d+)?|10000|Infinity", "a number from 1 to 10000, or Infinity"),
    **dict.fromkeys(("follow", "log", "full"), ("[01]", "0 or 1")),
}
Finder = Callable[[int], tuple[Study, Setting]]  # the setting of a number, and its study


@dataclass(frozen=True)
class Offer:
    """What can be watched: settings by number, and what values of a study's keys can name."""

    name: str
    numbers: tuple[int, ...]
    find: Finder
    studies: tuple[Study, ...]
    brains: dict[str, brains.Brain]  # those of the studies, and others that were given, in addition to installed ones
    live: Callable[[Setting, int, int], Trace] = Stepped  # a setting's trial, by seed and number
    logged: "LoggedRecording | None" = None  # where robots lived the trial: nothing can be chosen
    folder: Path | None = None  # where files are that the first view may name

    @functools.cached_property
    def topologies(self) -> list[Topology]:
        """The topologies of its studies."""
        return list(dict.fromkeys(topology for study in self.studies for topology in study.topologies))

    @functools.cached_property
    def _read(self) -> dict[str, Any]:
        read: dict[str, Any] = {"plugins": [file for study in self.studies for file in study.plugin_files]}
        for context in (study.context for study in self.studies):
            read |= {key: {**read.get(key, {}), **found} for key, found in context.items() if isinstance(found, dict)}
        read["brains"] |= {brain.name: brain.as_written for brain in self.brains.values()}
        listed = {t.name: FileEdges(t.edges, t.directed) for t in self.topologies if t.edges and not t.source}
        return read | {"edges": listed | read["edges"]}

    def context(self, base: Path | None) -> dict[str, Any]:
        """What a study's values can name: what was read already, and files in `base`."""
        return self._read | {"base": base, "warned": True}


@dataclass(frozen=True)
class Wanted:
    """One trial to be watched, and optionally a second setting in the same world."""

    study: Study
    settings: tuple[Setting, ...]
    chosen: tuple[str, ...]  # the name of each setting's brain, or its table, without parameters that have a key
    seed: int
    trial: int
    request: dict[str, str]  # the values that were given, by key
    rounds: int  # how many can be shown
    mark: str  # identifies the unchanged setting, so that links to other studies are noticed


def offer_of(of: "Path | Study | xr.Dataset | None", given: tuple[Path, ...] = ()) -> Offer:
    """The offer of a study, of results, of a file of either, of a folder of robots' logs, or of a small swarm.

    `given` are more brains. Raises InputError.
    """
    name = of.name if isinstance(of, Path) else ""
    if isinstance(of, Path) and of.is_dir():
        from swarmcensus.live.recordings import LoggedRecording

        logged = LoggedRecording(of)
        study, setting = logged.study, logged.setting
        offer = _offer(logged.recording.title, (0,), [study], {}, lambda _: (study, setting))
        return replace(offer, live=lambda *_: logged.trace, logged=logged)
    if isinstance(of, Path):
        check_no_log(of)
        if not (of.suffix or of.exists()):
            raise InputError(f"{of}: there is no such study, results, brain or folder", file=of)
    if (isinstance(of, Path) and of.suffix.lower() == ".nc") or not isinstance(of, Path | Study | None):
        from swarmcensus.results import open_partial, setting_of, studies_of
        from swarmcensus.summaries import require

        data = open_partial(of) if isinstance(of, Path) else of
        require(data)
        studies, numbers = studies_of(data, given), tuple(map(int, data["setting"].values))
        return _offer(name or studies[0].name, numbers, studies, {}, lambda number: setting_of(data, number, given))
    more = {brain.label: brain for brain in map(brains.load, given)}
    study = Study.load(of) if isinstance(of, Path) else of or Study(name="a small swarm", trials=1000, seed=1, **SHOWN)
    study.check_faults()
    settings = study.settings()
    warn_of_needs(settings, study.measure.bins)
    warn_of_connections(settings, study.seed, study.trials)
    offer = _offer(name or study.name, tuple(range(len(settings))), [study], more, lambda k: (study, settings[k]))
    return replace(offer, folder=of.parent if isinstance(of, Path) else Path())


def _offer(
    name: str, numbers: tuple[int, ...], studies: list[Study], more: Mapping[str, brains.Brain], find: Finder
) -> Offer:
    if not numbers:
        raise InputError(f"{name}: there is no setting to watch", key=name)
    caution((*(brain for study in studies for brain in study.brains), *more.values()))
    own = {brain.label: brain for study in studies for grid in study.grids for brain in grid.swarm.brain}
    return Offer(name, numbers, find, tuple(studies), own | dict(more))


def wanted(offer: Offer, request: Mapping[str, str], base: Path | None = None) -> Wanted:
    """The trial that a request describes, key by key; other values are those of the setting. Raises InputError.

    Without a folder `base` no file is opened.
    """
    given = {key: text for key, text in request.items() if text != ""}
    number = _whole(given, "setting", offer.numbers[0], 0, 2**31)
    if number not in offer.numbers:
        raise InputError.at("setting", number, f"there are {offer.numbers[0]} to {offer.numbers[-1]}")
    study, setting = offer.find(number)
    first, began = (offer.logged.recording.trial, offer.logged.recording.seed) if offer.logged else (0, study.seed)
    mark = addresses.fingerprint(setting, study.seed)[:8]
    if given.get("of", mark) != mark:
        raise InputError.at("of", given["of"][:40], f"this link is not for {offer.name} as it is now")
    trial = _whole(given, "trial", first, 0, 2**31 - 1)
    seed = _whole(given, "seed", began, 0, 2**63 - 1)
    was = {"setting": number, "trial": first, "seed": began}
    for key, value in given.items() if offer.logged else ():  # what robots have lived stays as it was
        if key != "of" and value != str(was.get(key, "")):
            raise InputError.at(key, value[:40], "this recording is as its logs have it: nothing can be chosen")
    asked = {key: key if key in KEYS or key.startswith(BESIDE) else short_key(key, KEYS + PLAYED) for key in given}
    chosen = {"brain": to_text(setting.brain.form)}
    chosen |= {name: given[key] for key, name in asked.items() if name in ("brain", "beside")}
    values = {key: read_value(given[key]) for key in asked if key not in ("setting", "trial", "seed", "of")}
    _check_robots({asked[key]: value for key, value in values.items()}, setting.robots)
    study, settings = _settings_of(offer, study, setting, values, base)
    rounds = offer.logged.rounds if offer.logged else settings[0].rounds
    for one in settings:
        _check(one, rounds)
    shown = {name: given[key] for key, name in asked.items()}
    return Wanted(study, tuple(settings), tuple(chosen.values()), seed, trial, shown, rounds, mark)


def _settings_of(
    offer: Offer, study: Study, setting: Setting, values: dict[str, Any], base: Path | None
) -> tuple[Study, list[Setting]]:
    """The study of these values and its setting; with `beside` also that with a second brain. Raises InputError."""
    theirs = {key: values.pop(key) for key in [*values] if key.partition(".")[0] == "beside"}
    context, found = offer.context(base), [setting]
    if values:
        study = study.with_setting(setting, values, where=offer.name, context=context)
        study.check_faults()
        found = study.settings()
    if len(found) > 1:
        raise InputError(f"these values make {len(found):,} settings: should be one of each key, as one trial is shown")
    if theirs and "beside" not in theirs:
        key = next(iter(theirs))[:40]
        raise InputError(f"{key}: no second brain is selected: name one with beside", key=key)
    if theirs:
        brain = {f"swarm.brain{key.removeprefix('beside')}": value for key, value in theirs.items()}
        try:
            other = study.with_setting(found[0], brain, context=context).settings()[0].brain
        except StudyError as error:
            what = str(error).removeprefix("study: ").replace("swarm.brain", "beside", 1)
            raise InputError(what, key="beside", value=error.value, hint=error.hint) from None
        found.append(replace(found[0], brain=other.with_numbers(found[0].brain.numbers)))
    return study, found


def first_view(
    of: "Path | Study | xr.Dataset | None", asked: Mapping[str, str], given: tuple[Path, ...] = (),
    link: Mapping[str, str] = {},
) -> tuple[Offer, dict[str, str], dict[str, str]]:  # fmt: skip
    """The offer of what `of` names, what a page of it begins with, and how that is seen.

    `of` is as for `offer_of`, or a brain file, which the small swarm gets; `given` are the brain files of results.
    Files that `asked` names are read, next to a study or in the current folder; of `asked` with a `link`, which may be
    somebody else's, those of brains. The page can name these and no others. All that it will ask for is tried, so that
    errors are raised here, and not in the browser. Raises InputError.
    """
    words = {**link, **asked}
    named = {key: asked[key] for key in (("brain", "beside") if link else asked) if key in asked and key not in PLAYED}
    if isinstance(of, Path) and of.suffix.lower() == ".py":
        if "brain" in asked:
            raise option_conflict("set", "brain=...", f"does not go with {of}, which is the brain")
        words, named, of = {"brain": str(of)} | words, {"brain": str(of)} | named, None
    offer = offer_of(of, given)
    if offer.folder is not None:
        first = wanted(offer, named, offer.folder)
        read = [setting.brain.as_written for setting in first.settings]
        caution(read)
        known = offer.brains | {brain.label: brain for brain in read}
        offer = replace(offer, studies=(*offer.studies, first.study), brains=known)
    found = wanted(offer, {key: value for key, value in words.items() if key not in PLAYED})
    play = {key: value for key, value in words.items() if key in PLAYED}
    check_moment(found, play)
    return offer, found.request, play


def check_moment(found: Wanted, played: Mapping[str, str]) -> None:
    """Raise InputError for a tick, robot, side or colouring that the page cannot show."""
    setting = found.settings[0]
    most = {"tick": found.rounds, "robot": setting.robots - 1, "side": len(found.settings) - 1}
    for key, last in most.items():
        _whole(played, key, 0, 0, last)
    if "plot" in played:
        check_field(found.settings[int(played.get("side", 0))], "plot", played["plot"])
    for key in (one for one in DRAWN_BY if one in played):
        pattern, right = DRAWN_BY[key]
        if not re.fullmatch(pattern, played[key], re.ASCII):
            raise InputError.at(key, played[key][:40], f"should be {right}")


def check_field(setting: Setting, key: str, name: str) -> None:
    """Raise InputError unless the setting's robots have a number of this name in their memory."""
    if name not in (known := memory_names(setting)):
        meant = did_you_mean(name[:40], known)
        raise InputError.at(key, name[:40], f"{meant}should be one of {', '.join(known)[:400]}")


def _check_robots(values: Mapping[str, Any], robots: int) -> None:
    """Raise InputError for values with which a network would be made that is too large to be watched."""
    robots, made = values.get("robots", robots), "networkx" in str(values.get("topology"))
    if isinstance(robots, int) and robots > (most := MOST_CONNECTED if made else MOST_ROBOTS):
        of_them = f"robots{' on a network of networkx' * made}"
        raise InputError.at("robots", robots, f"at most {most:,} {of_them} can be watched")


def _check(setting: Setting, rounds: int) -> None:
    """Raise InputError for a setting that is too large to be watched."""
    _check_robots({}, setting.robots)
    if rounds > MOST_ROUNDS:
        raise InputError.at("rounds", rounds, f"at most {MOST_ROUNDS:,} can be watched")
    if setting.body is not None:
        if setting.arena_side > MOST_TILES * setting.body.tile:
            wide = f"the arena is more than {MOST_TILES:,} tiles wide"
            raise InputError.at("density", f"{setting.density:g}", wide)
    elif setting.robots > MOST_CONNECTED and not setting.additive and setting.topology.is_full:
        full = f"at most {MOST_CONNECTED:,} fully connected ones can be watched"
        raise InputError.at("robots", setting.robots, full)


def choices_of(offer: Offer) -> dict[str, dict[str, str]]:
    """Values that a page offers, by key, each with what it is called."""
    own = {to_text(brain.form): label for label, brain in offer.brains.items()}
    of_brains = own | {name: name for name in brains.PLUGINS.names if name not in own}
    topologies = {topology_text(topology): topology.title for topology in offer.topologies}
    floors = [floor for study in offer.studies for grid in study.grids for floor in grid.world.floor or ()]
    liars = [liar.name for study in offer.studies for liar in study.adversaries]
    return {
        "brain": of_brains,
        "beside": {"": "(none)"} | of_brains,
        "topology": topologies | {kind: kind for kind in wiring.PLUGINS.shipped},
        "floor": {to_text(floor.form): floor.title for floor in floors} | FLOORS,
        "adversary": {to_text(name): name for name in (*liars, *brains.adversary.PLUGINS.names)},
    }


def topology_text(topology: Topology) -> str:
    """A topology as a request names it: a list of edges by its name."""
    return topology.name if topology.edges and not topology.source else to_text(topology.form)


def _whole(request: Mapping[str, str], key: str, usual: int, least: int, most: int) -> int:
    text = request.get(key, "")
    if text == "":
        return usual
    if not re.fullmatch(r"\d{1,19}", text, re.ASCII) or not least <= int(text) <= most:
        raise InputError.at(key, text[:40], f"should be a whole number from {least:,} to {most:,}")
    return int(text)
