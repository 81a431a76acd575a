// What is measured of the estimates of all rounds, as in engine/states.py, kernel.py and agreement.py.

PART const double *row_of(const Given &given, int64_t trial, int64_t k) {
    return given.rows + (trial * (given.rounds + 1) + k) * given.robots;
}

// The paper's convergence rule (Sec. IV-A): the earliest index that is within delta of all later ones.
KERNEL(settle) {
    PHASE {
        const int64_t n = BLOCK * THREADS + thread;
        if (n < given.trials * given.robots) {
            const double *row = row_of(given, n / given.robots, given.rounds) + n % given.robots;
            int64_t where = given.rounds;
            double low = INFINITY, high = -INFINITY, value = *row;
            given.final[n] = value;
            for (int64_t k = given.rounds; k >= 0 && high - low <= 2.0 * given.delta; k--, row -= given.robots) {
                const double x = *row, less = low <= x ? low : x, more = high >= x ? high : x;
                if (more - x < given.delta && x - less < given.delta) {
                    where = k;
                    value = x;
                }
                low = less, high = more;
            }
            given.where[n] = where;
            given.value[n] = value;
        }
    }
}

// What the threads of a block share to find quantiles.
struct Shared {
    uint32_t histogram[256], counts[4], sums[16];
    uint64_t greatest[2];
};

// A key that is ordered as numbers are.
PART uint64_t key_of(double x) {
    const uint64_t bits = bits_of(x);
    return bits >> 63 ? ~bits : bits | (1ull << 63);
}

PART double of_key(uint64_t key) { return from_bits(key >> 63 ? key & ~(1ull << 63) : ~key); }

// The least and the greatest honest estimate of each row of a large swarm, by several blocks a row: a row in which they
// are close needs no quantile. What is kept of the least is the complement of its key, so that both grow from 0.
KERNEL(extremes) {
    Shared *ours = (Shared *)SHARED;
    const int64_t pieces = (given.robots + given.piece - 1) / given.piece, at = BLOCK / pieces;
    const int64_t trial = at / (given.rounds + 1), from = BLOCK % pieces * given.piece, end = from + given.piece;
    const double *row = row_of(given, trial, at % (given.rounds + 1));
    PHASE {
        if (thread < 2) {
            ours->greatest[thread] = 0;
        }
    }
    BARRIER;
    PHASE {
        uint64_t most[2] = {0, 0};
        for (int64_t i = from + thread; i < end && i < given.robots; i += THREADS) {
            if (is_honest(given, trial, i)) {
                const uint64_t key = key_of(row[i]);
                most[0] = ~key > most[0] ? ~key : most[0];
                most[1] = key > most[1] ? key : most[1];
            }
        }
        take_more_of_all(&ours->greatest[0], most[0]);
        take_more_of_all(&ours->greatest[1], most[1]);
    }
    BARRIER;
    PHASE {
        if (thread < 2) {
            take_more(given.extremes + 2 * at + thread, ours->greatest[thread]);
        }
    }
}

#define TAIL 0.05
#define MARGIN 1e-12

struct Quantile {
    double lower, upper, value;
};

// Where a quantile of so many estimates lies: after so many of them, and so far towards the next one.
struct Place {
    int64_t rank;
    double part;
};

PART Place place_of(int64_t count, double share) {
    const double place = (double)(count - 1) * share;
    return {(int64_t)place, place - (double)(int64_t)place};
}

// A quantile between the two estimates around it, linear as in NumPy.
PART double between(double lower, double upper, double part) {
    const double step = upper - lower;
    return part >= 0.5 ? upper - step * (1.0 - part) : lower + step * part;
}

// Quantiles of wide rows: the estimates around both of them, of four ranks, are found together, digit by digit of their
// keys, each digit by two launches. Many blocks a row tally what its estimates have as the next digit, and one block
// chooses the digits. Digits that the least and the greatest estimate share are known. Rows of the last rounds come
// first, a chunk at a time: rows before one in which robots disagree are needed at checkpoints only.
#define SOUGHT 4
#define DIGITS 8

