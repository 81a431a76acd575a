// What this Kilobot runs: its brain is in brain.h, made from the Python file that was simulated.

#include "brain.h"  // before the headers of others, none of which then changes it
#include "settings.h"

#include "robot.h"

#include <kilolib.h>
#include "sensor.h"
#ifdef __AVR__
#include <avr/eeprom.h>
#endif

#define DATA 9      // bytes of a Kilobot's message
#define WAITING 16  // messages that wait for the next tick
#define BOOTS ((uint8_t *)0x1f0)  // where the memory of power cuts holds the boot count
#define IN_ORDER() __asm__ volatile("" ::: "memory")  // what is written before it is there before what is written after

_Static_assert(ROBOT_DATAGRAM <= DATA, "a Kilobot's message holds 9 bytes");

static struct robot robot_self;
static volatile uint8_t robot_inbox[WAITING][DATA];  // written when a message arrives, at any time
static volatile uint8_t robot_arrived, robot_taken;  // messages so far
static message_t robot_outgoing;
static volatile bool robot_speaks;   // whether it is still to be sent
static volatile bool robot_is_sent;  // whether it was
static uint32_t robot_due;
static bool robot_is_nameless;  // a blank memory of power cuts reads 0xFFFF on all: nobody would hear anybody

static void robot_message_rx(message_t *message, distance_measurement_t *distance) {
    (void)distance;
    if (message->type == NORMAL && message->data[0] == MARK && (uint8_t)(robot_arrived - robot_taken) < WAITING) {
        for (uint8_t k = 0; k < DATA; k++) {
            robot_inbox[robot_arrived % WAITING][k] = message->data[k];
        }
        robot_arrived++;
    }
}

// A message is sent once, as soon as nobody else speaks; one that was not is replaced by that of the next tick.
static message_t *robot_message_tx(void) { return robot_speaks ? &robot_outgoing : 0; }

static void robot_message_sent(void) {
    robot_speaks = false;
    robot_is_sent = true;
}

#if LUCK
static uint32_t robot_key, robot_drawn;

static number robot_draw(struct robot *robot) {
    (void)robot;
    return robot_random(robot_key, robot_drawn++);
}
#endif

static void robot_talk(void) {
    robot_speaks = false;
    IN_ORDER();
#if OWED
    static number owed[OWED];
    for (uint8_t k = 0; k < OWED; k++) {
        if (!robot_is_sent) {  // then the last message settled nothing
            robot_self.me.owed[k] = owed[k];
        }
        owed[k] = robot_self.me.owed[k];
    }
#endif
    robot_is_sent = false;
    robot_outgoing.type = NORMAL;
    const bool says = robot_say(&robot_self, robot_outgoing.data);
    robot_outgoing.crc = message_crc(&robot_outgoing);
    IN_ORDER();
    robot_speaks = says;
}

static void robot_listen(void) {
    const uint8_t arrived = robot_arrived;
    while (robot_taken != arrived) {
        uint8_t data[DATA];
        for (uint8_t k = 0; k < DATA; k++) {
            data[k] = robot_inbox[robot_taken % WAITING][k];
        }
        robot_taken++;
        robot_hear(&robot_self, data);
    }
}

static void robot_show(number x) {
    set_color(RGB(x > (number)0.5 ? 3 : 0, 0, x > (number)0.5 ? 0 : 3));  // red: mostly black; blue: mostly white
}

static void robot_setup(void) {
    uint8_t boot = 0;
#ifdef __AVR__
    boot = (uint8_t)(eeprom_read_byte(BOOTS) + 1);
    eeprom_write_byte(BOOTS, boot);
#endif
#if LUCK  // rand_hard measures the battery; in a simulator it may give all robots the same
    robot_key = robot_mixed((uint32_t)ROBOT << 8 | boot);
    for (uint8_t k = 0; k < 4; k++) {
        robot_key ^= (uint32_t)rand_hard() << 8 * k;
    }
#endif
    kilo_tx_period = 1;  // a new message does not wait
    robot_start(&robot_self, B, W, ROBOT, boot);
    robot_is_nameless = ROBOT == 0 || ROBOT == 0xFFFF;
    robot_due = robot_now();
}

static void robot_loop(void) {
    const uint32_t now = robot_now();
    if (robot_is_nameless) {
        set_color(RGB(now & 8 ? 3 : 0, now & 8 ? 3 : 0, 0));
        return;
    }
    if ((int32_t)(now - robot_due) < 0) {
        return;
    }
    robot_due = now + PERIOD;
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
    kilo_message_tx_success = robot_message_sent;
    kilo_start(robot_setup, robot_loop);
    return 0;
}
