// Stands in for Kilobot's own library, so that a robot's program can be compiled and measured without it.

#pragma once

#include <stdbool.h>
#include <stdint.h>

#define RGB(r, g, b) ((r) & 3) | (((g) & 3) << 2) | (((b) & 3) << 4)

enum { NORMAL, GPS, BOOT = 128, BOOTPGM_PAGE, BOOTPGM_SIZE, RESET, SLEEP, WAKEUP, CHARGE, VOLTAGE, RUN, READUID, CALIB };

typedef struct {
    uint8_t data[9];
    uint8_t type;
    uint16_t crc;
} message_t;

typedef struct {
    int16_t low_gain, high_gain;
} distance_measurement_t;

extern volatile uint32_t kilo_ticks;
extern volatile uint16_t kilo_tx_period;
extern uint16_t kilo_uid;
extern void (*kilo_message_rx)(message_t *, distance_measurement_t *);
extern message_t *(*kilo_message_tx)(void);
extern void (*kilo_message_tx_success)(void);

void kilo_init(void);
void kilo_start(void (*setup)(void), void (*loop)(void));
int16_t get_ambientlight(void);
uint8_t rand_hard(void);
uint8_t rand_soft(void);
void delay(uint16_t ms);
void set_color(uint8_t color);
uint16_t message_crc(const message_t *message);
