// What this Kilobot runs: its brain is in brain.h, made from the Python file that was simulated.

#include "brain.h"
// brain.h comes first, so that no macro of the headers below changes it
#include "settings.h"

#include "robot.h"

#include <avr/eeprom.h>
#include <kilolib.h>
#include <util/atomic.h>

#define DATA 9       // bytes of a Kilobot's message
#define WAITING 6    // messages that wait for the next tick
#define BOOTS ((uint8_t *)0x1f0)  // where the memory of power cuts holds the boot count

_Static_assert(ROBOT_DATAGRAM <= DATA, "a Kilobot's message holds 9 bytes");

static struct robot robot_self;
static volatile uint8_t robot_inbox[WAITING][DATA];  // written when a message arrives, at any time
static volatile uint8_t robot_arrived;
static message_t robot_outgoing;
static bool robot_speaks;
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
        for (uint8_t k = 0; k < DATA; k++) {
            robot_inbox[robot_arrived][k] = message->data[k];
        }
        robot_arrived++;
    }
}

static message_t *robot_message_tx(void) { return robot_speaks ? &robot_outgoing : 0; }

#if LUCK
static number robot_draw(struct robot *robot) {
    (void)robot;
    return (number)(((uint16_t)(rand_soft() << 8 | rand_soft()) + 0.5f) / 65536.0f);
}
#endif

static void robot_talk(void) {
    message_t next = {.type = NORMAL};
    const bool says = robot_say(&robot_self, next.data);
    next.crc = message_crc(&next);
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        robot_outgoing = next;
        robot_speaks = says;
    }
}

static void robot_listen(void) {
    static uint8_t data[WAITING][DATA];
    uint8_t count = 0;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        count = robot_arrived;
        for (uint8_t k = 0; k < count; k++) {
            for (uint8_t at = 0; at < DATA; at++) {
                data[k][at] = robot_inbox[k][at];
            }
        }
        robot_arrived = 0;
    }
    for (uint8_t k = 0; k < count; k++) {
        robot_hear(&robot_self, data[k]);
    }
}

static void robot_show(number x) {
    set_color(RGB(x > (number)0.5 ? 3 : 0, 0, x > (number)0.5 ? 0 : 3));  // red: mostly black; blue: mostly white
}

static void robot_setup(void) {
    const uint8_t boot = (uint8_t)(eeprom_read_byte(BOOTS) + 1);
    eeprom_write_byte(BOOTS, boot);
    robot_start(&robot_self, B, W, kilo_uid, boot);
    robot_due = kilo_ticks;
}

static void robot_loop(void) {
    if ((int32_t)(kilo_ticks - robot_due) < 0) {
        return;
    }
    robot_due = kilo_ticks + PERIOD;
    const int8_t black = robot_self.is_done ? -1 : robot_read_sensor();
    if (black >= 0) {
        robot_observe(&robot_self, (number)black, (number)1);
    }
    robot_talk();
    robot_listen();
    robot_show(robot_end(&robot_self));
}

int main(void) {
    kilo_init();
    kilo_message_rx = robot_message_rx;
    kilo_message_tx = robot_message_tx;
    kilo_start(robot_setup, robot_loop);
    return 0;
}
