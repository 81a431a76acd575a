// What this Pogobot reads. It comes after pogobase.h.

#ifndef SENSOR_H
#define SENSOR_H

// ============================== FILL IN: YOUR SENSOR ==============================
#define THRESHOLD 500  // light below it is black

// 1 for black, 0 for white, -1 for no reading.
static int8_t robot_read_sensor(void) {
    const int32_t light =
        (pogobot_photosensors_read(0) + pogobot_photosensors_read(1) + pogobot_photosensors_read(2)) / 3;
    return light < THRESHOLD;
}
// ==================================================================================

#endif
