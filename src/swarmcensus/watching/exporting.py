"""One recorded trial in one file: the page, its parts and all frames, which opens from disk without a server."""

import base64
import zlib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import numpy as np

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.files import atomic_write
from swarmcensus.basics.formatting import counted
from swarmcensus.watching.offers import Offer, wanted
from swarmcensus.watching.pages import recorded_page
from swarmcensus.watching.scenes import scene_of
from swarmcensus.watching.sessions import form_of
from swarmcensus.watching.shows import Show

BLOCK = 500  # frames that are packed at a time
MOST_FRAMES = 400_000_000  # bytes, before they are packed
MINDS = 1_200_000  # bytes of what robots remember, packed
STEPS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)  # from one moment with memories to the next


def export(
    offer: Offer,
    asked: dict[str, str],
    path: Path,
    played: Mapping[str, str] | None = None,
    said: Callable[[float], None] = lambda share: None,
) -> int:
    """Write a trial as an HTML file that opens at the moment `played`, and return its size in bytes.

    Estimates, places, readings and links are of every round; what robots remember is of every round where there is
    room, else of every so many. `said` hears how much is done. Raises InputError where the trial is too large, or the
    file cannot be written.
    """
    found = wanted(offer, asked)
    shows = [Show(setting, found.seed, found.trial, found.study.measure) for setting in found.settings]
    rounds, robots = shows[0].setting.rounds, shows[0].setting.robots
    if (rounds + 1) * robots * 8 * len(shows) > MOST_FRAMES:
        raise InputError(
            f"{counted(robots, 'robot')} for {counted(rounds, 'round')} are too many for one file: fewer, or rounds=..."
        )
    frames, minds, names, step = [], [], [], _step(shows[0])
    for side, show in enumerate(shows):
        blocks, fields = [], []
        for ticks in _blocks(rounds):
            blocks.append(_packed(show.frames(ticks, side)))
            if kept := [tick for tick in ticks if tick % step == 0]:
                fields.append(_minds(show, kept))
            said((side + ticks[-1] / rounds) / len(shows))
        frames.append(blocks)
        names.append(fields[0][0])
        minds.append(_packed(_shuffled(np.concatenate([one for _, one in fields], axis=2))))
    recording = {
        "scenes": [scene_of(show) for show in shows],
        "form": form_of(offer, found),
        "frames": frames,
        "minds": minds,
        "names": names,
        "step": step,
        "played": dict(played or {}),
    }
    text = recorded_page(recording)
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return len(text.encode())


def _blocks(rounds: int) -> Iterator[list[int]]:
    for first in range(0, rounds + 1, BLOCK):
        yield list(range(first, min(first + BLOCK, rounds + 1)))


def _step(show: Show) -> int:
    """How many rounds from one moment with memories to the next, so that they find room: tried on the first rounds."""
    rounds = show.setting.rounds
    some = list(range(1, min(rounds, 200) + 1))
    size = len(zlib.compress(_shuffled(_minds(show, some)[1]), 6)) / len(some) * (rounds + 1)
    return next((step for step in STEPS if size / step <= MINDS), STEPS[-1])


def _minds(show: Show, ticks: list[int]) -> tuple[list[str], np.ndarray]:
    """What robots remember at these moments: the fields' names, and their values (field, robot, moment)."""
    names, rows = [], []
    for tick in ticks:
        stretch, row = show.find(tick)
        fields = show.fields(stretch, slice(row, row + 1))
        flat = {
            name if values.ndim == 2 else f"{name}[{k}]": values[0] if values.ndim == 2 else values[0][:, k]
            for name, values in fields.items()
            for k in range(1 if values.ndim == 2 else values.shape[2])
        }
        names = list(flat)
        rows.append(np.stack(list(flat.values())))
    return names, np.stack(rows, axis=2).astype("<f4")


def _shuffled(values: np.ndarray) -> bytes:
    """Numbers with all their first bytes first, then all second ones: alike bytes pack well."""
    return np.ascontiguousarray(values, "<f4").view(np.uint8).reshape(-1, 4).T.tobytes()


def _packed(content: bytes) -> str:
    return base64.b64encode(zlib.compress(content, 9)).decode()
