#include "kilolib.h"
volatile uint32_t kilo_ticks;
volatile uint16_t kilo_tx_period;
uint16_t kilo_uid;
void (*kilo_message_rx)(message_t *, distance_measurement_t *);
message_t *(*kilo_message_tx)(void);
void (*kilo_message_tx_success)(void);
void kilo_init(void) {}
void kilo_start(void (*setup)(void), void (*loop)(void)) { setup(); for (;;) loop(); }
int16_t get_ambientlight(void) { return 0; }
uint8_t rand_hard(void) { return 0; }
void set_color(uint8_t color) { (void)color; }
uint16_t message_crc(const message_t *message) { (void)message; return 0; }
