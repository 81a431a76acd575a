files="$(echo *.py) robot-$1/settings.py"
if [ -z "$2$3" ]; then echo "connect robot $1 alone, then press Enter"; read -r _; fi
if [ -z "$2" ] && [ -n "$3" ]; then scp $files "$3":; exit; fi
if [ -n "$FIRMWARE" ]; then  # of MicroPython, which its page says where to write
    : "${OFFSET:?is missing: where the firmware begins, such as 0x1000 on an ESP32}"
    cd "$from"
    test -f "$FIRMWARE" || { echo "FIRMWARE=$FIRMWARE: no such file" >&2; exit 1; }
    esptool ${2:+--port "$2"} erase-flash
    esptool ${2:+--port "$2"} write-flash "$OFFSET" "$FIRMWARE"
    cd "$OLDPWD"
    sleep 5  # the board makes its file system
fi
mpremote connect "${2:-auto}" cp $files : + reset
