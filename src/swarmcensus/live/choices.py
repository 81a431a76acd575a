"""What a page may show: the settings of a study or of results, with some of their values changed.

A page chooses brains, floors and adversaries by name. It can read no files, except those that the server was given.
"""

import math
import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmcensus import brains
from swarmcensus.brains import Adversary, adversary
from swarmcensus.checks import caution
from swarmcensus.live.brain_files import BrainFiles
from swarmcensus.live.robots import memory_names
from swarmcensus.live.simulated import Simulated
from swarmcensus.simulation import warn_of_connections
from swarmcensus.studies import KEYS as DECLARED, Member, Members, Setting, Study, addresses, check, warn_of_needs
from swarmcensus.support.errors import InputError
from swarmcensus.support.files import check_no_log
from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import option
from swarmcensus.support.toml_text import read_toml
from swarmcensus.worlds import Body, Floor, Topology, arena, networks, patterns, sensors, wiring

if TYPE_CHECKING:  # imported late: without it the page of a study appears half a second sooner
    import xarray as xr

    from swarmcensus.live.logged import Logged
    from swarmcensus.live.recordings import LoggedRecording

MOST_ROBOTS, MOST_ROUNDS = 20_000, 1_000_000
MOST_TILES = 1_000_000  # along a side of the arena
MOST_PAIRS = 4_000_000  # of robots in a fully connected network
SHOWN: dict[str, Any] = {
    "swarm": {"brain": "minimalistic", "robots": 25, "accuracy": 0.75},
    "world": {"topology": "moving", "density": 1.0, "fill_ratio": 0.75},
    "schedule": {"ticks": 10_000},
}  # the swarm that is shown without a study
FLOORS = ("tiles", "half", {"clusters": 0.3}, {"stripes": 0.5})
LIAR = "always-black"
KEYS = (
    "setting", "trial", "seed", "brain", "beside", "robots", "accuracy", "fill_ratio", "topology", "density",
    "link_success", "floor", "liars", "adversary", "rounds", "of",
)  # fmt: skip
ON_A_RECORDING = ("beside", "of")  # keys that may be chosen for a recording in logs
BESIDE = "beside."  # before the name of a parameter of the second brain
PLAYED = (
    "tick", "robot", "side", "plot", "colour", "zoom", "centre", "follow", "log", "full", "speed",
)  # fmt: skip  # what concerns the view
COLOURINGS = ("off", "belief", "error")  # the signed error, the estimate, the absolute error
MOST_ZOOM = 40
CENTRE = re.compile(r"(0(\.\d+)?|1(\.0+)?),(0(\.\d+)?|1(\.0+)?)", re.ASCII)
AS_FAST_AS_POSSIBLE = "Infinity"  # a speed
Finder = Callable[[int], tuple[Study, Setting]]  # the setting of a number, and its study


@dataclass(frozen=True)
class Offer:
    """What can be watched: settings by number, and values that can replace theirs."""

    name: str
    numbers: tuple[int, ...]
    find: Finder
    topologies: dict[str, Topology]
    floors: dict[str, Floor]
    brains: dict[str, brains.Brain]  # those of the study, in addition to all installed ones
    adversaries: dict[str, Adversary]
    live: "Callable[[Setting, int, int], Simulated | Logged]" = Simulated  # a setting's trial, by seed and number
    logged: "LoggedRecording | None" = None  # where robots lived the trial: only a second brain can be chosen
    files: BrainFiles = field(default_factory=BrainFiles)  # the brains that are read again when they are saved


@dataclass(frozen=True)
class Wanted:
    """One trial to be watched, and optionally a second setting in the same world."""

    study: Study
    settings: tuple[Setting, ...]
    chosen: tuple[str, ...]  # the label of each setting's brain, without the parameters that were asked for
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

        logged = LoggedRecording(of, given)
        study, setting = logged.study, logged.setting
        offer = _offer(logged.recording.title, (0,), [study], logged.brains, lambda _: (study, setting))
        return replace(offer, live=logged.life, logged=logged)
    if isinstance(of, Path):
        check_no_log(of)
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
    return replace(offer, files=BrainFiles(offer.brains.values()))


