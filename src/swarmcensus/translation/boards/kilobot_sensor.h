// What this Kilobot reads, and when.

#ifndef SENSOR_H
#define SENSOR_H

#include <kilolib.h>

// ============================== FILL IN: YOUR SENSOR ==============================
// 1 for black, 0 for white, -1 for no reading.
static int8_t robot_read_sensor(void) {
    const int16_t light = get_ambientlight();
    return light < 0 ? -1 : light < 300;
}
// ==================================================================================

// In Kilobot's ticks.
static uint32_t robot_now(void) {
    uint32_t now;
    do {  // an interrupt may change it while it is read
        now = kilo_ticks;
    } while (now != kilo_ticks);
    return now;
}

#endif
