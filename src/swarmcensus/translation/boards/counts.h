// Counts what a sensor reads on a black and on a white strip, and prints the table that `swarmcensus calibrate` reads.

#ifndef COUNTS_H
#define COUNTS_H

#include <stdint.h>
#include <stdio.h>

#define COUNTS_READINGS 1000  // on each strip, at most
#define COUNTS_HEAD "robot,strip,readings,black,changes\n"

enum { ON_BLACK, ON_WHITE, BETWEEN, COUNTED };  // what a robot does

struct counts {
    uint32_t readings, blacks, changes;  // from black to white and back
    int8_t before;
};

// Takes in a reading: above 0 for black, 0 for white, below 0 for none.
static inline void counts_take(struct counts *counts, int8_t black) {
    if (black >= 0) {
        counts->changes += counts->readings > 0 && (black > 0) != counts->before;
        counts->readings++;
        counts->blacks += black > 0;
        counts->before = black > 0;
    }
}

static inline void counts_print(const struct counts *counts, uint16_t number, const char *strip) {
    printf("%u,%s,%lu,%lu,%lu\n", (unsigned)number, strip, (unsigned long)counts->readings,
           (unsigned long)counts->blacks, (unsigned long)counts->changes);
}

// What a robot does in a tick: it counts on black, waits for so many ticks, counts on white, and then prints its table
// in each tick, so that its cable may come late.
static inline uint8_t counts_tick(struct counts *strips, uint32_t tick, uint32_t wait, int8_t black, uint16_t number) {
    const uint32_t second = COUNTS_READINGS + wait;
    if (tick >= second + COUNTS_READINGS) {
        printf(COUNTS_HEAD);
        counts_print(&strips[ON_BLACK], number, "black");
        counts_print(&strips[ON_WHITE], number, "white");
        return COUNTED;
    }
    const uint8_t does = tick < COUNTS_READINGS ? ON_BLACK : tick < second ? BETWEEN : ON_WHITE;
    if (does != BETWEEN) {
        counts_take(&strips[does], black);
    }
    return does;
}

#endif