def _offer(
    name: str, numbers: tuple[int, ...], studies: list[Study], more: Mapping[str, brains.Brain], find: Finder
) -> Offer:
    if not numbers:
        raise InputError(f"{name}: there is no setting to watch", key=name)
    grids = [grid for study in studies for grid in study.grids]
    caution((*(brain for study in studies for brain in study.brains), *more.values()))
    floors = [floor for grid in grids if grid.moves for floor in grid.world.floor or ()]
    plain = [networks.parse_topology(kind, None, {}) for kind in wiring.PLUGINS.shipped]
    usual = [patterns.parse_floors(floor, None, {})[0] for floor in FLOORS]
    named = [topology for study in studies for topology in study.topologies]
    return Offer(
        name=name,
        numbers=numbers,
        find=find,
        topologies={topology.title: topology for topology in (*named, *plain)},
        floors={floor.title: floor for floor in (*floors, *usual)},
        brains={brain.label: brain for grid in grids for brain in grid.swarm.brain} | dict(more),
        adversaries={liar.name: liar for study in studies for liar in study.adversaries},
    )


def wanted(offer: Offer, request: Mapping[str, str]) -> Wanted:
    """The trial that a request describes, key by key; other values are those of the setting. Raises InputError."""
    number = _whole(request, "setting", offer.numbers[0], 0, 2**31)
    if number not in offer.numbers:
        raise InputError.at("setting", number, f"there are {offer.numbers[0]} to {offer.numbers[-1]}")
    study, setting = offer.find(number)
    first, began = (offer.logged.recording.trial, offer.logged.recording.seed) if offer.logged else (0, study.seed)
    mark = addresses.fingerprint(setting, study.seed)[:8]
    if request.get("of", mark) != mark:
        raise InputError.at("of", request["of"][:40], f"this link is not for {offer.name} as it is now")
    trial = _whole(request, "trial", first, 0, 2**31 - 1)
    seed = _whole(request, "seed", began, 0, 2**63 - 1)
    was = {"setting": number, "trial": first, "seed": began}
    for key, value in request.items() if offer.logged else ():  # what robots have lived stays as it was
        if value and key not in ON_A_RECORDING and not key.startswith(BESIDE) and value != str(was.get(key, "")):
            raise InputError.at(key, value[:40], "this recording is as its logs have it: only beside can be chosen")
    brain = _brain(offer, "brain", request["brain"]) if request.get("brain") else offer.files.latest(setting.brain)
    chosen = [brain.label]
    ours = [key for key in request if key not in KEYS and not key.startswith(BESIDE)]
    lost = {key for key in ours if offer.files.has_lost(brain, key)}  # a page may still ask for these
    brain = _with_parameters(brain, {key: request[key] for key in ours if key not in lost})
    changed = _changed(offer, replace(setting, brain=brain.with_numbers(setting.brain.numbers)), request)
    rounds = offer.logged.rounds if offer.logged else changed.rounds
    _check(changed, study, rounds)
    settings = [changed]
    theirs = {key: value for key, value in request.items() if key.startswith(BESIDE)}
    if request.get("beside"):
        second = _brain(offer, "beside", request["beside"])
        chosen.append(second.label)
        lost |= {key for key in theirs if offer.files.has_lost(second, key.removeprefix(BESIDE))}
        second = _with_parameters(second, {key: theirs[key] for key in theirs if key not in lost}, BESIDE)
        settings.append(replace(changed, brain=second.with_numbers(changed.brain.numbers)))
        _check(settings[1], study, rounds)
    elif theirs:
        key = next(iter(theirs))[:40]
        raise InputError(f"{key}: no second brain is selected: name one with beside", key=key)
    given = {key: value for key, value in request.items() if value != "" and key not in lost}
    return Wanted(study, tuple(settings), tuple(chosen), seed, trial, given, rounds, mark)


def first_view(offer: Offer, asked: Mapping[str, str]) -> tuple[dict[str, str], dict[str, str]]:
    """What a page begins with, and how it is seen; next to a recording stands the first of the brains that were given.

    All that the page will ask for is tried, so that errors are raised here, and not in the browser. Raises InputError.
    """
    query = {key: value for key, value in asked.items() if key not in PLAYED}
    play = {key: value for key, value in asked.items() if key in PLAYED}
    if offer.logged and offer.logged.brains:
        query.setdefault("beside", next(iter(offer.logged.brains)))
    trial = wanted(offer, query)
    check_moment(trial, play)
    for setting in trial.settings if offer.logged else ():
        offer.logged.under(setting.brain)  # type: ignore[union-attr]
    return query, play


