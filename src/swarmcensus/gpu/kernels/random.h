// Counter-based random numbers and what they decide, to the bit as in engine/random.py, draws.py, changes.py, failures.py.

PART void mix(uint64_t &a, uint64_t &b, int32_t r) {
    a += b;
    b = (b << r) | (b >> (64 - r));
    b ^= a;
}

struct Words {
    uint64_t first, second;
};

PART Words block_of(const uint64_t *key, uint64_t c0, uint64_t c1) {
    const uint64_t k0 = key[0], k1 = key[1], k2 = 0x1BD11BDAA9FC1A22ull ^ k0 ^ k1;
    uint64_t a = c0 + k0, b = c1 + k1;
    mix(a, b, 16), mix(a, b, 42), mix(a, b, 12), mix(a, b, 31);
    a += k1, b += k2 + 1;
    mix(a, b, 16), mix(a, b, 32), mix(a, b, 24), mix(a, b, 21);
    a += k2, b += k0 + 2;
    mix(a, b, 16), mix(a, b, 42), mix(a, b, 12), mix(a, b, 31);
    a += k0, b += k1 + 3;
    mix(a, b, 16);
    return {a, b};
}

PART uint64_t counter(int64_t high, int64_t low) { return ((uint64_t)high << 32) | (uint64_t)low; }

PART uint64_t word_of(const uint64_t *key, int64_t trial, int64_t tick, int64_t receiver, int64_t sender) {
    return block_of(key, counter(trial, tick), counter(receiver, sender)).first;
}

// The word of robot i: robots 2j and 2j + 1 share block j.
PART uint64_t word_for(const uint64_t *key, int64_t trial, int64_t tick, int64_t part, int64_t i) {
    const Words words = block_of(key, counter(trial, tick), counter(part, 0) + (uint64_t)(i / 2));
    return i % 2 ? words.second : words.first;
}

PART double unit_of(uint64_t word) { return (double)(word >> 11) * (1.0 / 9007199254740992.0); }

PART number luck_of(uint64_t word) {
    if (sizeof(number) == 4) {
        return (number)(((double)(word >> 41) + 0.5) * (1.0 / 8388608.0));
    }
    return (number)(((double)(word >> 12) + 0.5) * (1.0 / 4503599627370496.0));
}

#define COLUMNS 16
#define MOST_LOOKS 15  // that one word can stand for

PART void alias_row(const double *weights, uint64_t *row) {
    double total = 0.0, share[COLUMNS];
    int32_t alias[COLUMNS], small[COLUMNS], large[COLUMNS], smalls = 0, larges = 0;
    for (int32_t c = 0; c < COLUMNS; c++) {
        total += weights[c];
    }
    for (int32_t c = 0; c < COLUMNS; c++) {
        share[c] = weights[c] / total * COLUMNS;
        alias[c] = c;
        if (share[c] < 1.0) {
            small[smalls++] = c;
        } else {
            large[larges++] = c;
        }
    }
    while (smalls > 0 && larges > 0) {
        const int32_t s = small[--smalls], g = large[larges - 1];
        alias[s] = g;
        share[g] -= 1.0 - share[s];
        if (share[g] < 1.0) {
            larges--;
            small[smalls++] = g;
        }
    }
    for (int32_t c = 0; c < COLUMNS; c++) {
        const double part = share[c] > 0.0 ? share[c] : 0.0;
        const double threshold = (part < 0.9999999999999999 ? part : 0.9999999999999999) * 18446744073709551616.0;
        row[c] = ((uint64_t)threshold & ~(uint64_t)15) | (uint64_t)alias[c];
    }
}

PART void binomial_row(int64_t looks, double p, uint64_t *row) {
    double weights[COLUMNS] = {1.0};
    for (int64_t look = 0; look < looks; look++) {
        for (int64_t k = looks; k > 0; k--) {
            weights[k] = (1.0 - p) * weights[k] + p * weights[k - 1];
        }
        weights[0] *= 1.0 - p;
    }
    alias_row(weights, row);
}

