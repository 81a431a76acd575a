// Writes a robot's log, so that `swarmcensus relive` runs its brain again: for programs in C or C++ that have files.
//
// Before this file come brain.h, logged.h, settings.h and robot.h. A program calls robot_log_open
// after robot_start. In each tick it calls robot_log_read, robot_log_said and robot_log_heard after those functions of
// robot.h that returned true, robot_log_drew for each random number, and robot_log_tick after robot_end.

#ifndef ROBOT_LOG_H
#define ROBOT_LOG_H

#include <stdio.h>
#include <string.h>

#define ROBOT_LOG_HEARD 255  // messages a tick, of which a program takes no more: it compares log.heard before robot_hear
#define ROBOT_LOG_DRAWN (ROBOT_LOG_HEARD + 3)

struct robot_log {
    FILE *file;  // NULL: nothing is written
    uint32_t crc;  // of the block so far
    uint16_t blacks, looks, drawn;
    uint8_t heard;
    bool says;
    uint8_t said[ROBOT_DATAGRAM];
    uint8_t messages[ROBOT_LOG_HEARD][ROBOT_DATAGRAM];
    double draws[ROBOT_LOG_DRAWN];
};

static inline void robot_log_put_bytes(struct robot_log *log, const uint8_t *bytes, uint32_t count) {
    for (uint32_t k = 0; k < count; k++) {
        log->crc ^= bytes[k];
        for (uint8_t bit = 0; bit < 8; bit++) {
            log->crc = log->crc >> 1 ^ (log->crc & 1 ? 0xEDB88320u : 0);
        }
    }
    if (log->file) {
        fwrite(bytes, 1, count, log->file);
    }
}

// The lowest bytes of x, the lowest first.
static inline void robot_log_put(struct robot_log *log, uint64_t x, uint8_t count) {
    uint8_t bytes[8];
    for (uint8_t k = 0; k < 8; k++) {
        bytes[k] = (uint8_t)(x >> 8 * k & 255);
    }
    robot_log_put_bytes(log, bytes, count);
}

static inline void robot_log_put_real(struct robot_log *log, double x) {
    uint64_t bits = 0;
    memcpy(&bits, &x, sizeof bits);
    robot_log_put(log, bits, 8);
}

static inline void robot_log_put_numbers(struct robot_log *log, const number *numbers, uint32_t count) {
    for (uint32_t k = 0; k < count; k++) {
        robot_log_put_real(log, (double)numbers[k]);
    }
}

static inline void robot_log_begin(struct robot_log *log, char kind, uint32_t size) {
    log->crc = 0xFFFFFFFFu;
    robot_log_put(log, (uint8_t)kind, 1);
    robot_log_put(log, size, 4);
}

static inline void robot_log_end(struct robot_log *log) {
    robot_log_put(log, ~log->crc & 0xFFFF, 2);
    if (log->file) {
        fflush(log->file);
    }
}

// Forgets what was collected of a tick.
static inline void robot_log_clear(struct robot_log *log) {
    log->blacks = log->looks = log->drawn = 0;
    log->heard = 0;
    log->says = false;
}

