#!/bin/sh
# Installs what compiles and runs translated brains for simulated chips (Debian, Ubuntu): an ATmega in simavr, a
# Cortex-M4F in QEMU. Tests of chips are skipped without it.
set -eu
if [ "$(id -u)" = 0 ]; then sudo=""; else sudo="sudo"; fi
$sudo apt-get update
$sudo apt-get install --yes --no-install-recommends \
    gcc libc6-dev make \
    gcc-avr binutils-avr avr-libc simavr \
    gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm
