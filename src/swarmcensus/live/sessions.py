"""The protocol with one page: requests in JSON and their answers, independent of the transport.

Only what a page requests is computed, a piece at a time, so that a slow or closed page costs nothing.
"""

import json
import time
from collections.abc import Mapping
from typing import Any

from swarmcensus.brains import Brain, length
from swarmcensus.figures import colours_of_brains
from swarmcensus.live.choices import (
    BESIDE,
    KEYS,
    MOST_ROUNDS,
    Offer,
    Wanted,
    check_field,
    check_moment,
    choices_of,
    topology_text,
    wanted,
)
from swarmcensus.live.interpreted import needs_compiling
from swarmcensus.live.previews import Preview
from swarmcensus.live.settling import Settling
from swarmcensus.live.shown import Answer, Makes, Shown
from swarmcensus.studies import KEYS as OF_STUDIES, to_text, values_of
from swarmcensus.support.errors import InputError
from swarmcensus.support.toml_text import to_toml_value

MOST_FRAMES = 600  # in one answer
TRIED = 3.0  # the most seconds for which a new trial is tried before it is shown
ASIDE = 0.05  # the same for requests that a page does not wait for
LONGEST = 12  # numbers of a parameter that a page shows
MOST_TEXT = 16_384  # characters of a request
MOST_ERROR = 450  # characters of an error
ACTIONS = ("begin", "frames", "robot", "news", "memory", "settled")  # methods of a session
Spoken = bytes | str  # an answer as a socket carries it


class Session:
    """The session of one page."""

    def __init__(self, offer: Offer, interprets: bool = False) -> None:
        """Start without a trial; `interprets`: CPython shows the first one while it is compiled."""
        self.offer, self.interprets = offer, interprets
        self.shown: Shown | None = None
        self.trial: Wanted | None = None
        self.settling: tuple[Settling, ...] | None = None

    def answer(self, text: str | bytes) -> list[Answer]:
        """Answer a request; errors are answers too."""
        number: Any = None
        try:
            request = _read(text)
            number = request.get("id")
            do = request.get("do")
            if do not in ACTIONS:
                raise InputError.at("do", repr(str(do)[:40]), f"should be one of {', '.join(ACTIONS)}")
            parts = getattr(self, f"_{do}")(request)
            return [part if isinstance(part, bytes) else {"id": number, **part} for part in parts]
        except InputError as error:
            return [{"id": number, "error": str(error)[:MOST_ERROR], "key": error.key}]
        except Exception as error:  # report it to the page, which can continue
            return [_internal_error(number, error)]

    def _begin(self, request: Mapping[str, Any]) -> list[Answer]:
        trial = wanted(self.offer, _texts(request, "ask"))
        check_moment(trial, _texts({"view": {}, **request}, "view"))
        tick = _whole(request, "tick", 0, MOST_ROUNDS)

        # CPython shows a trial until machine code is ready only where the page has no other picture
        has_picture = self.shown is not None and self.shown.is_compiled
        waits = self.interprets and not has_picture and self.offer.logged is None and needs_compiling(trial.settings)
        shown = self._shown(trial, Preview if waits else self.offer.live)
        shown.approach(tick, TRIED)  # a brain that fails before this is refused: the page keeps its picture
        answer = {"scenes": shown.scenes(), "form": form_of(self.offer, trial)}
        self.shown, self.trial, self.settling = shown, trial, None
        return [answer]

    def _shown(self, trial: Wanted, make: Makes) -> Shown:
        return Shown(trial.settings, trial.seed, trial.trial, trial.study.measure, make)

    def _frames(self, request: Mapping[str, Any]) -> list[Answer]:
        shown, _ = self._current()
        return shown.frames(_ticks(request, shown.rounds))

    def _robot(self, request: Mapping[str, Any]) -> list[Answer]:
        shown, trial = self._current()
        side, robot = _side_and_robot(request, trial)
        return shown.robot(side, _whole(request, "tick", 0, shown.rounds), robot)

    def _memory(self, request: Mapping[str, Any]) -> list[Answer]:
        shown, trial = self._current()
        side, robot = _side_and_robot(request, trial)
        name = str(request.get("name"))
        check_field(trial.settings[side], "name", name)
        return shown.memory(side, robot, name, _ticks(request, shown.rounds))

    def _news(self, request: Mapping[str, Any]) -> list[Answer]:
        """What is new in growing logs since the version that the page knows."""
        recording = self.offer.logged
        if recording is None or self.trial is None:
            raise InputError.at("do", "'news'", "only of a recording in logs")
        return [recording.news(_whole(request, "since", 0, 2**53))]

    def _settled(self, request: Mapping[str, Any]) -> list[Answer]:
        """K of each side, or a note that it takes longer."""
        shown, trial = self._current()
        if not shown.is_compiled:
            return [{"going": True}]
        if self.settling is None:  # separate trials, so that the shown ones stay at their rounds
            self.settling = tuple(Settling(show) for show in self._shown(trial, self.offer.live).shows)
        began = time.monotonic()
        for one in self.settling:
            while not one.on():
                if time.monotonic() - began > ASIDE:
                    return [{"going": True}]
        return [{"settled": [one.median() for one in self.settling]}]

    def _current(self) -> tuple[Shown, Wanted]:
        """What the page shows, and what it asked for."""
        if self.shown is None or self.trial is None:
            raise InputError("no trial yet: send begin first")
        return self.shown, self.trial


