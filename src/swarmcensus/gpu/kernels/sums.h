// Sums over all robots before each one and over all after it, in the order of engine/brain_calls.py: blocks of
// BLOCK_SIZE robots are added up; then a robot's sum before it starts from the blocks before its own, and that after
// it likewise.

#define BLOCK_SIZE 256

// Sums within one block: `from` and `to` are its robots, `before` and `after` the sums over other blocks.
PART void sum_before(const number *said, number *out, int64_t from, int64_t to, number sum) {
    for (int64_t i = from; i < to; i++) {
        out[i] = sum;
        sum = sum + said[i];
    }
}

PART void sum_after(const number *said, number *out, int64_t from, int64_t to, number sum) {
    for (int64_t i = to - 1; i >= from; i--) {
        out[i] = sum;
        sum = sum + said[i];
    }
}

PART number sum_of(const number *said, int64_t from, int64_t to) {
    number sum = 0;
    for (int64_t i = from; i < to; i++) {
        sum = sum + said[i];
    }
    return sum;
}
