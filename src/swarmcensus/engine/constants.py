"""Numbers that the engine's files share."""

import numpy as np

# how messages travel in a round: along listed links, from all to all as sums, or between all pairs one by one
LISTED, FULL, PAIRS = 0, 1, 2

# robots that end a round together: an even number, because pairs of robots share random words
BLOCK = 256
# blocks of a full network that do so: robots pass through the cache twice then, and a processor foresees only long runs
BLOCKS = 16
# rounds that a block goes through while it is in the cache, where its robots hear only those of blocks nearby
AHEAD = 8

# what is counted of a robot's messages
SENT, HEARD, CLIPPED = 0, 1, 2

# what a robot does in a round. Noise drowns all other messages that reach the same robot
SILENT, SAID, NOISE = 0, 1, 2

# the parts of a robot that may fail; no literals, for each of which Numba would compile what takes it
MOVING, SENSING, TALKING = np.arange(3)
PARTS = 3
NEVER = 1 << 62

TILE_ZERO = 1 << 30  # tiles are counted from the arena's centre, addresses from zero

# of the tables that readings are drawn by: a power of two, so that a word's top bits pick one without bias
COLUMNS = 16
PART = COLUMNS - 1  # the most observations that one word can stand for

ALL_PAIRS = 48  # robots up to which looking at every pair is quicker than a grid

# rows of robots' states: SPEED is in metres and TURN in radians a tick, with the cosine and sine of the part of
# it that comes before new wheel speeds take hold, and of the part after; PACE is the SPEED of going straight
X, Y, COS, SIN, SPEED, TURN, COS_LATE, SIN_LATE, COS_THEN, SIN_THEN, MOVE, LEFT_TICKS, AVOIDING, PACE = range(14)
STATE = 14

# what is compiled for each brain (`brain_calls.py`), and the index of each function's address in `Swarm.functions`
PHASES = ("sense", "hear", "hear_sums", "add_up", "hear_all", "end_round", "go_alone", "believe", "judge", "ask",
          "bound", "begin", "pass_on")  # fmt: skip
SENSE, HEAR, HEAR_SUMS, ADD_UP, HEAR_ALL, END_ROUND, GO_ALONE, BELIEVE, JUDGE, ASK, BOUND, BEGIN, PASS_ON = range(13)

# what is known of each robot's decision: the option, -1 for none; when it first decided and last changed it, infinity
# for never; when it was done, with which estimate, and whether it is; its first invalid decision, -1 for none, and when
DECISION, DECIDED_IN, CHANGED, DONE_IN, DONE_ESTIMATE, IS_DONE, WRONG, WRONG_IN = range(8)
VERDICTS = 8

SLACK = 1e-6  # by which rounding, in single precision too, may take an estimate out of [0, 1]

# measures of robots' intervals at a checkpoint: the share that holds the truth, and the mean width
COVERAGE, WIDTH = range(2)

# what a random word is for
DRAW_OBSERVE, DRAW_FUSE, DRAW_STEER, DRAW_ALONE, DRAW_ALONE_FUSE = range(5)

# what checks powers, in the source of a compiled brain: the result of one, and one as a whole
POWER, RAISED = "power_of_cpython", "raised_as_in_cpython"

# what of the engine is in `compiled_apart.py`, and the index of each function's address in `Swarm.helpers`
HELPERS = ("renew_tables", "count_ahead", "note_amiss", "note_wrong", "note_agreed", "note_width", "note_settled",
           "note_clipped", "fail_sensors", "draw_words", "count_signals", "hear_singly", "hear_pairs", "go_alone",
           "forget", "judge_block", "agree", "ask_intervals", "note_intervals", "fill_words")  # fmt: skip
(RENEW, COUNT_AHEAD, AMISS, FIRST_WRONG, AGREED, HALF_WIDTH, SETTLED, COUNT_CLIPPED, FAIL_SENSORS, DRAW_WORDS,
 COUNT_SIGNALS, HEAR_SINGLY, HEAR_PAIRS, ALL_ALONE, FORGET, JUDGE_BLOCK, AGREE, ASK_INTERVALS,
 INTERVALS, FILL_WORDS) = range(20)  # fmt: skip
