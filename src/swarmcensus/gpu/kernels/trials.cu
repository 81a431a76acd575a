// Whole trials of small swarms in one launch: states in registers, messages in shared memory, a thread a robot.
//
// A block runs `together` trials. Robot i of the t-th of them is thread t * robots + i.

PART void tables(const Given &given, const Place &at, int64_t k) {
    if (given.sensors > 1 || at.i == 0) {
        renew(given, at.trial, at.i, k);
    }
}

// One word of the sums over whole blocks: `parts` has the sum of each block in place 0, and gets those before and after
// it in places 1 and 2.
PART void chain(number *parts, int64_t blocks, int64_t apart) {
    number sum = 0;
    for (int64_t block = 0; block < blocks; block++) {
        parts[block * apart + WIDTH] = sum;
        sum = sum + parts[block * apart];
    }
    sum = 0;
    for (int64_t block = blocks - 1; block >= 0; block--) {
        parts[block * apart + 2 * WIDTH] = sum;
        sum = sum + parts[block * apart];
    }
}

KERNEL(trials) {
    const int64_t slots = given.delay + 2;
    const uint32_t robots = given.robots, stride = given.together * robots;
    number *outbox = (number *)SHARED;
    number *sums = outbox + slots * WIDTH * stride;  // before and after each robot
    number *parts = sums + (MODE == FULL ? 2 * WIDTH * stride : 0);
    const uint32_t blocks = (robots + BLOCK_SIZE - 1) / BLOCK_SIZE;
    uint8_t *signals = (uint8_t *)(parts + (MODE == FULL ? 3 * WIDTH * blocks * given.together : 0));
    Kept<Robot> mine;
    Kept<Place> places;
    PHASE {
        Place &at = places[thread];
        const uint32_t slot = thread / robots;
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
    int64_t heard = 1, said = 0;  // slots: each is heard `delay` passes after it was filled
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
            const number *messages = outbox + heard * WIDTH * stride;
            if (blocks > 1) {
                PHASE {
                    for (uint32_t n = thread; n < given.together * blocks * WIDTH; n += THREADS) {
                        const uint32_t w = n % WIDTH, block = n / WIDTH % blocks, slot = n / WIDTH / blocks;
                        const uint32_t from = block * BLOCK_SIZE, to = from + BLOCK_SIZE;
                        parts[(slot * blocks + block) * 3 * WIDTH + w] =
                            sum_of(messages + w * stride + slot * robots, from, to < robots ? to : robots);
                    }
                }
                BARRIER;
                PHASE {
                    for (uint32_t n = thread; n < given.together * WIDTH; n += THREADS) {
                        chain(parts + n / WIDTH * blocks * 3 * WIDTH + n % WIDTH, blocks, 3 * WIDTH);
                    }
                }
                BARRIER;
            }
            PHASE {
                const uint32_t each = given.together * blocks * WIDTH;
                for (uint32_t n = thread; n < 2 * each; n += THREADS) {
                    const bool later = n >= each;  // threads of a warp mostly go the same way
                    const uint32_t m = later ? n - each : n, w = m % WIDTH, block = m / WIDTH % blocks, slot = m / WIDTH / blocks;
                    const uint32_t from = block * BLOCK_SIZE, to = from + BLOCK_SIZE < robots ? from + BLOCK_SIZE : robots;
                    const number *whole = parts + (slot * blocks + block) * 3 * WIDTH + w;
                    const number *words = messages + w * stride + slot * robots;
                    number *out = sums + (later * WIDTH + w) * stride + slot * robots;
                    if (later) {
                        sum_after(words, out, from, to, blocks > 1 ? whole[2 * WIDTH] : 0);
                    } else {
                        sum_before(words, out, from, to, blocks > 1 ? whole[WIDTH] : 0);
                    }
                }
            }
            BARRIER;
        }
#endif
        PHASE {
            if (places[thread].trial < given.trials) {
                places[thread].heard = heard, places[thread].said = said;
                pass(mine[thread], given, places[thread], k);
            }
        }
        BARRIER;
        heard = next_slot(given, heard), said = next_slot(given, said);
    }
    PHASE {
        if (places[thread].trial < given.trials) {
            finish(mine[thread], given, places[thread]);
        }
    }
}
