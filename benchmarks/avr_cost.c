#include "brain.h"
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

extern uint8_t __heap_start;
#define ALONE __attribute__((noinline, noclone))  // so that two robots take the flash of one

struct cost_message {
    uint8_t code[BRAIN_MESSAGE_BYTES];
};

static struct brain cost_me, cost_other;
${message} cost_said, cost_heard;
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

ISR(TIMER1_OVF_vect) { GPIOR0++; }  // counts what the timer has no room for

static uint32_t cost_counted;  // in eights of cycles

static void ALONE cost_count(void) {
    TIFR1 = _BV(TOV1);
    GPIOR0 = 0;
    TCNT1 = 0;
    sei();
}

static void ALONE cost_pause(void) {
    cli();
    uint16_t counted = TCNT1;
    if (TIFR1 & _BV(TOV1)) {  // just now
        counted = TCNT1;
        GPIOR0++;
    }
    cost_counted += (uint32_t)GPIOR0 << 16 | counted;
}

static void ALONE cost_start(struct brain *me) { brain_start(me, 0.9f, 0.8f${start}); }

static void ALONE cost_begin(struct brain *me, uint16_t tick, bool black) {
    (void)tick;
    ${draws}
    cost_floor_seen = black;
    observe(me, cost_floor_seen, 1);
}

static bool ALONE cost_say(struct brain *me, ${message} *message) { return ${send}(me, ${of_message}); }

static void ALONE cost_end(struct brain *me) { fuse(me); }

// A tick in which another robot is heard under several names, one after the other. Its own time does not count.
static void ALONE cost_live(uint16_t tick, uint8_t heard) {
    cost_begin(&cost_me, tick, tick * 5 % 8 < 3);
    cost_say(&cost_me, &cost_said);
    for (uint8_t k = 0; k < heard; k++) {
        cost_pause();
        ${name}
        const bool speaks = cost_say(&cost_other, &cost_heard);
        ${message} *const message = &cost_heard;
        cost_count();
        if (speaks) {
            ${hear}(&cost_me, ${of_message});
        }
    }
    cost_end(&cost_me);
    cost_believed = estimate(&cost_me);
}

int main(void) {
    uint32_t total = 0;
    uint32_t longest = 0;
    uint8_t *free = &__heap_start;
    UBRR0 = 0;
    UCSR0B = _BV(TXEN0);
    cost_start(&cost_me);
    cost_start(&cost_other);
    uint8_t *const top = (uint8_t *)SP - 2;
    for (uint8_t *p = free; p < top; p++) {
        *p = 0xA5;  // to see how deep the stack goes
    }
    TCCR1A = 0;
    TCCR1B = _BV(CS11);
    TIMSK1 = _BV(TOIE1);
    for (uint16_t tick = 0; tick < ${ticks} + ${more}; tick++) {
        cost_begin(&cost_other, tick, tick * 5 % 8 >= 3);  // it sees the other colour
        cost_end(&cost_other);
        cost_counted = 0;
        cost_count();
        cost_live(tick, tick >= ${ticks} && tick % 50 == 49 ? ${crowd} : 2);
        cost_pause();
        total += tick < ${ticks} ? cost_counted : 0;
        longest = cost_counted > longest ? cost_counted : longest;
    }
    while (free < top && *free == 0xA5) {
        free++;
    }
    cost_put_number(total);
    cost_put_number((uint32_t)(top - free));
    cost_put_number(longest);
    cost_put_number(sizeof cost_other + sizeof cost_heard);
    while (!(UCSR0A & _BV(UDRE0))) {
    }
    cli();
    sleep_enable();
    sleep_cpu();
    return 0;
}
