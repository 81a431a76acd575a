// Counts what this Pogobot's sensor, that of sensor.h, reads on a black strip and then on a white one:
// `make -B bin MAIN=calibrate SDK=../pogobot-sdk SOURCES=../pogosim/src`, and start it on black.
// Move it over all of the strip. Red: it counts on black. Yellow, for a minute: put it onto white. Blue: it counts on
// white. Green: it prints its table over its serial line, again and again, with 115,200 baud:
//
//     stty -F /dev/ttyUSB0 115200 raw
//     head -n 9 /dev/ttyUSB0 | sed 1d | sort -ru > robot-4.csv    # the first line may be cut
//     swarmcensus calibrate robot-*.csv --out robots.toml

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "pogobase.h"

#include "counts.h"
#include "sensor.h"
#include "settings.h"

typedef struct {
    struct counts strips[2];
    uint32_t tick;
} USERDATA;
DECLARE_USERDATA(USERDATA);
REGISTER_USERDATA(USERDATA)

void user_init(void) {
    memset(mydata, 0, sizeof *mydata);
    main_loop_hz = HZ;
}

void user_step(void) {
    const uint8_t does =
        counts_tick(mydata->strips, mydata->tick++, 60 * HZ, robot_read_sensor(), pogobot_helper_getid());
    const bool is_red = does == ON_BLACK || does == BETWEEN, is_green = does == COUNTED || does == BETWEEN;
    pogobot_led_setColor(is_red ? 25 : 0, is_green ? 25 : 0, does == ON_WHITE ? 25 : 0);
}

int main(void) {
    pogobot_init();
    pogobot_start(user_init, user_step);
    return 0;
}
