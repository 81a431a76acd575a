// Counts what a sensor reads on one strip, at most 1,000 readings:
//
//     make calibrate
//     ./calibrate 4 black > robot-4-black.csv    # of robot 4, on the black strip; then on white
//     swarmcensus calibrate robot-*.csv --out robots.toml

#include "counts.h"

#include <ctype.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

// ============================== FILL IN: YOUR SENSOR ==============================
// Waits for the next reading: 1 for black, 0 for white, -1 for none. Returns false if there is no other one.
static bool read_floor(int *black) { return scanf("%d", black) == 1; }
// ==================================================================================

int main(int count, char **given) {
    char *end = 0;
    const long number = count == 3 && isdigit((unsigned char)*given[1]) ? strtol(given[1], &end, 10) : -1;
    if (!end || *end || number < 0 || number > 65535 || (strcmp(given[2], "black") && strcmp(given[2], "white"))) {
        fprintf(stderr, "usage: calibrate ROBOT STRIP: a number from 0 to 65535, and black or white\n");
        return 2;
    }
    struct counts counts = {0, 0, 0, 0};
    for (int black; counts.readings < COUNTS_READINGS && read_floor(&black);) {
        if (black < -1 || black > 1) {
            fprintf(stderr, "the reading %d should be 1 (black), 0 (white) or -1 (none)\n", black);
            return 2;
        }
        counts_take(&counts, (int8_t)black);
    }
    printf(COUNTS_HEAD);
    counts_print(&counts, (uint16_t)number, given[2]);
    return 0;
}