// The number of digits of the keys in a row that are known from the start; DIGITS if the row needs no quantiles.
PART int64_t known_digits(const Given &given, int64_t trial, int64_t k) {
    if (k > given.rounds) {
        return DIGITS;
    }
    const uint64_t *ends = given.extremes + 2 * (trial * (given.rounds + 1) + k);
    const uint64_t least = ~ends[0], greatest = ends[1];
    const int64_t chunks = (given.rounds + given.chunk) / given.chunk;
    bool needed = of_key(greatest) - of_key(least) > 2.0 * (given.delta - MARGIN);
    for (int64_t c = given.chunk_at + 1; c < chunks; c++) {
        needed = needed && given.agreed[trial * chunks + c] == 0;
    }
    for (int64_t c = 0; c < given.checkpoints; c++) {
        needed = needed || given.rounds_of[c] == k;
    }
    int64_t known = 0;
    while (known < DIGITS - 1 && (least ^ greatest) >> (56 - 8 * known) == 0) {
        known++;
    }
    return needed ? known : DIGITS;
}

// What is known of the keys that are sought in a row, with zeros after it.
struct Begun {
    uint64_t keys[SOUGHT], mask;
    int32_t like[SOUGHT];  // the first that begins as each does: they have one tally
};

PART Begun begun_in(const Given &given, int64_t at, bool is_first) {
    Begun begun;
    begun.mask = given.k > 0 ? ~0ull << (64 - 8 * given.k) : 0;
    for (int32_t n = 0; n < SOUGHT; n++) {
        begun.keys[n] = is_first ? ~given.extremes[2 * at] & begun.mask : given.sought[2 * SOUGHT * at + n];
        begun.like[n] = n;
        for (int32_t other = n - 1; other >= 0; other--) {
            begun.like[n] = begun.keys[other] == begun.keys[n] ? other : begun.like[n];
        }
    }
    return begun;
}

KERNEL(tally) {
    uint32_t *ours = (uint32_t *)SHARED;
    const int64_t pieces = (given.robots + given.piece - 1) / given.piece, trial = BLOCK / pieces / given.chunk;
    const int64_t k = given.chunk_at * given.chunk + BLOCK / pieces % given.chunk, at = trial * (given.rounds + 1) + k;
    const int64_t from = BLOCK % pieces * given.piece, end = from + given.piece, known = known_digits(given, trial, k);
    if (given.k < known) {
        return;
    }
    const double *row = row_of(given, trial, k);
    const Begun begun = begun_in(given, at, given.k == known);
    PHASE {
        for (int64_t n = thread; n < SOUGHT * 256; n += THREADS) {
            ours[n] = 0;
        }
    }
    BARRIER;
    PHASE {
        for (int64_t i = from + thread; i < end && i < given.robots; i += THREADS) {
            const uint64_t key = key_of(row[i]);
            for (int32_t n = 0; n < SOUGHT; n++) {
                if (begun.like[n] == n && (key & begun.mask) == begun.keys[n] && is_honest(given, trial, i)) {
                    add(&ours[256 * n + ((key >> (56 - 8 * given.k)) & 255)], 1);
                }
            }
        }
    }
    BARRIER;
    PHASE {
        for (int64_t n = thread; n < SOUGHT * 256; n += THREADS) {
            if (ours[n] > 0) {
                add(&given.tallies[SOUGHT * 256 * at + n], ours[n]);
            }
        }
    }
}

KERNEL(choose) {
    uint32_t *ours = (uint32_t *)SHARED;
    const int64_t trial = BLOCK / given.chunk, k = given.chunk_at * given.chunk + BLOCK % given.chunk;
    const int64_t at = trial * (given.rounds + 1) + k, known = known_digits(given, trial, k);
    const int64_t count = given.counted[trial];
    if (given.k < known) {
        return;
    }
    const Begun begun = begun_in(given, at, given.k == known);
    uint64_t *keys = given.sought + 2 * SOUGHT * at, *ranks = keys + SOUGHT;
    PHASE {
        for (int64_t n = thread; n < SOUGHT * 256; n += THREADS) {
            ours[n] = given.tallies[SOUGHT * 256 * at + n];
            given.tallies[SOUGHT * 256 * at + n] = 0;
        }
    }
    BARRIER;
    PHASE {
        if (thread < SOUGHT) {
            const int64_t first = place_of(count, thread < 2 ? TAIL : 1.0 - TAIL).rank + thread % 2;
            uint64_t rank = given.k > known ? ranks[thread] : first < count ? first : count - 1;
            const uint32_t *tally = ours + 256 * begun.like[thread];
            int32_t digit = 0;
            while (digit < 255 && rank >= tally[digit]) {
                rank -= tally[digit++];
            }
            keys[thread] = begun.keys[thread] | (uint64_t)digit << (56 - 8 * given.k);
            ranks[thread] = rank;
        }
    }
    BARRIER;
    PHASE {
        if (thread == 0 && given.k == DIGITS - 1) {
            const double low = between(of_key(keys[0]), of_key(keys[1]), place_of(count, TAIL).part);
            const double high = between(of_key(keys[2]), of_key(keys[3]), place_of(count, 1.0 - TAIL).part);
            given.widths[at] = (high - low) / 2.0;
            if (given.widths[at] > given.delta) {
                const int64_t chunks = (given.rounds + given.chunk) / given.chunk;
                take_more((uint64_t *)given.agreed + trial * chunks + given.chunk_at, k + 1);
            }
        }
    }
}

