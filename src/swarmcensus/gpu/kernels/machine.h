// The machine: a graphics card, or a processor that runs the same text with a loop over the threads of a block.
//
// A kernel is a row of phases between barriers. In a PHASE every thread of a block does its part; what is declared
// outside of phases has the same value in all threads, unless it is Kept. Helper functions that hold phases are called
// outside of phases.

#ifdef __CUDACC__

#define PART BRAIN_PART
#define APART __device__ static __noinline__
#define KERNEL(name) extern "C" __global__ void __launch_bounds__(MOST_THREADS) name(const __grid_constant__ Given given)
#define PHASE if (const uint32_t thread = threadIdx.x; true)
#define BARRIER __syncthreads()
#define BLOCK ((int64_t)blockIdx.x)
#define THREADS ((int64_t)blockDim.x)
extern __shared__ __align__(16) unsigned char shared[];
#define SHARED shared

template <class T> struct Kept {
    T item;
    __device__ T &operator[](uint32_t) { return item; }
};

PART void add(uint32_t *sum, uint32_t what) { atomicAdd(sum, what); }
PART void take_more(uint64_t *most, uint64_t what) { atomicMax((unsigned long long *)most, what); }

// Adds up what all threads of a block give; all of them call it.
PART void add_all(uint32_t *sum, uint32_t what) {
    for (int32_t lane = 16; lane > 0; lane /= 2) {
        what += __shfl_xor_sync(0xffffffffu, what, lane);
    }
    if (threadIdx.x % 32 == 0 && what > 0) {
        atomicAdd(sum, what);
    }
}

// Finds the greatest of what all threads of a block give; all of them call it.
PART void take_more_of_all(uint64_t *most, uint64_t what) {
    for (int32_t lane = 16; lane > 0; lane /= 2) {
        const uint64_t other = __shfl_xor_sync(0xffffffffu, what, lane);
        what = other > what ? other : what;
    }
    if (threadIdx.x % 32 == 0) {
        take_more(most, what);
    }
}

#else

#define PART BRAIN_PART
#define APART static
#define KERNEL(name) \
    extern "C" void name(const Given given, const int64_t BLOCK, const int64_t THREADS, unsigned char *SHARED)
#define PHASE for (uint32_t thread = 0; thread < THREADS; thread++)
#define BARRIER (void)SHARED

template <class T> struct Kept {
    T items[1024];
    T &operator[](uint32_t thread) { return items[thread]; }
};

PART void add(uint32_t *sum, uint32_t what) { *sum += what; }
PART void add_all(uint32_t *sum, uint32_t what) { *sum += what; }
PART void take_more(uint64_t *most, uint64_t what) { *most = what > *most ? what : *most; }
PART void take_more_of_all(uint64_t *most, uint64_t what) { take_more(most, what); }

#endif

PART uint64_t bits_of(double x) {
    uint64_t bits;
    memcpy(&bits, &x, 8);
    return bits;
}

PART double from_bits(uint64_t bits) {
    double x;
    memcpy(&x, &bits, 8);
    return x;
}

// Helper functions that hold phases are given the block, its threads and its shared memory by a processor.
#ifdef __CUDACC__
#define TOGETHER
#define ALL_OF_US
#else
#define TOGETHER , const int64_t THREADS, unsigned char *SHARED
#define ALL_OF_US , THREADS, SHARED
#endif