PART double pick(const uint64_t *row, uint64_t word) {
    const uint64_t column = word >> 60, entry = row[column];
    return (double)((word << 4) < (entry & ~(uint64_t)15) ? column : entry & 15);
}

PART double fill_ratio_in(const Given &given, int64_t k) {
    const double *course = given.course;
    if ((double)k < course[2]) {
        return course[0];
    }
    if ((double)k >= course[3]) {
        return course[1];
    }
    return course[0] + (course[1] - course[0]) * (((double)k - course[2] + 1.0) / (course[3] - course[2] + 1.0));
}

PART double accuracy_in(const Given &given, const double *side, int64_t trial, int64_t j, int64_t k) {
    const double start = side[trial * given.sensors + j];
    if (given.drifts == 0) {
        return start;
    }
    const double *drift = given.drift + 3 * given.drifts * trial + (given.drifts > 1 ? j : 0);
    const double moved = start + drift[0] * ((double)k - 1.0), least = drift[given.drifts];
    const double most = drift[2 * given.drifts], above = moved > least ? moved : least;
    return above < most ? above : most;
}

// Make the tables that the j-th sensor of a trial reads by in round k; those of the same numbers stay.
APART void renew(const Given &given, int64_t trial, int64_t j, int64_t k) {
    const double b = accuracy_in(given, given.b, trial, j, k), w = accuracy_in(given, given.w, trial, j, k);
    const double f = fill_ratio_in(given, k);
    double *stand = given.stand + 3 * (trial * given.sensors + j);
    if (stand[0] == b && stand[1] == w && stand[2] == f && k > 1) {
        return;
    }
    stand[0] = b, stand[1] = w, stand[2] = f;
    const double black = b * f + (1.0 - w) * (1.0 - f), above = black > 0.0 ? black : 0.0;
    const double p = above < 1.0 ? above : 1.0;
    const int64_t looks = given.looks, kinds = given.kinds;
    uint64_t *rows = given.tables + trial * kinds * given.sensors * COLUMNS;
    if (looks >= MOST_LOOKS) {
        binomial_row(MOST_LOOKS, p, rows + j * COLUMNS);
    }
    if (looks % MOST_LOOKS > 0) {
        binomial_row(looks % MOST_LOOKS, p, rows + ((kinds - 1) * given.sensors + j) * COLUMNS);
    }
}

// How many of a round's observations are black.
PART double blacks_of(const Given &given, int64_t trial, int64_t i, int64_t k) {
    const uint64_t *rows = given.tables + trial * given.kinds * given.sensors * COLUMNS;
    const int64_t j = given.sensors > 1 ? i : 0;
    double blacks = 0.0;
    for (int64_t part = 0; part * MOST_LOOKS < given.looks; part++) {
        const int64_t kind = (part + 1) * MOST_LOOKS <= given.looks ? 0 : given.kinds - 1;
        const uint64_t word = word_for(given.readings_key, given.first + trial, k, part, i);
        const double drawn = pick(rows + (kind * given.sensors + j) * COLUMNS, word);
        blacks = part == 0 ? drawn : blacks + drawn;
    }
    return blacks;
}

#define SENSING 1
#define TALKING 2
#define PARTS 3

// Whether a part of robot i works at a tick.
PART bool works(const Given &given, int64_t trial, int64_t part, int64_t i, int64_t tick) {
    if (given.stop_rows == 0) {
        return true;
    }
    const int64_t *stops = given.stops + trial * given.stop_rows * given.robots + i;
    if (tick < stops[part * given.robots]) {
        return true;
    }
    for (int64_t row = PARTS + part; row < given.stop_rows; row += 2 * PARTS) {
        if (stops[row * given.robots] <= tick && tick < stops[(row + PARTS) * given.robots]) {
            return false;
        }
    }
    return given.stop_rows > PARTS;
}
