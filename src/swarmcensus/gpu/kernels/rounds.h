// What robots do in a round, to the bit as in engine/rounds.py and brain_calls.py.

// One robot: what its brain remembers (source.py writes `Brains`), and what is kept of it besides.
struct alignas(8) Robot {
    Brains brains;
#if FORMATS
    int64_t clipped;
#endif
#if COUNTED
    int64_t sent, heard;
#endif
#if JUDGED
    double decision, decided_in, changed, done_in, done_estimate;
#endif
};

// Where a robot of a trial stands, and where the messages of its trial are: word w of what robot j said in a round is
// outbox[(slot * WIDTH + w) * stride + j], and the slots take turns.
struct Place {
    int64_t trial, i, group, stride;
    number *outbox;
    uint8_t *signals;
    const number *before, *after;  // sums over the robots before it and after it, word w at w * apart
    int64_t apart;
    int64_t heard, said;  // slots: of what is heard in this round, and of what is said for the next
};

PART int64_t group_of(const Given &given, int64_t trial, int64_t i) {
    return GROUPS > 1 ? given.groups[trial * given.robots + i] : 0;
}

PART int64_t next_slot(const Given &given, int64_t slot) { return slot + 1 < given.delay + 2 ? slot + 1 : 0; }

// Whether what robot j did in a round that is heard now is noise.
PART bool is_noise(const Given &given, const Place &at, int64_t round, int64_t j) {
    return at.signals[at.heard * at.stride + j] == NOISE && works(given, at.trial, TALKING, j, round);
}

// The sender of a robot's n-th link: in a full network that is robot n.
PART int64_t sender_of(const Given &given, int64_t n) { return MODE == LISTED ? (int64_t)given.senders[n] : n; }

PART void read_message(const Place &at, int64_t j, number *message) {
    for (int32_t w = 0; w < WIDTH; w++) {
        message[w] = at.outbox[(at.heard * WIDTH + w) * at.stride + j];
    }
}

// Robot `at` hears what robot j said.
PART void hear_one(Robot &me, const Given &given, const Place &at, int64_t k, int64_t j, const number *message) {
#if SIGNALLED
    if (at.signals[at.heard * at.stride + j] != SAID) {
        return;
    }
#endif
#if !SOUND
    if (!works(given, at.trial, TALKING, j, k - given.delay)) {
        return;
    }
    if (given.threshold != 0 && word_of(given.losses_key, given.first + at.trial, k, at.i, j) >= given.threshold) {
        return;
    }
#endif
#if COUNTED
    me.heard++;
#endif
#if LUCKY
    robot_luck(me.brains, at.group, luck_of(word_of(given.luck_key + 2, given.first + at.trial, k, at.i, j)));
#endif
    robot_take(me.brains, at.group, message);
}

PART void hear(Robot &me, const Given &given, const Place &at, int64_t k) {
#if MODE == FULL
    robot_add_sums(me.brains, at.group, at.before, at.apart);
    robot_add_sums(me.brains, at.group, at.after, at.apart);
#if COUNTED && !SIGNALLED
    me.heard += given.robots - 1;
#elif COUNTED
    me.heard += given.said[at.trial * (given.rounds + 1) + k - given.delay];
    me.heard -= at.signals[at.heard * at.stride + at.i] == SAID;
#endif
#else
    const int64_t *bounds = given.bounds + (given.graphs > 1 ? at.trial * (given.robots + 1) : 0) + at.i;
    const int64_t first = MODE == LISTED ? bounds[0] : 0, end = MODE == LISTED ? bounds[1] : given.robots;
#if JAMS
    for (int64_t n = first; n < end; n++) {
        const int64_t j = sender_of(given, n);
        if (j != at.i && is_noise(given, at, k - given.delay, j)) {
            return;
        }
    }
#endif
#if ADDITIVE && SOUND
    number sums[WIDTH];
    robot_get_sums(me.brains, at.group, sums);
#endif
    // some messages are read before the first of them is taken: who has thousands of links would wait for each
    for (int64_t n = first; n < end; n += AHEAD) {
        number messages[AHEAD][WIDTH];
        for (int32_t m = 0; m < AHEAD; m++) {
            read_message(at, sender_of(given, n + m < end ? n + m : n), messages[m]);
        }
        for (int32_t m = 0; m < AHEAD && n + m < end; m++) {
            const int64_t j = sender_of(given, n + m);
            if (j == at.i) {
                continue;
            }
#if ADDITIVE && SOUND
            for (int32_t w = 0; w < WIDTH; w++) {
                sums[w] = sums[w] + messages[m][w];
            }
#if COUNTED
            me.heard += at.signals[at.heard * at.stride + j] == SAID;
#endif
#else
            hear_one(me, given, at, k, j, messages[m]);
#endif
        }
    }
#if ADDITIVE && SOUND
    robot_set_sums(me.brains, at.group, sums);
#endif
#endif
}