def check_moment(found: Wanted, played: Mapping[str, str]) -> None:
    """Raise InputError for a tick, robot, side or colouring that the page cannot show."""
    setting = found.settings[0]
    most = {"tick": found.rounds, "robot": setting.robots - 1, "side": len(found.settings) - 1}
    for key, last in (most | dict.fromkeys(("follow", "log", "full"), 1)).items():
        _whole(played, key, 0, 0, last)
    if "plot" in played:
        check_field(found.settings[int(played.get("side", 0))], "plot", played["plot"])
    if played.get("colour", COLOURINGS[0]) not in COLOURINGS:
        raise InputError.at("colour", played["colour"][:40], f"should be one of {', '.join(COLOURINGS)}")
    if "zoom" in played:
        _number(played, "zoom", 1.0, MOST_ZOOM)
    if played.get("speed", AS_FAST_AS_POSSIBLE) != AS_FAST_AS_POSSIBLE:
        _number(played, "speed", 1, 10_000)
    if "centre" in played and not CENTRE.fullmatch(played["centre"]):
        raise InputError.at("centre", played["centre"][:40], "should be two numbers from 0 to 1, such as 0.25,0.5")


def check_field(setting: Setting, key: str, name: str) -> None:
    """Raise InputError unless the setting's robots have a number of this name in their memory."""
    if name not in (known := memory_names(setting)):
        meant = did_you_mean(name[:40], known)
        raise InputError.at(key, name[:40], f"{meant}should be one of {', '.join(known)[:400]}")


def _changed(offer: Offer, setting: Setting, request: Mapping[str, str]) -> Setting:
    request = {key: value for key, value in request.items() if value != ""}
    values: dict[str, Any] = {}
    if "topology" in request:
        values["topology"] = _one_of(offer.topologies, "topology", request["topology"])
    moves = values.get("topology", setting.topology).moves
    if moves != (setting.body is not None):
        values |= {key.field: key.default for key in DECLARED.values() if key.spans and key.world != "any"}
        values |= {"body": None, "rounds": DECLARED["rounds"].default}
    if moves and setting.body is None:
        values |= {"body": Body(), "density": 1.0, "floor": Floor(), "observations_per_round": 1}
        values["rounds"] = DECLARED["ticks"].default
    values["robots"] = _whole(request, "robots", setting.robots, 1, MOST_ROBOTS)
    values["rounds"] = _whole(request, "rounds", values.get("rounds", setting.rounds), 1, MOST_ROUNDS)
    if "accuracy" in request:
        try:
            values["accuracy"] = sensors.parse_accuracy(_toml(request["accuracy"]))
        except ValueError as error:
            raise InputError.at("accuracy", request["accuracy"][:40], f"{str(error)[:200]}") from None
    if "fill_ratio" in request:
        values |= {"fill_ratio": _number(request, "fill_ratio", 0.0, 1.0), "change": None, "spread": None}
    for key in ("density", "floor"):
        if key in request and not moves:
            raise InputError.at(key, request[key][:40], "only for robots that move, not on this network")
    for key, most in (("link_success", 1.0), ("density", 1e6)):
        if key in request:
            values[key] = _number(request, key, 0.0, most)
    if "floor" in request:
        values["floor"] = _one_of(offer.floors, "floor", request["floor"])
    if "liars" in request or "adversary" in request:
        liars, robots = [member for member in setting.members if not member.honest], values["robots"]
        now = sum(liar.count(robots) for liar in liars) / robots
        share = _number(request, "liars", 0.0, 1.0) if "liars" in request else now
        known = (member.brain for member in liars if isinstance(member.brain, Adversary))
        liar = next(known, None)
        if name := request.get("adversary"):
            if name not in offer.adversaries and name not in adversary.PLUGINS:
                meant = did_you_mean(name[:40], adversary.PLUGINS.names)
                raise InputError.at("adversary", name[:40], f"{meant}there is no such adversary")
            liar = offer.adversaries.get(name) or adversary.load(name, Path(os.devnull))
        lying = Member(share, liar or adversary.load(LIAR), honest=False, share=True)
        others = tuple(member for member in setting.members if member.honest)
        values["members"] = (*others, *([lying] if lying.count(robots) else []))
    return replace(setting, **values)


