# make KILOLIB=../kilolib   builds robot.hex with Kilobot's own library, which is fetched and built there first:
#                           https://github.com/acornejo/kilolib
KILOLIB ?= ../kilolib
CC = avr-gcc
CFLAGS = -mmcu=atmega328p -DF_CPU=8000000 -std=gnu99 -Os -Wall -Wextra -ffp-contract=off -ffunction-sections \
	-funsigned-char -funsigned-bitfields -fpack-struct -fshort-enums

robot.hex: robot.elf
	avr-objcopy -O ihex -R .eeprom $< $@

robot.elf: main.o
	$(CC) -mmcu=atmega328p -Wl,--gc-sections -Wl,-section-start=.bootloader=0x7000 -o $@ main.o \
		$(KILOLIB)/build/kilolib.a -lm
	avr-size $@

main.o: main.c brain.h robot.h settings.h
	$(CC) $(CFLAGS) -I$(KILOLIB) -c -o $@ main.c

clean:
	rm -f main.o robot.elf robot.hex
