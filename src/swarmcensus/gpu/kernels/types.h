// What a brain in C needs of its compiler.

#ifdef __CUDACC__

typedef unsigned char uint8_t;
typedef unsigned short uint16_t;
typedef unsigned int uint32_t;
typedef unsigned long long uint64_t;
typedef signed char int8_t;
typedef short int16_t;
typedef int int32_t;
typedef long long int64_t;
#define INT64_MAX 9223372036854775807ll
#define INT64_MIN (-INT64_MAX - 1)
#define INFINITY __int_as_float(0x7f800000)
#define NAN __int_as_float(0x7fc00000)
#define BRAIN_CONSTANT __constant__
#define BRAIN_NOTED __device__
#define BRAIN_PART __device__ static inline

#else

#include <cmath>
#include <cstdint>
#include <cstring>
using std::isfinite, std::isinf, std::isnan;
#define BRAIN_CONSTANT
#define BRAIN_NOTED
#define BRAIN_PART static inline

#endif

// Where Python would raise an error, C goes on, and this is noted.
extern "C" { BRAIN_NOTED int32_t brain_failed; }

template <class T> BRAIN_PART T brain_divisor(T by) {
    if (by == 0) {
        brain_failed = 1;
    }
    return by;
}

template <class T> BRAIN_PART T brain_result(T x) {
    if (!(x - x == 0)) {
        brain_failed = 1;
    }
    return x;
}

template <class T> BRAIN_PART T brain_countable(T x) {
    if (!(x > (T)-9223372036854775808.0 && x < (T)9223372036854775808.0)) {
        brain_failed = 1;
        return 0;
    }
    return x;
}

template <class T> BRAIN_PART int64_t brain_whole(T x) { return (int64_t)brain_countable(x); }

BRAIN_PART int64_t brain_place(int64_t index, int64_t items) {
    const int64_t place = index < 0 ? index + items : index;
    if (0 <= place && place < items) {
        return place;
    }
    brain_failed = 1;
    return 0;
}

#define BRAIN_TABLE
#define BRAIN_EACH_NUMBER \
    BRAIN_UNROLLED for (int32_t n = 0; n < (int32_t)(sizeof(struct brain) / sizeof(number)); n++)
