// Whole trials of small swarms in one launch: states in registers, messages in shared memory, a thread a robot.
//
// A block runs `together` trials. Robot i of the t-th of them is thread t * robots + i.

PART void tables(const Given &given, const Place &at, int64_t k) {
    if (given.sensors > 1 || at.i == 0) {
        renew(given, at.trial, at.i, k);
    }
}

KERNEL(trials) {
    const int64_t robots = given.robots, stride = given.together * robots, slots = given.delay + 2;
    number *outbox = (number *)SHARED;
    number *sums = outbox + slots * WIDTH * stride;  // before and after each robot
    number *parts = sums + (MODE == FULL ? 2 * WIDTH * stride : 0);
    const int64_t blocks = (robots + BLOCK_SIZE - 1) / BLOCK_SIZE;
    uint8_t *signals = (uint8_t *)(parts + (MODE == FULL ? 3 * WIDTH * blocks * given.together : 0));
    Kept<Robot> mine;
    Kept<Place> places;
    PHASE {
        Place &at = places[thread];
        const int64_t slot = thread / robots;
        at.i = thread % robots;
        at.trial = slot < given.together ? BLOCK * given.together + slot : given.trials;
        if (at.trial < given.trials) {
            at.group = group_of(given, at.trial, at.i);
            at.stride = stride;
            at.outbox = outbox + slot * robots;
            at.signals = signals + slot * robots;
            at.before = sums + slot * robots + at.i;
            at.after = at.before + WIDTH * stride;
            at.apart = stride;
            tables(given, at, 1);
            begin(mine[thread], given, at);
        }
    }
    BARRIER;
    for (int64_t k = 0; k <= given.rounds; k++) {
#if CHANGES
        PHASE {
            if (places[thread].trial < given.trials && k > 0 && k < given.rounds) {
                tables(given, places[thread], k + 1);
            }
        }
        BARRIER;
#endif
#if MODE == FULL
        if (k > given.delay) {
            const number *said = outbox + slot_of(given, k - given.delay) * WIDTH * stride;
            if (blocks > 1) {
                PHASE {
                    for (int64_t n = thread; n < given.together * blocks * WIDTH; n += THREADS) {
                        const int64_t w = n % WIDTH, block = n / WIDTH % blocks, slot = n / WIDTH / blocks;
                        const int64_t from = block * BLOCK_SIZE, to = from + BLOCK_SIZE;
                        parts[(slot * blocks + block) * 3 * WIDTH + w] =
                            sum_of(said + w * stride + slot * robots, from, to < robots ? to : robots);
                    }
                }
                BARRIER;
                PHASE {
                    for (int64_t n = thread; n < given.together * WIDTH; n += THREADS) {
                        chain(parts + n / WIDTH * blocks * 3 * WIDTH + n % WIDTH, blocks, 3 * WIDTH);
                    }
                }
                BARRIER;
            }
            PHASE {
                for (int64_t n = thread; n < given.together * blocks * WIDTH * 2; n += THREADS) {
                    const bool later = n % 2;
                    const int64_t w = n / 2 % WIDTH, block = n / 2 / WIDTH % blocks, slot = n / 2 / WIDTH / blocks;
                    const int64_t from = block * BLOCK_SIZE, to = from + BLOCK_SIZE < robots ? from + BLOCK_SIZE : robots;
                    const number *whole = parts + (slot * blocks + block) * 3 * WIDTH + w;
                    const number *heard = said + w * stride + slot * robots;
                    number *out = sums + (later * WIDTH + w) * stride + slot * robots;
                    if (later) {
                        sum_after(heard, out, from, to, blocks > 1 ? whole[2 * WIDTH] : 0);
                    } else {
                        sum_before(heard, out, from, to, blocks > 1 ? whole[WIDTH] : 0);
                    }
                }
            }
            BARRIER;
        }
#endif
        PHASE {
            if (places[thread].trial < given.trials) {
                pass(mine[thread], given, places[thread], k);
            }
        }
        BARRIER;
    }
    PHASE {
        if (places[thread].trial < given.trials) {
            finish(mine[thread], given, places[thread]);
        }
    }
}

// Local estimates, observation by observation: nobody hears anything. `rounds` counts observations.
KERNEL(alone) {
    PHASE {
        const int64_t n = BLOCK * THREADS + thread;
        if (n < given.trials * given.robots) {
            Place at = {};
            at.trial = n / given.robots, at.i = n % given.robots;
            at.group = group_of(given, at.trial, at.i);
            Robot me;
            begin(me, given, at);
            double blacks = 0.0;
            for (int64_t k = 1; k <= given.rounds; k++) {
                const int64_t left = given.looks - (k - 1) % given.looks, tick = (k - 1) / given.looks + 1;
                if (left == given.looks) {
#if CHANGES
                    if (tick > 1) {
                        renew(given, at.trial, at.i, tick);
                    }
#endif
                    blacks = blacks_of(given, at.trial, at.i, tick);
                }
                const int64_t trial = given.first + at.trial;
                const bool black = unit_of(word_for(given.order_key, trial, k, 0, at.i)) * (double)left < blacks;
                blacks -= black;
#if LUCKY
                const uint64_t *key = given.luck_key;
#endif
                if (works(given, at.trial, SENSING, at.i, tick) && !robot_done(me.brains, at.group)) {
#if LUCKY
                    robot_luck(me.brains, at.group, luck_of(word_for(key, trial, k, 3, at.i)));
#endif
                    robot_look(me.brains, at.group, black, 1.0);
                }
#if LUCKY
                robot_luck(me.brains, at.group, luck_of(word_for(key, trial, k, 4, at.i)));
#endif
                robot_fuse(me.brains, at.group);
                note_estimate(given, at, k, robot_estimate(me.brains, at.group));
            }
            note_state(me, given, at);
        }
    }
}
