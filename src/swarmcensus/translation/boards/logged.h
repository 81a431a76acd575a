// What a log of the brain ${brain} holds. This file comes after brain.h.

#ifndef LOGGED_H
#define LOGGED_H

#define ROBOT_LOG_BRAIN {${hash}}  // how the hash of the brain's file begins
#define ROBOT_LOG_MARK 0x${mark}  // of brain and format
#define ROBOT_LOG_FORM ${form}  // of messages: 1 float32, 2 float16, 3 ratio16, 4 ratio8
#define ROBOT_LOG_FLAGS ${flags}  // 2: what rounding takes is owed; 4: single precision
#define ROBOT_LOG_PARAMETERS {${parameters}0}  // by name, and an end
#define ROBOT_LOG_NUMBERS ${numbers}  // of the memory
#define ROBOT_LOG_OWED ${owed}  // numbers of a message

struct robot_log;
static inline void robot_log_put_numbers(struct robot_log *log, const number *numbers, uint32_t count);

// The memory by the names of its fields, and what rounding took of each number of messages.
static inline void robot_log_put_memory(struct robot_log *log, const struct brain *me) {
    static const number nothing = 0;
    (void)me;
    (void)nothing;
${memory}
}

#endif