def form_of(offer: Offer, trial: Wanted) -> dict[str, Any]:
    """The choices of a page's controls, and their current values."""
    setting = trial.settings[0]
    liars = [member for member in setting.members if not member.honest]
    lie = next((liar.brain for liar in liars if liar.brain), None)
    now = {key: _text(x) for key, x in values_of(setting).items() if x is not None and x == x}  # NaN is not known
    now |= {"brain": trial.chosen[0], "beside": "".join(trial.chosen[1:]), "topology": topology_text(setting.topology)}
    now |= {"setting": trial.request.get("setting", str(offer.numbers[0])), "trial": str(trial.trial)}
    now |= {"seed": str(trial.seed), "ticks" if setting.body else "rounds": str(trial.rounds)}
    now |= {"density": f"{setting.density:g}"} if setting.body else {}
    now["liars"] = f"{sum(member.count(setting.robots) for member in liars) / setting.robots:g}"
    now["adversary"] = to_text(lie.form) if lie else ""
    choices = {key: found for key, found in choices_of(offer).items() if key in now}
    for key in (one for one, found in choices.items() if now[one] not in found):
        choices[key] = {now[key]: now[key] or "(none)", **choices[key]}
    form = {"name": offer.name, "unit": "round" if setting.body is None else "tick", "mark": trial.mark}
    return form | {
        "now": now,
        "asked": trial.request,
        "choices": choices,
        "honest": [to_toml_value(member.form) for member in setting.members if member.honest],
        "bound": [key.name for key in OF_STUDIES.values() if key.world != "any"],
        "fixed": [*KEYS, *OF_STUDIES, "liars", "adversary"] if offer.logged else [],  # what cannot be changed
        "settings": [offer.numbers[0], offer.numbers[-1]],
        "trials": trial.study.trials,
        "parameters": [one for side, part in enumerate(trial.settings) for one in parameters(part.brain, side)],
        "colours": colours_of_brains([part.brain.label for part in trial.settings]),
        "grows": offer.logged is not None and offer.logged.may_grow,
    }


def _text(value: Any) -> str:
    """A value of a key as a control shows it."""
    return f"{value:g}" if isinstance(value, float) else to_text(getattr(value, "form", value))


def parameters(brain: Brain, side: int) -> list[dict[str, str]]:
    """The parameters that a page's fields can change, each with its key and its value."""
    before = BESIDE if side else "brain."
    return [
        {"key": f"{before}{name}", "name": name, "brain": brain.name, "now": to_toml_value(value)}
        for name, value in brain.parameters.items()
        if length(value) <= LONGEST
    ]


def spoken(answers: list[Answer]) -> list[Spoken]:
    """Answers as a socket sends them; one that cannot be written as JSON becomes an error for the page."""
    try:
        return [part if isinstance(part, bytes) else json.dumps(part, allow_nan=False) for part in answers]
    except (TypeError, ValueError) as error:
        number = next((part["id"] for part in answers if isinstance(part, dict)), None)
        return [json.dumps(_internal_error(number, error))]


def _internal_error(number: Any, error: Exception) -> dict[str, Any]:
    return {"id": number, "error": f"internal error: {type(error).__name__}: {str(error)[:200]}"}


def _read(text: str | bytes) -> dict[str, Any]:
    if isinstance(text, bytes) or len(text) > MOST_TEXT:
        raise InputError(f"a request should be JSON of at most {MOST_TEXT:,} characters")
    try:
        request = json.loads(text)
    except (ValueError, RecursionError):
        raise InputError("a request should be JSON") from None
    if not isinstance(request, dict):
        raise InputError("a request should be a JSON object")
    if not isinstance(request.get("id", 0), int):
        raise InputError("id: should be a whole number", key="id")
    return request


def _texts(request: Mapping[str, Any], key: str) -> dict[str, str]:
    value = request.get(key)
    if not isinstance(value, dict) or not all(isinstance(v, str) for pair in value.items() for v in pair):
        raise InputError(f"{key}: should be names and texts", key=key)
    return value


def _side_and_robot(request: Mapping[str, Any], trial: Wanted) -> tuple[int, int]:
    side = _whole(request, "side", 0, len(trial.settings) - 1)
    return side, _whole(request, "robot", 0, trial.settings[side].robots - 1)


def _ticks(request: Mapping[str, Any], last: int) -> range:
    first, step = _whole(request, "from", 0, last), _whole(request, "step", 1, last or 1)
    return range(first, last + 1, step)[: _whole(request, "count", 1, MOST_FRAMES)]


def _whole(request: Mapping[str, Any], key: str, least: int, most: int) -> int:
    value = request.get(key, least)
    if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
        raise InputError.at(key, str(value)[:40], f"should be a whole number from {least:,} to {most:,}")
    return value
