# make sim POGOSIM=/usr/local   builds `robot` with pogosim as it was installed there:
#                               https://github.com/Adacoma/pogosim
# make run   runs it without a window; each robot writes a log into `logs`, in place of those that were there
# make bin SDK=../pogobot-sdk SOURCES=../pogosim/src   builds firmware.bin for the robots:
#                               https://github.com/nekonaute/pogobot-sdk
# make -B bin MAIN=calibrate ...   the program that counts readings, if it is there
MAIN ?= main
POGOSIM ?= /usr/local
SDK ?= ../pogobot-sdk
SOURCES ?= ../pogosim/src
LIBRARIES ?= -lbox2d -lyaml-cpp -lspdlog -lSDL2 -lSDL2_gfx -lSDL2_ttf -lSDL2_image -lfmt -larrow -lm
HEADERS = brain.h logged.h sensor.h settings.h robot.h robot_log.h

ifneq ($(filter bin,$(MAKECMDGOALS)),)
include $(SDK)/tools/variables.mak
include $(SDK)/tools/common.mak
endif

sim: robot
	mkdir -p logs
	cp brain.py logs

run: sim
	rm -f logs/robot-*.log
	./robot -c simulation.yaml -g

robot: $(MAIN).c $(HEADERS)
	cc -std=gnu11 -O2 -Wall -Wextra -ffp-contract=off -I$(POGOSIM)/include -c -o sim.o $(MAIN).c
	c++ -o $@ sim.o -L$(POGOSIM)/lib -Wl,--whole-archive -lpogosim -Wl,--no-whole-archive $(LIBRARIES)

bin: firmware.bin

firmware.bin: $(MAIN).c $(HEADERS)
	for file in $(MAIN).c $(SOURCES)/pogosim/pogosim.c $(SOURCES)/pogosim/colormaps.c; do \
		$(CC_normal) -c $(CFLAGS) -ffp-contract=off -ffunction-sections -DREAL_ROBOT -I. -I$(SDK)/includes -I$(SOURCES) \
			-o `basename $$file .c`.o $$file || exit 1; done
	$(CC_normal) $(LDFLAGS) -Wl,--gc-sections -T $(SDK)/tools/linker.ld -N -o firmware.elf $(MAIN).o pogosim.o colormaps.o \
		-L$(SDK)/libs -Wl,--whole-archive -lpogobot -Wl,--no-whole-archive -Wl,--start-group -lc -lcompiler_rt -Wl,--end-group
	$(OBJCOPY_normal) -O binary firmware.elf $@

clean:
	rm -rf robot logs *.o *.d firmware.elf firmware.bin

.PHONY: sim run bin clean
