// Starts the C library of a Cortex-M4F: its stack, its reset, and its unit for floats.
#include <stdint.h>

extern void _start(void);
void reset(void);

__attribute__((section(".vectors"), used)) static const uintptr_t vectors[] = {0x20200000, (uintptr_t)reset};

__attribute__((naked)) void reset(void) {
    __asm__ volatile(
        "ldr r0, =0xE000ED88\n ldr r1, [r0]\n orr r1, r1, #0xF00000\n str r1, [r0]\n dsb\n isb\n b _start");
}
