"""States on a fixed network, some rounds at a time: for viewers, who see each round's states and messages."""

import numpy as np

from swarmcensus.engine.calling import call, packed
from swarmcensus.engine.changes import source_with
from swarmcensus.engine.compiling import counting_nothing, entry
from swarmcensus.engine.constants import HEARD, RENEW, SENT, TALKING
from swarmcensus.engine.layout import States

from .compiled_apart import count_heard
from .failures import works
from .rounds import advance, graph_of
from .shared_trials import team_of
from .states import ZERO, believe_all, blank_states, copy_all, forget_verdicts, heard_by, judge_blank, sensors_of
from .trial_arguments import SOURCE


@entry
def start_states(swarm, given, states, tally):
    """Blank states of one trial, and in states.rows their estimates before any observation."""
    blank_states(swarm, states.memory, given.beliefs[0][0], given.beliefs[1][0])
    believe_all(swarm, states.memory, states.rows, ZERO)
    forget_verdicts(tally.verdicts, tally.agreed, 0, states.memory.shape[0])
    if tally.verdicts.shape[0] > 0:
        judge_blank(swarm, states.memory, states.rows, tally.verdicts)


@counting_nothing
def live(swarm, given, states, tally, first, history, said, signals, messages, stop, member, votes, work):
    """Run rounds of the only trial `given` from `first` on, as many as states.rows, which get the estimates.

    After each round its states go to `history` (round, robot, byte), the messages that were heard to `said` (round,
    robot, byte) and `signals` (round, robot), and the totals of messages sent and heard so far to `messages` (round,
    what). `tally` counts on from the round before `first`. The others are as in `simulate`.
    """
    memory, outbox, rows = states.memory, states.outbox, states.rows
    trial, radio, stops, counts, delay = given.first, given.radio, given.stops[0], tally.counts, given.radio.delay
    robots = memory.shape[0]
    graph = graph_of(given.links, 0, work.bounds)
    source = source_with(work.tables, work.stand, sensors_of(given.sensors, 0))
    team = team_of(member, swarm, votes, robots)
    for r in range(rows.shape[0]):
        k = first + r
        call(swarm.helpers[RENEW], packed(source, SOURCE), k, 0, robots)
        now = States(memory, outbox, states.signals, rows[r:])
        advance(swarm, now, work, source, graph, radio, tally, stops, trial, k, k + 1, stop, team)
        if stop[0] != 0:
            return
        copy_all(history[r], memory)
        here = (k + 2) % (delay + 2) * robots
        copy_all(said[r], outbox[here : here + robots])
        if swarm.is_signalled:
            copy_all(signals[r], states.signals[here : here + robots])
        else:
            for i in range(robots):
                counts[SENT, i] += works(stops, TALKING, i, k)
        if k > delay:
            count_heard(swarm, graph, radio, stops, 1, counts, 0, robots)
        messages[r, 0] = counts[SENT].sum()
        messages[r, 1] = counts[HEARD].sum()


@entry
def carried(radio, trial, tick, receivers, senders, out):
    """Set out[link] to 1 where a message gets through a link in a round, else to 0."""
    for e in range(receivers.size):
        to, by = np.int64(receivers[e]), np.int64(senders[e])
        out[e] = radio.threshold == 0 or heard_by(radio.key, trial, tick, to, by, radio.threshold)
