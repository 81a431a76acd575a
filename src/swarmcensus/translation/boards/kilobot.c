// What this Kilobot runs: its brain is in brain.h, made from the Python file that was simulated.

#include <avr/eeprom.h>
#include <kilolib.h>
#include <util/atomic.h>

#include "brain.h"
#include "settings.h"

#define HEADER 6           // mark, boot count, sender (2), tick (2)
#define WAITING 6          // messages that wait for the next tick
#define SENDERS 16         // of whom the last message is known
#define FORGET 1000        // ticks after which a sender is as good as new
#define BOOTS ((uint8_t *)0x1f0)  // where the memory of power cuts holds the boot count

_Static_assert(HEADER + BRAIN_MESSAGE_BYTES <= 9, "a Kilobot's message holds 9 bytes");

struct sender {
    uint16_t number, tick, heard;
    uint8_t boot;
};

static struct brain robot_me;
static struct sender robot_senders[SENDERS];
static uint8_t robot_known;  // senders so far
static volatile uint8_t robot_inbox[WAITING][9];  // written when a message arrives, at any time
static volatile uint8_t robot_arrived;
static message_t robot_outgoing;
static bool robot_speaks;
static uint16_t robot_tick;
static uint8_t robot_boot;
static uint32_t robot_due;

// ============================== FILL IN: YOUR SENSOR ==============================
// 1 for black, 0 for white, -1 for no reading.
static int8_t robot_read_sensor(void) {
    const int16_t light = get_ambientlight();
    return light < 0 ? -1 : light < 300;
}
// ==================================================================================

static void robot_message_rx(message_t *message, distance_measurement_t *distance) {
    (void)distance;
    if (message->type == NORMAL && message->data[0] == MARK && robot_arrived < WAITING) {
        for (uint8_t k = 0; k < 9; k++) {
            robot_inbox[robot_arrived][k] = message->data[k];
        }
        robot_arrived++;
    }
}

static message_t *robot_message_tx(void) { return robot_speaks ? &robot_outgoing : 0; }

// Whether a message is newer than the last one of its sender, which it then becomes.
static bool robot_is_new(const uint8_t *data) {
    const uint8_t from_boot = data[1];
    const uint16_t number = (uint16_t)(data[2] | data[3] << 8), sent = (uint16_t)(data[4] | data[5] << 8);
    uint8_t at = 0;
    while (at < robot_known && robot_senders[at].number != number) {
        at++;
    }
    if (at < robot_known && (uint16_t)(robot_tick - robot_senders[at].heard) < FORGET) {
        const uint8_t boots = (uint8_t)(from_boot - robot_senders[at].boot);
        const uint16_t ticks = (uint16_t)(sent - robot_senders[at].tick);
        if (boots >= 128 || (boots == 0 && (ticks == 0 || ticks >= 32768))) {
            return false;
        }
    } else if (at == robot_known && robot_known < SENDERS) {
        robot_known++;
    } else if (at == robot_known) {  // in place of the one unheard for longest
        at = 0;
        for (uint8_t k = 1; k < SENDERS; k++) {
            if ((uint16_t)(robot_tick - robot_senders[k].heard) > (uint16_t)(robot_tick - robot_senders[at].heard)) {
                at = k;
            }
        }
    }
    robot_senders[at].number = number;
    robot_senders[at].boot = from_boot;
    robot_senders[at].tick = sent;
    robot_senders[at].heard = robot_tick;
    return true;
}

static void robot_take_luck(void) {
#if LUCK
    robot_me.luck = (number)(((uint16_t)(rand_soft() << 8 | rand_soft()) + 0.5f) / 65536.0f);
#endif
}

static void robot_begin(void) {
#if NAMED
    brain_start(&robot_me, B, W, (number)kilo_uid);
#else
    brain_start(&robot_me, B, W);
#endif
}

static void robot_talk(void) {
    message_t next;
    next.type = NORMAL;
    next.data[0] = MARK;
    next.data[1] = robot_boot;
    next.data[2] = (uint8_t)(kilo_uid & 255);
    next.data[3] = (uint8_t)(kilo_uid >> 8);
    next.data[4] = (uint8_t)(robot_tick & 255);
    next.data[5] = (uint8_t)(robot_tick >> 8);
    for (uint8_t k = HEADER; k < 9; k++) {
        next.data[k] = 0;
    }
    const bool says = brain_send(&robot_me, next.data + HEADER);
    next.crc = message_crc(&next);
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        robot_outgoing = next;
        robot_speaks = says;
    }
}

static void robot_hear(void) {
    static uint8_t data[WAITING][9];
    uint8_t count = 0;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        count = robot_arrived;
        for (uint8_t k = 0; k < count; k++) {
            for (uint8_t at = 0; at < 9; at++) {
                data[k][at] = robot_inbox[k][at];
            }
        }
        robot_arrived = 0;
    }
    for (uint8_t k = 0; k < count; k++) {
        if (robot_is_new(data[k])) {
            robot_take_luck();
            brain_hear(&robot_me, data[k] + HEADER);
        }
    }
}

static void robot_show(number x) {
    if (!(x >= 0 && x <= 1)) {  // a forged message, or a fault: it starts blank
        robot_begin();
        x = (number)0.5;
    }
    set_color(RGB(x > (number)0.5 ? 3 : 0, 0, x > (number)0.5 ? 0 : 3));  // red: mostly black; blue: mostly white
}

static void robot_setup(void) {
    robot_boot = (uint8_t)(eeprom_read_byte(BOOTS) + 1);
    eeprom_write_byte(BOOTS, robot_boot);
    robot_begin();
    robot_due = kilo_ticks;
}

static void robot_loop(void) {
    if ((int32_t)(kilo_ticks - robot_due) < 0) {
        return;
    }
    robot_due = kilo_ticks + PERIOD;
    robot_tick++;
    const int8_t black = IS_DONE ? -1 : robot_read_sensor();
    if (black >= 0) {
        robot_take_luck();
        observe(&robot_me, (number)black, (number)1);
    }
    robot_talk();
    robot_hear();
    robot_take_luck();
    fuse(&robot_me);
    robot_show((number)estimate(&robot_me));
}

int main(void) {
    kilo_init();
    kilo_message_rx = robot_message_rx;
    kilo_message_tx = robot_message_tx;
    kilo_start(robot_setup, robot_loop);
    return 0;
}
