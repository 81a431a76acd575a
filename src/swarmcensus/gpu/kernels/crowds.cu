// Large swarms: one launch a round, a thread a robot. States and messages lie in memory word by word, so that threads
// next to each other read what lies next to each other.

#define WORDS ((int32_t)(sizeof(Robot) / 8))

PART void load(const Given &given, const Place &at, Robot &me) {
    const uint64_t *kept = given.memory + at.trial * WORDS * given.robots + at.i;
    BRAIN_UNROLLED for (int32_t w = 0; w < WORDS; w++) {
        memcpy((char *)&me + 8 * w, kept + w * given.robots, 8);
    }
}

PART void store(const Given &given, const Place &at, const Robot &me) {
    uint64_t *kept = given.memory + at.trial * WORDS * given.robots + at.i;
    BRAIN_UNROLLED for (int32_t w = 0; w < WORDS; w++) {
        memcpy(kept + w * given.robots, (const char *)&me + 8 * w, 8);
    }
}

PART Place place_of(const Given &given, int64_t trial, int64_t i) {
    Place at = {};
    at.trial = trial, at.i = i, at.stride = given.robots;
    at.group = group_of(given, trial, i);
    at.outbox = given.outbox + trial * (given.delay + 2) * WIDTH * given.robots;
    at.signals = given.signals + trial * (given.delay + 2) * given.robots;
    at.said = given.k % (given.delay + 2);
    at.heard = next_slot(given, at.said);
    return at;
}

#define BLOCKS ((given.robots + BLOCK_SIZE - 1) / BLOCK_SIZE)

// Full networks: what each block of robots says is added up, then the blocks, then what is before and after each robot.

PART const number *said_in(const Given &given, int64_t trial) {
    const Place at = place_of(given, trial, 0);
    return at.outbox + at.heard * WIDTH * given.robots;
}

KERNEL(sums) {
    PHASE {
        const number *said = said_in(given, BLOCK / BLOCKS);
        const int64_t from = BLOCK % BLOCKS * BLOCK_SIZE, to = from + BLOCK_SIZE;
        for (int64_t w = thread; w < WIDTH; w += THREADS) {
            given.parts[BLOCK * 3 * WIDTH + w] =
                sum_of(said + w * given.robots, from, to < given.robots ? to : given.robots);
        }
    }
}

// One thread adds up a word of all blocks in their order; all threads bring them to shared memory, some at a time.
KERNEL(chains) {
    number *parts = given.parts + BLOCK * BLOCKS * 3 * WIDTH, *sums = (number *)SHARED, *some = sums + WIDTH;
    const int64_t most = MOST_STAGED / WIDTH;
    for (int32_t way = 1; way <= 2; way++) {  // before each block, then after it
        PHASE {
            for (int64_t w = thread; w < WIDTH; w += THREADS) {
                sums[w] = 0;
            }
        }
        BARRIER;
        for (int64_t done = 0; done < BLOCKS; done += most) {
            const int64_t count = BLOCKS - done < most ? BLOCKS - done : most;
            number *first = parts + (way == 1 ? done : BLOCKS - done - count) * 3 * WIDTH;
            PHASE {
                for (int64_t n = thread; n < count * WIDTH; n += THREADS) {
                    some[n] = first[n / WIDTH * 3 * WIDTH + n % WIDTH];
                }
            }
            BARRIER;
            PHASE {
                for (int64_t w = thread; w < WIDTH; w += THREADS) {
                    number sum = sums[w];
                    for (int64_t n = 0; n < count; n++) {
                        const int64_t at = (way == 1 ? n : count - 1 - n) * WIDTH + w;
                        const number part = some[at];
                        some[at] = sum;
                        sum = sum + part;
                    }
                    sums[w] = sum;
                }
            }
            BARRIER;
            PHASE {
                for (int64_t n = thread; n < count * WIDTH; n += THREADS) {
                    first[(n / WIDTH * 3 + way) * WIDTH + n % WIDTH] = some[n];
                }
            }
            BARRIER;
        }
    }
}

KERNEL(around) {
    PHASE {
        const int64_t trial = BLOCK / BLOCKS, from = BLOCK % BLOCKS * BLOCK_SIZE, end = from + BLOCK_SIZE;
        const int64_t to = end < given.robots ? end : given.robots;
        const number *said = said_in(given, trial), *whole = given.parts + BLOCK * 3 * WIDTH;
        number *sums = given.around + trial * 2 * WIDTH * given.robots;
        const bool later = thread / 32 % 2;  // threads of a warp go the same way
        for (int64_t w = thread / 64 * 32 + thread % 32; w < WIDTH; w += THREADS / 2) {
            if (later) {
                sum_after(said + w * given.robots, sums + (WIDTH + w) * given.robots, from, to, whole[2 * WIDTH + w]);
            } else {
                sum_before(said + w * given.robots, sums + w * given.robots, from, to, whole[WIDTH + w]);
            }
        }
    }
}

KERNEL(rounds) {
    PHASE {
        const int64_t n = BLOCK * THREADS + thread, k = given.k;
        if (n < given.trials * given.robots) {
            Place at = place_of(given, n / given.robots, n % given.robots);
#if MODE == FULL
            at.before = given.around + at.trial * 2 * WIDTH * given.robots + at.i;
            at.after = at.before + WIDTH * given.robots;
            at.apart = given.robots;
#endif
            Robot me;
            if (k == 0) {
                begin(me, given, at);
            } else {
                load(given, at, me);
            }
            pass(me, given, at, k);
            if (k < given.rounds) {
                store(given, at, me);
            } else {
                finish(me, given, at);
            }
        }
    }
}
