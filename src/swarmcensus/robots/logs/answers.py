"""What came of running robots' brains again, in words and rows, and whether it is so to the bit."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from swarmcensus.robots.logs.folders import Recording
from swarmcensus.robots.logs.foreign_logs import other_hashes, strangers_of
from swarmcensus.robots.logs.lives import LEAST_TICKS, Lost, RobotReplay, lost_in
from swarmcensus.simulation import correct
from swarmcensus.support.answers import Answer
from swarmcensus.support.formatting import counted

DIFFER = 1  # exit code if a state differs in any bit, a log is cut, absent or of another recording, or has no state
MOST = 16  # sentences on robots
NAMED = 8  # robots in a sentence


def answer_of(recording: Recording, lives: Sequence[RobotReplay]) -> Answer:
    """Whether robots were run again to the bit, and a row for each brain."""
    ticks, relived, unknown = (sum(getattr(one, name) for one in lives) for name in ("ticks", "relived", "unknown"))
    same, robots = sum(life.to_the_bit for life in lives), counted(len(lives), "robot")
    liars = sum(not member.honest for member in recording.members)
    who = robots + f", {liars} of them not honest" * (liars > 0)
    truth = "" if recording.fill_ratio is None else f", fill ratio {recording.fill_ratio:g}"
    strangers = strangers_of(recording, {life.number for life in lives if life.breaks})
    verdict = f"{same:,} of {robots} lived again to the bit, {relived:,} of {counted(ticks, 'tick')}"
    said = [(number, f": not of this recording: {why}") for number, why in strangers.items()]
    said += [
        (life.number, f", boot {one.boot}: differs at tick {one.tick} in {one.field}")
        for life in lives for one in life.breaks if life.number not in strangers
    ]  # fmt: skip
    files = [(one.number, f": {hashes}") for one in recording.members for hashes in other_hashes(one)]
    logs, lost = "its log" if len(lives) == 1 else "their logs", lost_in(recording)
    gaps = gaps_in(recording, lost)
    return Answer(
        title=f"{recording.title}: {who}, {counted(ticks, 'tick')} in {logs}{truth}",
        sentences=[
            verdict if ticks else "the logs hold no ticks: nothing to compare",
            *[f"{counted(unknown, 'tick')} not lived again: the memory before is not known"] * bool(unknown),
            *_grouped(said, len(lives)),
        ],
        cautions=[*gaps, *_grouped([] if strangers else files, len(lives))], rows=_rows(recording, lives),
        code=0 if not gaps and same == len(lives) and ticks and not strangers else DIFFER,
        fields={
            "recording": recording.title, "fill_ratio": recording.fill_ratio, "strangers": strangers,
            "robots": [
                {k: v for k, v in vars(one).items() if k != "lived"}
                | {"lost": lost[one.number], "to_the_bit": one.to_the_bit} for one in lives
            ],
        },
    )  # fmt: skip


def gaps_in(recording: Recording, lost_by_robot: Mapping[int, list[Lost]] | None = None) -> list[str]:
    """What a recording lacks: logs, its end, and parts of logs, which are those of `lost_in`."""
    found, about = [f"left out: {what}" for what in recording.absent], recording.about
    rounds, lived = about.get("rounds"), max(member.log.last.tick for member in recording.members)
    is_short = "result" not in about and isinstance(rounds, int) and lived + LEAST_TICKS < rounds
    if is_short or about.get("ended", 0) is None:
        found.append(f"the recording was not finished: its logs end at tick {lived:,}")
    lost = [
        (number, f", boot {one.boot}: {_ticks(one)} not in the log: {one.reason}")
        for number, parts in (lost_by_robot or lost_in(recording)).items() for one in parts
    ]  # fmt: skip
    return [*found, *_grouped(lost, len(recording.members))]


def _ticks(lost: Lost) -> str:
    first = lost.after + 1
    if lost.before == first + 1:
        return f"tick {first} is"
    return f"ticks {first} on are" if lost.before is None else f"ticks {first} to {lost.before - 1} are"


def _grouped(said: Sequence[tuple[int, str]], robots: int) -> Iterator[str]:
    """Each sentence once, with all robots that it is of."""
    of = defaultdict(set)
    for number, text in said:
        of[text].add(number)
    for text, numbers in [*of.items()][:MOST]:
        named = ", ".join(map(str, sorted(numbers)[:NAMED]))
        more = f" and {len(numbers) - NAMED:,} more" if len(numbers) > NAMED else ""
        several = f"all {robots:,} robots" if len(numbers) == robots else f"robots {named}{more}"
        yield (f"robot {named}" if len(numbers) == 1 else several) + text
    if len(of) > MOST:
        yield f"... and {len(of) - MOST:,} more"


def _rows(recording: Recording, lives: Sequence[RobotReplay]) -> list[dict[str, Any]]:
    """A row for each brain; the robots of one recording may have several."""
    honest, f = {member.number for member in recording.members if member.honest}, recording.fill_ratio
    kinds = recording.kinds if len(recording.kinds) > 1 else {recording.brain.label: [life.number for life in lives]}
    found = []
    for label, robots in kinds.items():
        lived = {life.number: list(life.lived.values()) for life in lives if life.number in robots}
        last = np.array([blocks[-1].estimate for number, blocks in lived.items() if blocks and number in honest])
        last = last[np.isfinite(last)]
        found.append({
            "brain": label, "mean_estimate": float(last.mean()) if last.size else None,
            "mean_error": float(np.abs(last - f).mean()) if f is not None and last.size else None,
            "right": float(correct(last, f, recording.bins)) if f is not None and last.size else None,
            "sent": sum(one.said is not None for blocks in lived.values() for one in blocks),
            "heard": sum(len(one.heard) for blocks in lived.values() for one in blocks),
        })  # fmt: skip
    return found