def _check(setting: Setting, study: Study, rounds: int) -> None:
    """Raise InputError if values do not go together, or are too large to be watched."""
    try:
        if setting.robots > MOST_ROBOTS or rounds > MOST_ROUNDS:
            most = f"at most {MOST_ROBOTS:,} robots for {MOST_ROUNDS:,} rounds can be watched"
            key = "robots" if setting.robots > MOST_ROBOTS else "rounds"
            raise InputError(f"{setting.robots:,} robots for {rounds:,} rounds: {most}", key=key)
        setting.topology.check(setting.robots)
        if setting.body is not None:
            assert setting.density is not None
            density, densest = f"{setting.density:g}", arena.largest_density(setting.robots, setting.body)
            if not 0.0 < setting.density <= densest:
                raise InputError.at("density", density, f"should be above 0 and at most {densest:.4g} here")
            if setting.arena_side > MOST_TILES * setting.body.tile:
                raise InputError.at("density", density, f"the arena is more than {MOST_TILES:,} tiles wide")
            (setting.floor or Floor()).check(arena.Arena(setting.arena_side, setting.body.tile))
        elif setting.robots**2 > MOST_PAIRS and not setting.additive and setting.topology.name == "full":
            full = f"{counted(setting.robots, 'robot')} fully connected"
            raise InputError(f"{full}: at most {MOST_PAIRS**0.5:,.0f} can be watched", key="robots")
        for member in setting.members:
            role = {"brain": [member.brain]} if member.brain else {"accuracy": [member.accuracy]}
            table = dict.fromkeys(Members.model_fields) | {"robots": [member.robots], "honest": member.honest} | role
            tables = (Members.model_construct(None, **table),)
            check(tables, [setting.brain], [setting.robots], setting.body is not None)
    except ValueError as error:
        raise error if isinstance(error, InputError) else InputError(str(error)) from None


def _brain(offer: Offer, key: str, name: str) -> brains.Brain:
    """A brain of the study, or an installed one, but never a file."""
    if name not in offer.brains and name not in brains.PLUGINS:
        meant = did_you_mean(name[:40], names_of(offer))
        raise InputError.at(
            key, name[:40], f"{meant}this is no brain of the study, nor an installed one; {option('brain')} adds a file"
        )
    found = offer.brains[name] if name in offer.brains else brains.load(name, Path(os.devnull))
    return offer.files.latest(found)


def _with_parameters(brain: brains.Brain, request: Mapping[str, str], before: str = "") -> brains.Brain:
    """A brain with the parameters that a request names, with `before` before each name. Raises InputError."""
    for key, text in request.items():
        name = key.removeprefix(before)
        if name not in brain.parameters:
            known = (*KEYS, *(before + one for one in brain.parameters), *PLAYED)
            known_here = f"{did_you_mean(key[:40], known)}known here: {', '.join(known)}"
            raise InputError(f"{key[:40]}: {known_here}", key=key[:40])
        if text == "":
            continue
        try:
            brain = brain.with_parameters({name: _toml(text)})
        except ValueError as error:
            why = str(error)[:200]
            said = why if why.startswith(f"{name} = ") else f"{name} = {text[:40]}: {why}"
            raise InputError(before + said, key=key, value=text[:40]) from None
    return brain


def names_of(offer: Offer) -> list[str]:
    """The names of all brains that can be watched."""
    return list(dict.fromkeys([*offer.brains, *brains.PLUGINS.names]))


def _one_of(known: Mapping[str, Any], key: str, name: str) -> Any:
    if name not in known:
        raise InputError.at(key, name[:40], f"{did_you_mean(name[:40], known)}should be one of {', '.join(known)}")
    return known[name]


def _whole(request: Mapping[str, str], key: str, usual: int, least: int, most: int) -> int:
    text = request.get(key, "")
    if text == "":
        return usual
    if not re.fullmatch(r"\d{1,19}", text, re.ASCII) or not least <= int(text) <= most:
        raise InputError.at(key, text[:40], f"should be a whole number from {least:,} to {most:,}")
    return int(text)


def _toml(text: str) -> Any:
    """A value as in a study file: TOML's, or else the text. Raises ValueError for several lines."""
    if "\n" in text:
        raise ValueError("should be one value, on one line")
    try:
        return read_toml(f"it = {text}", "")["it"]
    except InputError:
        return text


def _number(request: Mapping[str, str], key: str, least: float, most: float) -> float:
    try:
        value = float(request[key])
    except ValueError:
        value = math.nan
    if not least <= value <= most:
        raise InputError.at(key, request[key][:40], f"should be a number from {least:g} to {most:g}")
    return value