PART void note_estimate(const Given &given, const Place &at, int64_t k, double x) {
    given.rows[(at.trial * (given.rounds + 1) + k) * given.robots + at.i] = x;
    if (!(x >= -1e-6 && x <= 1.0 + 1e-6) && is_honest(given, at.trial, at.i)) {
        given.amiss[at.trial] = 1;
    }
}

#if JUDGED
PART void judge(Robot &me, const Given &given, const Place &at, int64_t k, double x) {
    const double now = (double)k, choice = k > 0 ? robot_decide(me.brains, at.group) : -1.0;
    if (!(-1.0 <= choice && choice < OPTIONS && choice == floor(choice))) {
        given.amiss[at.trial] = 1;
    } else if (choice != me.decision) {
        me.decided_in = me.decided_in < now ? me.decided_in : now;
        me.decision = choice;
        me.changed = now;
    }
    if (robot_done(me.brains, at.group) && me.done_in == INFINITY) {
        me.done_in = now;
        me.done_estimate = x;
    }
    if (k > 0) {
        given.decisions[(at.trial * given.rounds + k - 1) * given.robots + at.i] = (int16_t)me.decision;
    }
}
#endif

PART void bound(Robot &me, const Given &given, const Place &at, int64_t k) {
#if BOUNDED
    for (int64_t c = 0; c < given.checkpoints; c++) {
        if (given.rounds_of[c] == k) {
            double *ends = given.bounds_of + (c * given.trials + at.trial) * 2 * given.robots + at.i;
            robot_bound(me.brains, at.group, ends, ends + given.robots);
        }
    }
#endif
}

PART void begin(Robot &me, const Given &given, const Place &at) {
    const int64_t side = given.beliefs > 1 ? at.trial * given.beliefs + at.i : at.trial;
    robot_start(me.brains, at.group, given.blanks, at.i, given.assumed_b[side], given.assumed_w[side]);
#if FORMATS
    me.clipped = 0;
#endif
#if COUNTED
    me.sent = me.heard = 0;
#endif
    const double x = robot_estimate(me.brains, at.group);
    note_estimate(given, at, 0, x);
#if JUDGED
    me.decision = -1.0, me.decided_in = me.changed = me.done_in = INFINITY, me.done_estimate = NAN;
    judge(me, given, at, 0, x);
#endif
}

// End round k, if there is one, and observe and talk in the next.
PART void pass(Robot &me, const Given &given, const Place &at, int64_t k) {
    const int64_t number_of_trial = given.first + at.trial;
    if (k > 0) {
        if (k > given.delay) {
            hear(me, given, at, k);
        }
#if LUCKY
        robot_luck(me.brains, at.group, luck_of(word_for(given.luck_key, number_of_trial, k, 1, at.i)));
#endif
        robot_fuse(me.brains, at.group);
        const double x = robot_estimate(me.brains, at.group);
        note_estimate(given, at, k, x);
#if JUDGED
        judge(me, given, at, k, x);
#endif
        bound(me, given, at, k);
    }
    if (k < given.rounds) {
        const bool sees = works(given, at.trial, SENSING, at.i, k + 1);
        if (sees && !robot_done(me.brains, at.group)) {
#if LUCKY
            robot_luck(me.brains, at.group, luck_of(word_for(given.luck_key, number_of_trial, k + 1, 0, at.i)));
#endif
            robot_look(me.brains, at.group, blacks_of(given, at.trial, at.i, k + 1), (double)given.looks);
        }
        number message[WIDTH];
        #if FORMATS
        const int32_t signal = robot_say(me.brains, at.group, message, me.clipped);
#else
        int64_t none = 0;
        const int32_t signal = robot_say(me.brains, at.group, message, none);
#endif
        for (int32_t w = 0; w < WIDTH; w++) {
            at.outbox[(at.said * WIDTH + w) * at.stride + at.i] = message[w];
        }
#if SIGNALLED
        at.signals[at.said * at.stride + at.i] = (uint8_t)signal;
#if COUNTED && MODE == FULL
        add(given.said + at.trial * (given.rounds + 1) + k + 1, signal == SAID);
#endif
#endif
#if COUNTED
        me.sent += signal == SAID && works(given, at.trial, TALKING, at.i, k + 1);
#endif
    }
}

// What is left of a robot at the end of a trial.
PART void finish(Robot &me, const Given &given, const Place &at) {
    const int64_t n = at.trial * given.robots + at.i;
#if FORMATS
    given.clipped[n] = me.clipped;
#endif
#if COUNTED
    given.sent[n] = me.sent;
    given.heard[n] = me.heard;
#endif
#if JUDGED
    double *verdict = given.verdicts + 6 * n;
    verdict[0] = me.decision, verdict[1] = me.decided_in, verdict[2] = me.changed;
    verdict[3] = me.done_in, verdict[4] = me.done_estimate, verdict[5] = robot_done(me.brains, at.group);
#endif
}
