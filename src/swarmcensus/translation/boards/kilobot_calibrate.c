// Counts what this Kilobot's sensor, that of sensor.h, reads on a black strip and then on a white one:
// `make calibrate.hex KILOLIB=../kilolib`, and "Run" in kilogui while it is on black.
// Move it over all of the strip. Red: it counts on black. Red and blue in turn, for a minute: put it onto white.
// Blue: it counts on white. Green: it prints its table over its serial line, again and again, with 38,400 baud:
//
//     stty -F /dev/ttyUSB0 38400 raw
//     head -n 9 /dev/ttyUSB0 | sed 1d | sort -ru > robot-4.csv    # the first line may be cut
//     swarmcensus calibrate robot-*.csv --out robots.toml

#define DEBUG  // of Kilobot's own library: it prints
#include <kilolib.h>
#include <debug.h>

#include <stdbool.h>

#include "counts.h"
#include "sensor.h"
#include "settings.h"

#define MINUTE 1830  // of Kilobot's ticks

static struct counts robot_strips[2];
static uint32_t robot_tick, robot_due;

static void robot_setup(void) { robot_due = robot_now(); }

static void robot_loop(void) {
    const uint32_t now = robot_now();
    if (ROBOT == 0 || ROBOT == 0xFFFF) {  // nobody would know of whom the table is
        set_color(RGB(now & 8 ? 3 : 0, now & 8 ? 3 : 0, 0));
        return;
    }
    if ((int32_t)(now - robot_due) < 0) {
        return;
    }
    robot_due = now + PERIOD;
    const uint8_t does = counts_tick(robot_strips, robot_tick++, MINUTE / PERIOD, robot_read_sensor(), ROBOT);
    if (does == COUNTED) {
        set_color(RGB(0, 3, 0));
    } else {
        const bool is_red = does == ON_BLACK || (does == BETWEEN && robot_tick % 2);
        set_color(RGB(is_red ? 3 : 0, 0, is_red ? 0 : 3));
    }
}

int main(void) {
    kilo_init();
    debug_init();
    kilo_start(robot_setup, robot_loop);
    return 0;
}
