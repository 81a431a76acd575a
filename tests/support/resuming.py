"""A study that is cut off while it runs."""

from pathlib import Path

import pytest

import swarmcensus as sc
from swarmcensus.results import shards
from swarmcensus.runs.running import run

STUDY = """
name = "resumed"
seed = 7
trials = 6
swarm = {robots = [3, 20], accuracy = [0.7, "U(0.525, 0.975)"]}
world = {topology = ["full", "ring", "moving"], density = 1, fill_ratio = [0.55, 0.95]}
schedule = {rounds = 60, ticks = 200}
measure = {checkpoints = [10, 60], local = false}
"""
# fixed networks alone: quicker, and some things are of them alone
FIXED = STUDY.replace(', "moving"', "").replace("density = 1, ", "").replace(", ticks = 200", "")


def study(text=STUDY, **changes):
    return sc.Study.parse(text).with_(**changes)


class Cut(BaseException):
    """Stands for whatever ends a process; shards of what was finished are written before it is raised."""


def cut_off(out, after, text=STUDY):
    """Run a study until so many trials are done, and leave its shards as a killed process would."""
    written = []
    flush = shards.Parts.flush

    def die(progress):
        if progress.done >= after:
            raise Cut

    def keep(self):
        flush(self)
        written.append(self)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shards, "AT_LEAST", 0.0)
        patch.setattr(shards, "OF_ELAPSED", 0.0)
        patch.setattr(shards.Parts, "flush", keep)
        with pytest.raises(Cut):
            run(study(text), 1, die, out=out)
    found = shards.shard_files(shards.folder_of(Path(out)))
    assert found
    return found
