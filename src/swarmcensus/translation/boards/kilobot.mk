# make KILOLIB=../kilolib   builds robot.hex with Kilobot's own library, which is fetched and built there first:
#                           https://github.com/acornejo/kilolib
# make calibrate.hex        the program that counts readings, if it is there
KILOLIB ?= ../kilolib
CC = avr-gcc
CFLAGS = -mmcu=atmega328p -DF_CPU=8000000 -std=gnu99 -Os -Wall -Wextra -ffp-contract=off -ffunction-sections \
	-funsigned-char -funsigned-bitfields -fpack-struct -fshort-enums

robot.hex calibrate.hex: %.hex: %.elf
	avr-objcopy -O ihex -R .eeprom $< $@

robot.elf: main.o
calibrate.elf: calibrate.o
robot.elf calibrate.elf:
	$(CC) -mmcu=atmega328p -Wl,--gc-sections -Wl,-section-start=.bootloader=0x7000 -o $@ $< \
		$(KILOLIB)/build/kilolib.a -lm
	avr-size $@

main.o: brain.h robot.h
calibrate.o: counts.h
%.o: %.c sensor.h settings.h
	$(CC) $(CFLAGS) -I$(KILOLIB) -c -o $@ $<

clean:
	rm -f *.o *.elf *.hex
