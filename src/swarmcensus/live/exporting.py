"""One recorded trial as an HTML file with all its frames, which opens from disk without a server."""

import base64
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from swarmcensus.brains import slots
from swarmcensus.live.about_trial import scene_of
from swarmcensus.live.choices import Offer, wanted
from swarmcensus.live.frames import Show
from swarmcensus.live.pages import recorded_page
from swarmcensus.live.sessions import form_of
from swarmcensus.live.settling import Settling
from swarmcensus.support.errors import InputError
from swarmcensus.support.files import atomic_write
from swarmcensus.support.formatting import counted

BLOCK = 500  # frames that are compressed together
MOST_FRAMES = 400_000_000  # bytes of frames, uncompressed
STATES = 1_200_000  # bytes of memories, compressed, unless fewer are asked for
STEPS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)  # rounds from one recorded memory to the next


def export(
    offer: Offer, query: dict[str, str], path: Path, played: Mapping[str, str] | None = None,
    report: Callable[[float], None] = lambda share: None,
) -> int:  # fmt: skip
    """Write a trial as an HTML file, as `page_of` makes it. Returns its size in bytes. Raises InputError."""
    text = page_of(offer, query, played, report)
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return len(text.encode())


def page_of(
    offer: Offer, query: Mapping[str, str], played: Mapping[str, str] | None = None,
    report: Callable[[float], None] = lambda share: None, memories: int = STATES,
) -> str:  # fmt: skip
    """The HTML of a trial, which opens as `played` says, and plays if that names no moment.

    Estimates, positions, readings and links are recorded in every round; memories in every round if they fit into
    `memories` bytes, else in every 2nd, 5th, ... (see STEPS). `report` gets the share that is done. Raises InputError
    if the trial is too large.
    """
    trial = wanted(offer, query)
    shows = [Show(offer.live(setting, trial.seed, trial.trial), trial.study.measure) for setting in trial.settings]
    rounds, robots = shows[0].rounds, shows[0].setting.robots
    if (rounds + 1) * robots * 8 * len(shows) > MOST_FRAMES:
        many = f"{counted(robots, 'robot')} for {counted(rounds, 'round')}"
        raise InputError(f"{many} are too many for one file: take fewer")
    frames, states, names, step = [], [], [], _step(shows[0], memories)
    for side, show in enumerate(shows):
        blocks, fields = [], []
        for first in range(0, rounds + 1, BLOCK):
            ticks = [*range(first, min(first + BLOCK, rounds + 1))]
            blocks.append(_packed(show.frames(ticks, side)))
            if recorded := [tick for tick in ticks if tick % step == 0]:
                fields.append(_states(show, recorded))
            report((side + ticks[-1] / rounds) / len(shows))
        frames.append(blocks)
        names.append(fields[0][0])
        states.append(_packed(_shuffled(np.concatenate([values for _, values in fields], axis=2))))
    settlings = [Settling(show) for show in shows]
    for one in settlings:
        while not one.on():
            pass
    return recorded_page({
        "scenes": [scene_of(show) for show in shows],  # of logs that grow, as they are now
        "form": form_of(offer, trial), "frames": frames, "states": states, "names": names, "step": step,
        "settled": [one.median() for one in settlings], "played": dict(played or {}),
    })  # fmt: skip


def _step(show: Show, most: int) -> int:
    """The step between recorded memories with which they fit into `most` bytes, estimated from the first rounds."""
    rounds = show.rounds
    sample = list(range(1, min(rounds, 200) + 1))
    size = len(zlib.compress(_shuffled(_states(show, sample)[1]), 6)) / len(sample) * (rounds + 1)
    return next((step for step in STEPS if size / step <= most), STEPS[-1])


def _states(show: Show, ticks: list[int]) -> tuple[list[str], np.ndarray]:
    """The memories of robots at these ticks: names of fields, and values (field, robot, tick)."""
    rows: list[np.ndarray] = []
    for tick in ticks:
        fields = show.trace.states(tick, tick + 1)
        rows.append(np.concatenate([values[0].reshape(values.shape[1], -1) for values in fields.values()], axis=1).T)
    names = slots({name: values.shape[2] if values.ndim > 2 else 0 for name, values in fields.items()})
    return names, np.stack(rows, axis=2).astype("<f4")


def _shuffled(values: np.ndarray) -> bytes:
    """The bytes of numbers, first all first bytes, then all second ones: similar bytes compress well."""
    return np.ascontiguousarray(values, "<f4").view(np.uint8).reshape(-1, 4).T.tobytes()


def _packed(content: bytes) -> str:
    return base64.b64encode(zlib.compress(content, 9)).decode()
