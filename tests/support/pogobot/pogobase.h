// Stands in for the header of Pogobots and of pogosim: a swarm on a line, whose neighbours hear each other.

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_PAYLOAD_SIZE_BYTES 382
#ifndef ROBOTS
#define ROBOTS 4
#define TURNS 300
#endif
#define EMITTERS 2  // so many copies of a message arrive
#define QUEUE 64

typedef struct {
    uint8_t _packet_type, _emitting_power_list;
    uint16_t _sender_id;
    uint8_t _sender_ir_index, _receiver_ir_index;
    uint16_t payload_length;
} message_header_t;

typedef struct {
    message_header_t header;
    uint8_t payload[MAX_PAYLOAD_SIZE_BYTES];
} message_t;

typedef enum { motorR = 0, motorL = 1, motorB = 2 } motor_id;
typedef enum { motorStop = 0, motorFull = 1023 } motor_range;

static uint8_t main_loop_hz, max_nb_processed_msg_per_tick, percent_msgs_sent_per_ticks;
static void (*msg_rx_fn)(message_t *);
static bool (*msg_tx_fn)(void);

#ifdef REAL_ROBOT
#define DECLARE_USERDATA(type) \
    static type userdata;      \
    static inline type *get_mydata(void) { return &userdata; }
#define mydata (get_mydata())
#define REGISTER_USERDATA(type)
#else
#define SIMULATOR
#define DECLARE_USERDATA(type) static type *mydata
#define REGISTER_USERDATA(type)                                   \
    static size_t bytes_of_userdata(void) { return sizeof(type); } \
    static void set_userdata(void *data) { mydata = (type *)data; }
static size_t bytes_of_userdata(void);
static void set_userdata(void *data);
#endif

static int robot_here;
static uint32_t milliseconds, noise = 1;
static message_t queues[ROBOTS][QUEUE];
static int queued[ROBOTS];
static long power_used;

static inline uint32_t noise_of_world(void) { return (noise = noise * 1664525u + 1013904223u) >> 8; }
static inline void pogobot_init(void) {}
static inline uint16_t pogobot_helper_getid(void) { return (uint16_t)(1000 + robot_here); }
static inline int16_t pogobot_helper_getRandSeed(void) { return (int16_t)(noise_of_world() & 3); }
static inline uint32_t current_time_milliseconds(void) { return milliseconds; }
static inline int16_t pogobot_photosensors_read(uint8_t sensor) { return (int16_t)(noise_of_world() % 900 + sensor); }
static inline void pogobot_led_setColor(uint8_t r, uint8_t g, uint8_t b) { power_used += r + g + b; }
static inline void pogobot_motor_set(motor_id motor, uint16_t value) { power_used += motor <= motorB ? value : 0; }
static inline void pogobot_motor_dir_set(motor_id motor, uint8_t value) { power_used += motor <= motorB ? value : 0; }
static inline int8_t pogobot_motor_dir_mem_get(uint8_t *directions) { return memset(directions, 0, 3) == NULL; }

static inline uint32_t pogobot_infrared_sendShortMessage_omni(uint8_t *message, uint16_t size) {
    message_t sent = {.header = {.payload_length = size}};
    memcpy(sent.payload, message, size);
    for (int to = robot_here - 1; to <= robot_here + 1; to += 2) {
        for (int k = 0; k < EMITTERS && to >= 0 && to < ROBOTS; k++) {
            if (noise_of_world() % 5 && queued[to] < QUEUE) {
                queues[to][queued[to]++] = sent;
            }
        }
    }
    return 0;
}

// Where a robot's program begins; the simulator is the program.
static inline void pogobot_start(void (*init)(void), void (*step)(void)) {
#ifdef REAL_ROBOT
    init();
    step();
#else
    static void *data[ROBOTS];
    for (robot_here = 0; robot_here < ROBOTS; robot_here++) {
        data[robot_here] = malloc(bytes_of_userdata());
        memset(data[robot_here], 0xA5, bytes_of_userdata());
        set_userdata(data[robot_here]);
        init();
    }
    for (int loop = 0; loop < TURNS; loop++, milliseconds += 1000 / main_loop_hz) {
        for (robot_here = 0; robot_here < ROBOTS; robot_here++) {
            set_userdata(data[robot_here]);
            step();
            if (msg_tx_fn) {
                msg_tx_fn();
            }
            for (int k = 0; k < queued[robot_here] && k < max_nb_processed_msg_per_tick; k++) {
                msg_rx_fn(&queues[robot_here][k]);
            }
            queued[robot_here] = 0;
        }
    }
    exit((msg_tx_fn && percent_msgs_sent_per_ticks != 100) || !power_used);
#endif
}