// The honest estimate of a row with so many before it, in order; digit by digit.
APART uint64_t select(const Given &given, int64_t trial, const double *row, int64_t rank TOGETHER) {
    Shared *ours = (Shared *)SHARED;
    uint64_t prefix = 0, mask = 0;
#pragma unroll 1
    for (int32_t shift = 56; shift >= 0; shift -= 8) {
        PHASE {
            for (int64_t digit = thread; digit < 256; digit += THREADS) {
                ours->histogram[digit] = 0;
            }
        }
        BARRIER;
        PHASE {
            for (int64_t i = thread; i < given.robots; i += THREADS) {
                const uint64_t key = key_of(row[i]);
                if ((key & mask) == prefix && is_honest(given, trial, i)) {
                    add(&ours->histogram[(key >> shift) & 255], 1);
                }
            }
        }
        BARRIER;
        PHASE {
            if (thread < 16) {
                ours->sums[thread] = 0;
                for (int32_t n = 0; n < 16; n++) {
                    ours->sums[thread] += ours->histogram[16 * thread + n];
                }
            }
        }
        BARRIER;
        int32_t digit = 0;
        while (digit < 240 && rank >= ours->sums[digit / 16]) {
            rank -= ours->sums[digit / 16];
            digit += 16;
        }
        while (digit < 255 && rank >= ours->histogram[digit]) {
            rank -= ours->histogram[digit++];
        }
        prefix |= (uint64_t)digit << shift;
        mask |= 255ull << shift;
        BARRIER;
    }
    return prefix;
}

// The two honest estimates around a quantile of a row, and the quantile.
APART Quantile quantile_of(const Given &given, int64_t trial, const double *row, int64_t count, double share TOGETHER) {
    Shared *ours = (Shared *)SHARED;
    const Place place = place_of(count, share);
    const int64_t rank = place.rank;
    const uint64_t key = select(given, trial, row, rank ALL_OF_US);
    PHASE {
        if (thread == 0) {
            ours->counts[0] = 0;
            ours->greatest[0] = 0;
        }
    }
    BARRIER;
    PHASE {
        uint32_t upto = 0;
        uint64_t above = 0;  // of keys above, the complement of the least
        for (int64_t i = thread; i < given.robots; i += THREADS) {
            const uint64_t other = key_of(row[i]);
            if (is_honest(given, trial, i)) {
                upto += other <= key;
                above = other > key && ~other > above ? ~other : above;
            }
        }
        add_all(&ours->counts[0], upto);
        take_more_of_all(&ours->greatest[0], above);
    }
    BARRIER;
    Quantile found;
    found.lower = of_key(key);
    const bool is_last = rank + 1 >= count || ours->counts[0] > rank + 1;
    found.upper = is_last ? found.lower : of_key(~ours->greatest[0]);
    BARRIER;
    found.value = between(found.lower, found.upper, place.part);
    return found;
}

// Whether the estimates around the lower quantile are a and b or more, those around the other c and d or less.
APART bool are_inside(const Given &given, int64_t trial, const double *row, int64_t count, const double *bounds TOGETHER) {
    Shared *ours = (Shared *)SHARED;
    PHASE {
        if (thread < 4) {
            ours->counts[thread] = 0;
        }
    }
    BARRIER;
    PHASE {
        uint32_t counts[4] = {0, 0, 0, 0};
        for (int64_t i = thread; i < given.robots; i += THREADS) {
            if (is_honest(given, trial, i)) {
                counts[0] += row[i] >= bounds[0];
                counts[1] += row[i] >= bounds[1];
                counts[2] += row[i] <= bounds[2];
                counts[3] += row[i] <= bounds[3];
            }
        }
        for (int32_t n = 0; n < 4; n++) {
            add_all(&ours->counts[n], counts[n]);
        }
    }
    BARRIER;
    const int64_t lower = (int64_t)(TAIL * (double)(count - 1)), upper = (int64_t)((1.0 - TAIL) * (double)(count - 1));
    const int64_t after = lower + 1 < count - 1 ? lower + 1 : count - 1, above = upper + 1 < count - 1 ? upper + 1 : count - 1;
    const bool inside = ours->counts[0] >= count - lower && ours->counts[1] >= count - after &&
                        ours->counts[2] > upper && ours->counts[3] > above;
    BARRIER;
    return inside;
}

