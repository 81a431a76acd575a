#include "brain.h"
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

extern uint8_t __heap_start;
static struct brain cost_me;
struct message cost_said;
uint8_t cost_bytes[BRAIN_MESSAGE_BYTES];
volatile uint8_t cost_floor_seen;
volatile float cost_believed;

static void cost_put(char c) {
    while (!(UCSR0A & _BV(UDRE0))) {
    }
    UDR0 = (uint8_t)c;
}

static void cost_put_number(uint32_t x) {
    char digits[10];
    uint8_t n = 0;
    do {
        digits[n++] = (char)('0' + x % 10);
        x /= 10;
    } while (x > 0);
    while (n > 0) {
        cost_put(digits[--n]);
    }
    cost_put('\n');
}

static void __attribute__((noinline)) cost_live(uint16_t tick) {
        ${draws}
        cost_floor_seen = (uint8_t)((tick * 5 % 8) < 3);
        observe(&cost_me, cost_floor_seen, 1);
${talk}
        fuse(&cost_me);
        cost_believed = estimate(&cost_me);
}

int main(void) {
    uint32_t total = 0;
    uint32_t longest = 0;
    uint8_t *free = &__heap_start;
    UBRR0 = 0;
    UCSR0B = _BV(TXEN0);
    brain_start(&cost_me, 0.9f, 0.8f${start});
    uint8_t *const top = (uint8_t *)SP - 2;
    for (uint8_t *p = free; p < top; p++) {
        *p = 0xA5;  // to see how deep the stack goes
    }
    TCCR1A = 0;
    TCCR1B = _BV(CS11);
    for (uint16_t tick = 0; tick < ${ticks}; tick++) {
        TIFR1 = _BV(TOV1);
        TCNT1 = 0;
        cost_live(tick);
        uint32_t counted = TCNT1;
        if (TIFR1 & _BV(TOV1)) {
            counted += UINT32_C(65536);
        }
        total += counted;
        longest = counted > longest ? counted : longest;
    }
    while (free < top && *free == 0xA5) {
        free++;
    }
    cost_put_number(total);
    cost_put_number((uint32_t)(top - free));
    cost_put_number(longest);
    while (!(UCSR0A & _BV(UDRE0))) {
    }
    cli();
    sleep_enable();
    sleep_cpu();
    return 0;
}
