// A swarm of ${robots} robots lives ${rounds} rounds and prints estimates, messages and memory in bits. Compare what it
// prints with expected.txt, which Python wrote. brain.h says which options the compiler needs.

#include "brain.h"

#define ROBOTS ${robots}
#ifndef ROUNDS
#define ROUNDS ${rounds}
#endif

// what a machine prints with, whose headers come last: none of them then changes the brain
static void test_put(char c);
static void test_begin(void);
static void test_end(void);

static struct brain test_swarm[ROBOTS];
static uint8_t test_messages[ROBOTS][BRAIN_MESSAGE_BYTES];
static bool test_speaks[ROBOTS];
static uint32_t test_state = ${seed};

static uint32_t test_draw(void) {
    test_state = test_state * UINT32_C(1664525) + UINT32_C(1013904223);
    return test_state;
}

static uint16_t test_draw_below(uint16_t n) { return (uint16_t)((test_draw() >> 16) % n); }

static void test_give_draw(struct brain *me) {
    const number luck = (number)((test_draw() >> 9) * 2 + 1) * ${unit_of_draw};
${draws}
}

static void test_put_text(const char *text) {
    while (*text) {
        test_put(*text++);
    }
}

static void test_put_whole(uint16_t x) {
    if (x >= 10) {
        test_put_whole(x / 10);
    }
    test_put((char)('0' + x % 10));
}

static void test_put_digit(uint8_t digit) { test_put((char)(digit < 10 ? '0' + digit : 'a' + digit - 10)); }

static void test_put_number(number x) {
    union {
        number value;
        ${word} bits;
    } both;
    both.value = x;
    test_put(' ');
    if (x != x) {
        test_put_text("nan");
        return;
    }
    for (int8_t shift = ${top}; shift >= 0; shift -= 4) {
        test_put_digit((uint8_t)(both.bits >> shift & 15));
    }
}

static void test_put_place(uint16_t round, uint8_t i) {
    test_put_whole(round);
    test_put(' ');
    test_put_whole(i);
}

static void test_put_answers(struct brain *me) {
${answers}
}

static void test_put_message(uint8_t i) {
    test_put(' ');
    if (!test_speaks[i]) {
        test_put_text("silent");
        return;
    }
    for (uint16_t k = 0; k < BRAIN_MESSAGE_BYTES; k++) {
        test_put_digit(test_messages[i][k] >> 4);
        test_put_digit(test_messages[i][k] & 15);
    }
}

static void test_put_memory(const struct brain *me) {
${memory}
}

static bool test_is_stop(uint16_t round) {
    static const uint16_t stops[] = {${stops}};
    for (uint8_t k = 0; k < sizeof stops / sizeof *stops; k++) {
        if (stops[k] == round) {
            return true;
        }
    }
    return false;
}

static void test_look(struct brain *me) {
    static const uint8_t numbers[] = {${looks}};
    const uint8_t looks = numbers[test_draw_below(sizeof numbers)];
    uint8_t blacks = 0;
    for (uint8_t k = 0; k < looks; k++) {
        blacks = (uint8_t)(blacks + (test_draw_below(100) < ${share}));
    }
    test_give_draw(me);
    if (looks > 0${done}) {
        observe(me, blacks, looks);
    }
}

static void test_listen(uint8_t i) {
    for (uint8_t j = 0; j < ROBOTS; j++) {
        const uint8_t apart = (uint8_t)((i + ROBOTS - j) % ROBOTS);
        if (apart == 0) {
            continue;
        }
        const bool is_far = test_draw_below(${far}) != 0 && apart != 1 && apart != ROBOTS - 1;
        if (!is_far && test_draw_below(${lost}) != 0 && test_speaks[j]) {
            test_give_draw(&test_swarm[i]);
            brain_hear(&test_swarm[i], test_messages[j]);
        }
    }
}

int main(void) {
    static const number accuracies[ROBOTS][2] = {${accuracies}};
    test_begin();
    for (uint8_t i = 0; i < ROBOTS; i++) {
        brain_start(&test_swarm[i], accuracies[i][0], accuracies[i][1]${name});
    }
    for (uint16_t round = 1; round <= ROUNDS; round++) {
        for (uint8_t i = 0; i < ROBOTS; i++) {
            test_look(&test_swarm[i]);
        }
        for (uint8_t i = 0; i < ROBOTS; i++) {
            test_speaks[i] = ${jam}brain_send(&test_swarm[i], test_messages[i]);
        }
        for (uint8_t i = 0; i < ROBOTS; i++) {
            test_listen(i);
        }
        for (uint8_t i = 0; i < ROBOTS; i++) {
            test_give_draw(&test_swarm[i]);
            fuse(&test_swarm[i]);
            test_put_place(round, i);
            test_put_answers(&test_swarm[i]);
            test_put_message(i);
            test_put('\n');
        }
        for (uint8_t i = 0; i < ROBOTS && test_is_stop(round); i++) {
            test_put_place(round, i);
            test_put_text(" memory");
            test_put_memory(&test_swarm[i]);
            test_put('\n');
        }
    }
    test_end();
    return 0;
}

#ifdef __AVR__
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

static void test_put(char c) {
    while (!(UCSR0A & _BV(UDRE0))) {
    }
    UDR0 = (uint8_t)c;
}

static void test_begin(void) {
    UBRR0 = 0;  // a sixteenth of the processor's clock
    UCSR0B = _BV(TXEN0);
}

static void test_end(void) {
    while (!(UCSR0A & _BV(UDRE0))) {
    }
    cli();  // a simulator ends here
    sleep_enable();
    sleep_cpu();
}
#else
#include <stdio.h>

static void test_put(char c) { putchar(c); }
static void test_begin(void) {}
static void test_end(void) { fflush(stdout); }
#endif
