"""Trials of moving robots. Trajectories do not depend on the brain, so each is simulated once for several settings."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from swarmcensus.engine import NOT_RECORDED, Chunk, Inputs, Recorded, Tally, Work, compiler
from swarmcensus.simulation import sampling
from swarmcensus.simulation.blame import blaming, check_answers, check_commands
from swarmcensus.simulation.file_metrics import Truths, Watch, results_of
from swarmcensus.simulation.inputs import inputs_of
from swarmcensus.simulation.intervals import intervals_of, no_intervals
from swarmcensus.simulation.swarming import states_of, swarm_of, tally_of
from swarmcensus.simulation.trials import Batch, Metrics, batch_of, measures_of, work_of
from swarmcensus.simulation.walking import Walk
from swarmcensus.studies import Setting, addresses
from swarmcensus.support.bins import right_bins
from swarmcensus.worlds import Ground, tiles_across

MOST_TILES = 1 << 26  # of a floor that is painted whole, for robots that steer: 64 MB


class Walkers:
    """One setting's states on a walk, and the curves of their estimates."""

    def __init__(
        self, setting: Setting, given: Inputs, checkpoints: Sequence[int] = (), truths: Truths | None = None
    ) -> None:
        """Start the states of one trial; their intervals at checkpoints are compared with the `truths` there."""
        assert setting.body is not None
        self.setting, self.trial, self.given = setting, given.first, given
        self.kernel = compiler.compile_world("riding")
        self.start = np.empty((1, setting.robots))
        rounds = np.array(checkpoints, np.int64)
        self.intervals = no_intervals() if truths is None else intervals_of(setting, rounds, truths, 1)
        self.tally = tally_of(setting, 1).of_trial(0)
        rows = np.empty((setting.rounds, setting.robots))
        with blaming(setting, self.trial):
            self.swarm = swarm_of(setting, given, setting.use)
            self.states = states_of(setting, self.swarm, given.radio.delay + 1, rows)
            self.kernel.start_states(self.swarm, given, self.states, self.start, self.tally, self.room())

    def room(self, most: int = 0) -> Work:
        """Room to work in, for at most so many messages in a tick."""
        return work_of(self.swarm, self.given, self.states, local=True, most=most)

    def ride(self, chunk: Chunk, black: np.ndarray, stop: np.ndarray, recorded: Recorded = NOT_RECORDED) -> None:
        """Live through a chunk on tiles `black` (tick, robot)."""
        most = int(np.diff(chunk.heard[:: self.setting.robots]).max(initial=0))
        own = self.given, self.states, self.tally, self.intervals.of_trial(0)
        self.kernel.ride(self.swarm, *own, chunk, self.room(most), black, recorded, stop)

    def steer(self, commands: np.ndarray, tick: int) -> None:
        """Ask the states where they want to go after a tick, if they steer."""
        if commands.size:
            assert self.setting.body is not None
            body, speeds = self.setting.body.numbers, self.given.speeds[0]
            try:
                self.kernel.steer(self.swarm, self.states.memory, body, speeds, self.trial, tick, commands)
            except ValueError:
                check_commands(self.setting, self.given, commands)
                raise

    def measure(self, metrics: Metrics, ground: Ground) -> Batch:
        """The trial's metrics, as a batch of one."""
        truths = truths_of(self.setting, metrics, ground)
        honest = self.given.honest[0] if self.given.honest.size else slice(None)
        rows, tally = self.states.rows, Tally(*(counted[np.newaxis] for counted in self.tally))
        measures, checkpoints = measures_of(self.setting, 1, metrics), np.array(metrics.checkpoints, np.int64)
        found = measures.where[0], measures.value[0], measures.wrong[0], checkpoints, measures.disagreement[:, 0]
        measures.agreement[0] = self.kernel.conclude(self.swarm, rows, self.start, metrics.delta, self.room(), *found)
        check_answers(self.setting, self.given, measures.wrong, tally.verdicts, self.intervals)
        measures.final[0] = rows[-1]
        bins = right_bins(truths(checkpoints), metrics.bins)
        for c in np.flatnonzero(checkpoints <= len(rows)):
            row = rows[checkpoints[c] - 1]
            measures.correct[c, 0] = np.mean((row[honest] >= bins[c, 0]) & (row[honest] < bins[c, 1]))
            if metrics.estimates:
                measures.kept[c, 0] = row
        watches = [Watch(m, self.setting, self.trial, truths, metrics.delta, metrics.bins) for m in metrics.watched]
        for watch in watches:
            watch.see(np.ascontiguousarray(rows[:, honest]), 1)
        sure, truth = self.intervals.sure.transpose(1, 2, 0), float(truths(self.setting.rounds))
        batch = batch_of(self.setting, self.given, metrics, measures, tally, sure, truth)
        return replace(batch, true_fill_ratio=np.array([ground.true_fill_ratio]), watched=results_of(watches))


def truths_of(setting: Setting, metrics: Metrics, ground: Ground) -> Truths:
    """The fill ratio that errors refer to after some ticks: that of the painted floor, or the nominal one."""
    return ground.truth if metrics.on_floor else setting.fill_ratios


