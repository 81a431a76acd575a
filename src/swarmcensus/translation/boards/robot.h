// What a robot does around its brain, on any board whose program is in C or C++.
//
// Before this file come brain.h and settings.h, which has MARK, LUCK, NAMED, ENDS, STEERS and ROBOT_SENDERS.
// In each tick a program calls, in this order, robot_observe if it has readings, robot_say, robot_hear for each datagram
// that has arrived, and robot_end. The simulator has the same order.
// A datagram is a header and the message of the brain. The header is one byte of the mark (of brain and format), one of
// the boot count, two of the sender, two of the tick; the low byte is first.

#ifndef ROBOT_H
#define ROBOT_H

#define ROBOT_HEADER 6
#define ROBOT_DATAGRAM (ROBOT_HEADER + BRAIN_MESSAGE_BYTES)
#define ROBOT_FORGETS 1000  // ticks after which a sender is as good as new

struct robot_sender {
    uint32_t heard;  // our tick when it was heard
    uint16_t number, tick;
    uint8_t boot;
};

struct robot {
    struct brain me;
    uint32_t tick;  // ticks begun
    uint16_t number;  // which no other robot has
    uint8_t boot;  // boot count
    uint8_t known;  // senders so far
    struct robot_sender senders[ROBOT_SENDERS];
    bool is_done;  // whether it makes no more readings
#if STEERS
    struct command course;
    bool is_steered;  // whether the brain has set the course
#endif
};

static inline uint32_t robot_mixed(uint32_t x) {
    x = (x ^ x >> 16) * UINT32_C(0x7feb352d);
    x = (x ^ x >> 15) * UINT32_C(0x846ca68b);
    return x ^ x >> 16;
}

// The random number in (0, 1) at a place in the sequence of a key, which no other robot or boot should have.
static inline number robot_random(uint32_t key, uint32_t place) {
    return (number)(robot_mixed(robot_mixed(place) + key) >> 9) / 8388608 + (number)0.5 / 8388608;
}

#if LUCK
static number robot_draw(struct robot *robot);  // a random number in (0, 1), which the program gives
#endif

static inline void robot_take_draw(struct robot *robot) {
#if LUCK
    robot->me.luck = robot_draw(robot);
#else
    (void)robot;
#endif
}

static inline void robot_blank(struct robot *robot, number b, number w) {
#if NAMED
    brain_start(&robot->me, b, w, (number)robot->number);
#else
    brain_start(&robot->me, b, w);
#endif
}

// A robot that knows nothing yet.
static inline void robot_start(struct robot *robot, number b, number w, uint16_t own_number, uint8_t boot) {
    robot->tick = 0;
    robot->number = own_number;
    robot->boot = boot;
    robot->known = 0;
    robot->is_done = false;
    robot_blank(robot, b, w);
#if STEERS
    robot->is_steered = false;
#endif
}

// Takes in readings, of which so many said black.
static inline void robot_observe(struct robot *robot, number blacks, number looks) {
    if (looks > 0 && !robot->is_done) {
        robot_take_draw(robot);
        observe(&robot->me, blacks, looks);
    }
}

// Begins the next tick's datagram, ROBOT_DATAGRAM bytes; returns whether the robot says anything.
static inline bool robot_say(struct robot *robot, uint8_t *datagram) {
    robot->tick++;
    datagram[0] = MARK;
    datagram[1] = robot->boot;
    datagram[2] = (uint8_t)(robot->number & 255);
    datagram[3] = (uint8_t)(robot->number >> 8);
    datagram[4] = (uint8_t)(robot->tick & 255);
    datagram[5] = (uint8_t)(robot->tick >> 8 & 255);
    return brain_send(&robot->me, datagram + ROBOT_HEADER);
}

// Whether a message is newer than the last one of its sender, which it then becomes.
static inline bool robot_is_new(struct robot *robot, uint8_t boot, uint16_t sender, uint16_t tick) {
    uint8_t at = 0;
    while (at < robot->known && robot->senders[at].number != sender) {
        at++;
    }
    if (at == robot->known && robot->known < ROBOT_SENDERS) {
        robot->known++;
    } else if (at == robot->known) {  // in place of the one unheard for longest
        at = 0;
        for (uint8_t k = 1; k < ROBOT_SENDERS; k++) {
            if (robot->senders[k].heard < robot->senders[at].heard) {
                at = k;
            }
        }
    } else if (robot->tick - robot->senders[at].heard < ROBOT_FORGETS) {
        const uint8_t boots = (uint8_t)(boot - robot->senders[at].boot);
        const uint16_t ticks = (uint16_t)(tick - robot->senders[at].tick);
        if (boots >= 128 || (boots == 0 && (ticks == 0 || ticks >= 32768))) {
            return false;
        }
    }
    robot->senders[at].number = sender;
    robot->senders[at].boot = boot;
    robot->senders[at].tick = tick;
    robot->senders[at].heard = robot->tick;
    return true;
}

// Takes in a datagram; returns whether it did. It does not if it is foreign, the robot's own, old, or came before.
static inline bool robot_hear(struct robot *robot, const uint8_t *datagram) {
    const uint16_t sender = (uint16_t)(datagram[2] | (uint16_t)datagram[3] << 8);
    const uint16_t tick = (uint16_t)(datagram[4] | (uint16_t)datagram[5] << 8);
    if (datagram[0] != MARK || sender == robot->number || !robot_is_new(robot, datagram[1], sender, tick)) {
        return false;
    }
    robot_take_draw(robot);
    brain_hear(&robot->me, datagram + ROBOT_HEADER);
    return true;
}

// Ends a tick; returns the estimate.
static inline number robot_end(struct robot *robot) {
    robot_take_draw(robot);
    fuse(&robot->me);
    number x = (number)estimate(&robot->me);
    if (!(x >= 0 && x <= 1)) {  // a forged message, or a fault: it starts blank
        robot_blank(robot, robot->me.b, robot->me.w);
        x = (number)0.5;
    }
#if ENDS
    robot->is_done = done(&robot->me);
#endif
#if STEERS
    robot_take_draw(robot);
    robot->is_steered = steer(&robot->me, &robot->course);
#endif
    return x;
}

#endif
