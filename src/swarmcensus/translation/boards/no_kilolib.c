#include "kilolib.h"
#define WEAK __attribute__((weak))  // a test may have its own
WEAK volatile uint32_t kilo_ticks;
WEAK volatile uint16_t kilo_tx_period;
WEAK uint16_t kilo_uid;
void (*kilo_message_rx)(message_t *, distance_measurement_t *);
message_t *(*kilo_message_tx)(void);
void (*kilo_message_tx_success)(void);
WEAK void kilo_init(void) {}
WEAK void kilo_start(void (*setup)(void), void (*loop)(void)) { setup(); for (;;) loop(); }
WEAK int16_t get_ambientlight(void) { return 0; }
WEAK uint8_t rand_hard(void) { return 0; }
WEAK void set_color(uint8_t color) { (void)color; }
WEAK uint16_t message_crc(const message_t *message) { (void)message; return 0; }