// Begins a log with what the robot is. `period` and `clock` are milliseconds, a tick and now.
static inline void robot_log_open(
    struct robot_log *log, const char *path, const struct robot *robot, uint32_t period, uint32_t clock) {
    static const uint8_t hash[8] = ROBOT_LOG_BRAIN;
    static const number parameters[] = ROBOT_LOG_PARAMETERS;
    const uint32_t given = sizeof parameters / sizeof *parameters - 1;
    log->file = fopen(path, "wb");
    robot_log_clear(log);
    robot_log_begin(log, 'S', 71 + 8 * (given + ROBOT_LOG_NUMBERS + ROBOT_LOG_OWED));
    robot_log_put_bytes(log, (const uint8_t *)"swarmlog", 8);
    robot_log_put(log, 1, 1);  // version
    robot_log_put(log, 1 | ROBOT_LOG_FLAGS, 1);
    robot_log_put(log, ROBOT_LOG_FORM, 1);
    robot_log_put(log, robot->boot, 4);
    robot_log_put(log, ROBOT_LOG_MARK, 2);
    robot_log_put(log, robot->number, 2);
    robot_log_put(log, BRAIN_MESSAGE_BYTES, 2);
    robot_log_put(log, robot->tick, 4);
    robot_log_put(log, period, 4);
    robot_log_put(log, clock & 0x3FFFFFFF, 4);
    robot_log_put_bytes(log, hash, 8);
    robot_log_put(log, 0, 8);  // the time of its start is not known
    robot_log_put_real(log, (double)robot->me.b);
    robot_log_put_real(log, (double)robot->me.w);
    robot_log_put(log, given, 2);
    robot_log_put(log, ROBOT_LOG_NUMBERS, 2);
    robot_log_put(log, ROBOT_LOG_OWED, 2);
    robot_log_put_numbers(log, parameters, given);
    robot_log_put_memory(log, &robot->me);
    robot_log_end(log);
}

static inline void robot_log_read(struct robot_log *log, uint16_t blacks, uint16_t looks) {
    log->blacks = blacks;
    log->looks = looks;
}

static inline void robot_log_said(struct robot_log *log, const uint8_t *datagram) {
    memcpy(log->said, datagram, ROBOT_DATAGRAM);
    log->says = true;
}

static inline void robot_log_heard(struct robot_log *log, const uint8_t *datagram) {
    if (log->heard < ROBOT_LOG_HEARD) {
        memcpy(log->messages[log->heard++], datagram, ROBOT_DATAGRAM);
    }
}

static inline void robot_log_drew(struct robot_log *log, number x) {
    if (log->drawn < ROBOT_LOG_DRAWN) {
        log->draws[log->drawn++] = (double)x;
    }
}

// Writes what was collected of a tick that began at this time, in milliseconds.
static inline void robot_log_tick(struct robot_log *log, const struct robot *robot, uint32_t clock, number estimated) {
    const uint32_t heard = log->heard * (5u + BRAIN_MESSAGE_BYTES), drawn = log->drawn ? 2u + 8u * log->drawn : 0;
    FILE *const file = log->file;
    log->file = NULL;
    log->crc = 0xFFFFFFFFu;
    robot_log_put_memory(log, &robot->me);
    const uint32_t memory = ~log->crc;
    log->file = file;
    robot_log_begin(log, 'T', 14 + (log->says ? BRAIN_MESSAGE_BYTES : 0) + heard + drawn + 12);
    robot_log_put(log, robot->tick, 4);
    robot_log_put(log, clock & 0x3FFFFFFF, 4);
    robot_log_put(log, log->blacks, 2);
    robot_log_put(log, log->looks, 2);
    robot_log_put(log, (log->says ? 1 : 0) | (log->drawn ? 2 : 0), 1);
    robot_log_put(log, log->heard, 1);
    if (log->says) {
        robot_log_put_bytes(log, log->said + ROBOT_HEADER, BRAIN_MESSAGE_BYTES);
    }
    for (uint8_t k = 0; k < log->heard; k++) {
        robot_log_put_bytes(log, log->messages[k] + 2, 2);  // sender
        robot_log_put_bytes(log, log->messages[k] + 1, 1);  // boot count
        robot_log_put_bytes(log, log->messages[k] + 4, 2 + BRAIN_MESSAGE_BYTES);
    }
    if (log->drawn) {
        robot_log_put(log, log->drawn, 2);
        for (uint16_t k = 0; k < log->drawn; k++) {
            robot_log_put_real(log, log->draws[k]);
        }
    }
    robot_log_put_real(log, (double)estimated);
    robot_log_put(log, memory, 4);
    robot_log_end(log);
    robot_log_clear(log);
}

#endif