// The last index of some rounds at which the honest robots disagree by more than delta, and 1 more; 0 if there is none.
KERNEL(agree) {
    const int64_t chunks = (given.rounds + given.chunk) / given.chunk, trial = BLOCK / chunks;
    const int64_t first = BLOCK % chunks * given.chunk, end = first + given.chunk, count = given.counted[trial];
    const double reach = given.delta - MARGIN;
    int64_t found = 0;
    const double *row = row_of(given, trial, (end <= given.rounds ? end : given.rounds + 1) - 1);
    double bounds[4] = {row[0] - reach, row[0] - reach, row[0] + reach, row[0] + reach};
    for (int64_t k = (end <= given.rounds ? end : given.rounds + 1) - 1; k >= first && found == 0; k--) {
        row = row_of(given, trial, k);
        if (!are_inside(given, trial, row, count, bounds ALL_OF_US)) {
            const Quantile low = quantile_of(given, trial, row, count, TAIL ALL_OF_US);
            const Quantile high = quantile_of(given, trial, row, count, 1.0 - TAIL ALL_OF_US);
            const double width = (high.value - low.value) / 2.0, spare = given.delta - width - MARGIN;
            if (width > given.delta) {
                found = k + 1;
            }
            bounds[0] = low.lower - spare, bounds[1] = low.upper - spare;
            bounds[2] = high.lower + spare, bounds[3] = high.upper + spare;
        }
    }
    PHASE {
        if (thread == 0) {
            given.agreed[BLOCK] = found;
        }
    }
}

// How honest robots do at a checkpoint: how many are right, and how far they are from each other.
KERNEL(check) {
    Shared *ours = (Shared *)SHARED;
    const int64_t c = BLOCK / given.trials, trial = BLOCK % given.trials, count = given.counted[trial];
    const double *row = row_of(given, trial, given.rounds_of[c]);
    PHASE {
        if (thread == 0) {
            ours->counts[0] = 0;
        }
    }
    BARRIER;
    PHASE {
        uint32_t right = 0;
        for (int64_t i = thread; i < given.robots; i += THREADS) {
            right += is_honest(given, trial, i) && given.bins[2 * c] <= row[i] && row[i] < given.bins[2 * c + 1];
            if (given.keeps) {
                given.kept[BLOCK * given.robots + i] = row[i];
            }
        }
        add_all(&ours->counts[0], right);
    }
    BARRIER;
    const uint32_t right = ours->counts[0];
    BARRIER;
    double width = 0.0;
    if (given.piece > 0) {
        width = given.widths[trial * (given.rounds + 1) + given.rounds_of[c]];
    } else {
        const Quantile low = quantile_of(given, trial, row, count, TAIL ALL_OF_US);
        width = (quantile_of(given, trial, row, count, 1.0 - TAIL ALL_OF_US).value - low.value) / 2.0;
    }
    PHASE {
        if (thread == 0) {
            given.correct[BLOCK] = (double)right / (double)count;
            given.disagreement[BLOCK] = width;
        }
    }
}

// The option for which all honest robots of a trial have decided after a round; -1 if there is none.
KERNEL(decide) {
    Shared *ours = (Shared *)SHARED;
    const int64_t trial = BLOCK / given.rounds;
    const int16_t *row = given.decisions + BLOCK * given.robots;
    PHASE {
        if (thread == 0) {
            ours->counts[0] = 0;
            ours->greatest[0] = 0;
        }
    }
    BARRIER;
    PHASE {
        uint64_t most = 0;  // one more than the greatest option; all ones where a robot has not decided
        for (int64_t i = thread; i < given.robots; i += THREADS) {
            if (is_honest(given, trial, i)) {
                const uint64_t option = row[i] < 0 ? ~0ull : (uint64_t)row[i] + 1;
                most = option > most ? option : most;
            }
        }
        take_more_of_all(&ours->greatest[0], most);
    }
    BARRIER;
    PHASE {
        uint32_t others = 0;
        for (int64_t i = thread; i < given.robots; i += THREADS) {
            others += is_honest(given, trial, i) && (uint64_t)(row[i] + 1) != ours->greatest[0];
        }
        add_all(&ours->counts[0], others);
    }
    BARRIER;
    PHASE {
        if (thread == 0) {
            given.unanimous[BLOCK] = ours->counts[0] == 0 ? (int16_t)((int64_t)ours->greatest[0] - 1) : (int16_t)-1;
        }
    }
}