def run_ride(
    settings: Sequence[Setting], seed: int, trial: int, metrics: Metrics, stop: np.ndarray
) -> list[Batch] | None:
    """One trial of settings that share a walk; None if `stop` was set meanwhile."""
    settings = [addresses.in_trial(setting, seed, trial) for setting in settings]
    if settings[0].steers and tiles_of(settings[0]) ** 2 <= MOST_TILES:
        batch = steered(settings[0], seed, trial, metrics, stop)  # no other setting has the same walk
        return None if batch is None else [batch]
    keys = [(addresses.floor_key(setting, seed).tobytes(), setting.change) for setting in settings]
    by_key = dict(zip(keys, settings, strict=True))
    grounds = {key: sampling.ground(setting, seed, trial) for key, setting in by_key.items()}
    all_walkers = []
    for setting, key in zip(settings, keys, strict=True):
        truths = truths_of(setting, metrics, grounds[key])
        all_walkers.append(Walkers(setting, inputs_of(setting, seed, trial), metrics.checkpoints, truths))
    commands = commands_of(settings[0])
    for chunk in walk_of(settings[0], all_walkers[0].given, stop, commands).chunks(settings[0].rounds):
        black = {key: ground.colours(chunk.tiles, chunk.tick) for key, ground in grounds.items()}
        for walkers, key in zip(all_walkers, keys, strict=True):
            with blaming(walkers.setting, trial):
                walkers.ride(chunk, black[key], stop)
                walkers.steer(commands, chunk.tick)
    if stop[0]:
        return None
    return [walkers.measure(metrics, grounds[key]) for walkers, key in zip(all_walkers, keys, strict=True)]


def prepare(setting: Setting, seed: int, aside: bool) -> None:
    """Compile half of what a setting's trials need: the loop, or with `aside` what another process may compile."""
    moves = setting.body is not None
    if not aside:
        compiler.compile_loop("riding.ride" if moves else "kernel.simulate")
    given = inputs_of(setting, seed, 0)
    if aside != moves:  # brains and measuring
        swarm_of(setting, given, setting.use)
    if aside and moves:
        compiler.compile_loop("riding.start_states")
        compiler.compile_loop("riding.conclude")
        for chunk in walk_of(setting, given, np.zeros(1, np.uint8), commands_of(setting)).chunks(1):
            sampling.ground(setting, seed, 0).colours(chunk.tiles, chunk.tick)


def tiles_of(setting: Setting) -> int:
    """How many tiles the arena has from wall to wall."""
    assert setting.body is not None
    return tiles_across(setting.arena_side, setting.body.tile)


def steered(setting: Setting, seed: int, trial: int, metrics: Metrics, stop: np.ndarray) -> Batch | None:
    """One trial of robots whose brain steers, on a floor that is small enough to be painted beforehand."""
    assert setting.body is not None
    given, ground = inputs_of(setting, seed, trial), sampling.ground(setting, seed, trial)
    walkers = Walkers(setting, given, metrics.checkpoints, truths_of(setting, metrics, ground))
    commands = commands_of(setting)
    walk = walk_of(setting, given, stop, commands)
    with blaming(setting, trial):
        try:
            robots = walkers.swarm, given, walkers.states, walkers.tally, walkers.intervals.of_trial(0)
            bodies, floor = (walk.bodies, walk.neighbours), (ground.all_tiles(), ground.turns())
            room = walkers.room(2 * walk.neighbours.ears.size), walk.room_for(0, 1), NOT_RECORDED
            compiler.compile_world("steering").live(*robots, *bodies, *floor, *room, stop)
        except ValueError:
            check_commands(setting, given, commands)
            raise
    return None if stop[0] else walkers.measure(metrics, ground)


def commands_of(setting: Setting) -> np.ndarray:
    """Room for where robots want to go (3, robot), none yet; empty where their brain does not steer."""
    return np.zeros((3, setting.robots if setting.steers else 0))


def walk_of(setting: Setting, given: Inputs, stop: np.ndarray, commands: np.ndarray, poses: bool = False) -> Walk:
    """The walk of a setting's trial; `commands` may change from tick to tick."""
    assert setting.body is not None
    swarm = setting.robots, setting.arena_side, setting.fastest_body
    return Walk(*swarm, given.walk, given.first, stop, poses, given.stops[0], commands, given.speeds[0])


def senders_heard(setting: Setting, seed: int, trial: int) -> np.ndarray:
    """How many robots each one hears (tick, robot) on a walk that no brain steers."""
    given, stop = inputs_of(setting, seed, trial), np.zeros(1, np.uint8)
    chunks = walk_of(setting, given, stop, commands_of(setting)).chunks(setting.rounds)
    return np.concatenate([np.diff(chunk.heard).reshape(-1, setting.robots) for chunk in chunks])


def links_of(chunk: Chunk) -> np.ndarray:
    """The links of a chunk, each once: rows of tick, robot, robot, the lower robot first."""
    ticks, robots = chunk.looked.shape
    place = np.repeat(np.arange(ticks * robots), np.diff(chunk.heard))
    tick, receiver = chunk.tick + place // robots, place % robots
    sender = chunk.senders[: len(place)]
    once = receiver < sender
    return np.stack([tick[once], receiver[once], sender[once]], axis=1)
