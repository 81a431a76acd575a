// What this Pogobot runs, on the robot and in pogosim: its brain is in brain.h, made from the Python file that was
// simulated. In pogosim each robot also writes a log, for `swarmcensus relive logs`.

#include "brain.h"  // before the headers of others, none of which then changes it
#ifndef REAL_ROBOT
#include "logged.h"
#endif

#include "pogobase.h"
#include "sensor.h"
#include "settings.h"

#include "robot.h"

#ifdef SIMULATOR
#include "robot_log.h"
#endif

_Static_assert(ROBOT_DATAGRAM <= MAX_PAYLOAD_SIZE_BYTES, "a Pogobot's message holds less");

typedef struct {
    struct robot robot;
    uint32_t key, drawn;  // of its random numbers
    uint16_t leg;  // ticks left of the walk's straight line or turn
    uint8_t wait, delay;  // loops until the next tick, and by how many the last one was delayed
    bool has_begun, is_to_speak, is_turning;
#ifdef SIMULATOR
    struct robot_log log;
    uint32_t clock;
#endif
} USERDATA;
DECLARE_USERDATA(USERDATA);
REGISTER_USERDATA(USERDATA)

// ============================== FILL IN: YOUR MOTORS ==============================
#define SPEED 0.1f  // metres a second with both motors at full power
#define TURN 4.0f  // radians a second with one motor at full power
#define STRAIGHT 5  // seconds of a straight line of the walk, at most
#define TURNING 2  // seconds of a turn, at most
// =============================================================================================

// A random number in (0, 1) of the robot's own sequence.
static number robot_chance(void) { return robot_random(mydata->key, mydata->drawn++); }

#if LUCK
static number robot_draw(struct robot *robot) {
    (void)robot;
    const number x = robot_chance();
#ifdef SIMULATOR
    robot_log_drew(&mydata->log, x);
#endif
    return x;
}
#endif

// Motors take from 0 to 1: none goes backwards.
static void robot_drive(float left, float right) {
    const float most = left > right ? left : right, scale = most > 1.0f ? most : 1.0f;
    pogobot_motor_set(motorL, left > 0 ? (uint16_t)(left / scale * motorFull) : motorStop);
    pogobot_motor_set(motorR, right > 0 ? (uint16_t)(right / scale * motorFull) : motorStop);
}

// Straight lines and turns of random lengths, unless the brain steers.
static void robot_walk(void) {
#if STEERS
    if (mydata->robot.is_steered) {
        const float ahead = (float)mydata->robot.course.speed / SPEED, turn = (float)mydata->robot.course.turn / TURN;
        robot_drive(ahead - turn / 2, ahead + turn / 2);
        return;
    }
#endif
    if (mydata->leg-- == 0) {
        mydata->is_turning = !mydata->is_turning;
        mydata->leg = (uint16_t)(robot_chance() * HZ * (mydata->is_turning ? TURNING : STRAIGHT));
        const float ahead = mydata->is_turning ? 0.0f : 1.0f;
        const bool turns_left = robot_chance() < 0.5f;
        robot_drive(turns_left ? ahead : 1.0f, turns_left ? 1.0f : ahead);
    }
}

static void robot_message_rx(message_t *message) {
#ifdef SIMULATOR
    if (mydata->log.heard == ROBOT_LOG_HEARD) {
        return;  // else the log would lack it
    }
#endif
    if (message->header.payload_length == ROBOT_DATAGRAM && robot_hear(&mydata->robot, message->payload)) {
#ifdef SIMULATOR
        robot_log_heard(&mydata->log, message->payload);
#endif
    }
}

static bool robot_message_tx(void) {
    uint8_t datagram[ROBOT_DATAGRAM];
    if (!mydata->is_to_speak) {
        return false;
    }
    mydata->is_to_speak = false;
    if (!robot_say(&mydata->robot, datagram)) {
        return false;
    }
#ifdef SIMULATOR
    robot_log_said(&mydata->log, datagram);
#endif
    return pogobot_infrared_sendShortMessage_omni(datagram, ROBOT_DATAGRAM) == 0;
}

static void robot_finish(void) {
    const number x = robot_end(&mydata->robot);
    pogobot_led_setColor(x > 0.5f ? 25 : 0, 0, x > 0.5f ? 0 : 25);  // red: mostly black; blue: mostly white
#ifdef SIMULATOR
    robot_log_tick(&mydata->log, &mydata->robot, mydata->clock, x);
#endif
}

void user_init(void) {
    memset(mydata, 0, sizeof *mydata);
    const uint16_t own_number = pogobot_helper_getid();
    mydata->key = robot_mixed(own_number);
    for (uint8_t k = 0; k < 16; k++) {  // the noise of several readings, which the board makes
        mydata->key = robot_mixed(mydata->key ^ (uint16_t)pogobot_helper_getRandSeed());
    }
    robot_start(&mydata->robot, B, W, own_number, (uint8_t)(robot_chance() * 256));
    main_loop_hz = HZ * LOOPS;  // each loop takes 80 bytes from each receiver
    max_nb_processed_msg_per_tick = 100;
    percent_msgs_sent_per_ticks = 100;  // robot_message_tx decides
    msg_rx_fn = robot_message_rx;
    msg_tx_fn = robot_message_tx;
    uint8_t directions[3];
    pogobot_motor_dir_mem_get(directions);
    pogobot_motor_dir_set(motorL, directions[motorL]);
    pogobot_motor_dir_set(motorR, directions[motorR]);
#ifdef SIMULATOR
    char name[32];
    snprintf(name, sizeof name, "logs/robot-%u.log", own_number);
    robot_log_open(&mydata->log, name, &mydata->robot, 1000 / HZ, current_time_milliseconds());
    if (!mydata->log.file) {
        printf("%s cannot be written: this run has no such log\n", name);
    }
#endif
}

// Ends the tick before, whose messages have arrived by now, and begins the next one, delayed by chance, so that
// neighbours that were switched on together do not always talk at once.
void user_step(void) {
    if (mydata->wait > 0) {
        mydata->wait--;
        return;
    }
    if (mydata->has_begun) {
        robot_finish();
    }
    const uint8_t delay = (uint8_t)(robot_chance() * LOOPS);
    mydata->wait = (uint8_t)(LOOPS + delay - mydata->delay - 1);
    mydata->delay = delay;
    mydata->has_begun = mydata->is_to_speak = true;
#ifdef SIMULATOR
    mydata->clock = current_time_milliseconds();
#endif
    const int8_t black = mydata->robot.is_done ? -1 : robot_read_sensor();
    if (black >= 0) {
        robot_observe(&mydata->robot, black, 1);
#ifdef SIMULATOR
        robot_log_read(&mydata->log, (uint16_t)black, 1);
#endif
    }
    robot_walk();
}

int main(void) {
    pogobot_init();
    pogobot_start(user_init, user_step);
    return 0;
}
