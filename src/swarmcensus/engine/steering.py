"""Robots whose brains steer: bodies and minds live tick by tick together, for where one goes the other decides.

Compiled once on a machine, like all of the engine's loops.
"""

import numpy as np

from swarmcensus.engine.compiling import entry
from swarmcensus.engine.constants import PACE
from swarmcensus.engine.swarms import Swarm

from .riding import ask_all, live_on, room_of
from .walk import walk


@entry
def live(
    state, body, half, walk_key, trial, around, senders, wishes, floor, turns,
    minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest,
    memory, outbox, rows, b, w, drift, read_key, link_key, threshold, delay, everyone, kept, counts, verdicts, agreed,
    asked, stops, stop,
):  # fmt: skip
    """Live through as many ticks as `rows` has; a tile's colour is that of `floor` (row, column), 1 black.

    `turns` (row, column) is the tick from which a tile has the other colour, without rows where none ever has. `around`
    is what `walk` takes from anchors to following, `kept` the empty room of `ride` for what is recorded, `asked` what
    it takes from checkpoints to wrong.
    """
    swarm = Swarm(minds, bases, fields, named, blanks, runs, of_block, additive, flag, jams, luck_keys, honest)
    n = memory.shape[0]
    looked = np.zeros((1, n), np.bool_)
    black = np.zeros((1, n), np.bool_)
    tiles = np.zeros((1, n, 2), np.int32)
    heard = np.zeros(n + 1, np.int64)
    poses = np.zeros((0, n, 3))
    room = room_of(n, senders.size, outbox.shape[1])
    low, left = floor.shape[0] // 2, floor.shape[1] // 2
    for tick in range(1, rows.shape[0] + 1):
        walk(
            state, body, half, walk_key, trial, tick, looked, tiles, heard, senders, poses, *around, wishes, stops, stop
        )  # fmt: skip
        if stop[0] != 0:
            return
        for i in range(n):
            row, column = tiles[0, i, 1] + low, tiles[0, i, 0] + left
            black[0, i] = floor[row, column] != 0
            if turns.shape[0] > 0 and tick >= turns[row, column]:
                black[0, i] = not black[0, i]
        live_on(
            swarm, room, memory, outbox, rows, trial, tick, b, w, drift, read_key, link_key, threshold, delay, everyone,
            looked, black, heard, senders, *kept, counts, verdicts, agreed, *asked, stops, stop,
        )  # fmt: skip
        ask_all(swarm, room[0], memory, body, state[PACE], trial, tick, wishes)
