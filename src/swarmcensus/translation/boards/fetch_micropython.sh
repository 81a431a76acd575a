mkdir -p logs && cp brain.py logs
if [ -z "$2$3" ]; then echo "connect robot $1 alone, then press Enter"; read -r _; fi
if [ -z "$2" ] && [ -n "$3" ]; then scp "$3":robot.log "logs/robot-$1.part"
else mpremote connect "${2:-auto}" cp :robot.log "logs/robot-$1.part"; fi
if [ -e "logs/robot-$1.log" ] && ! cmp -s "logs/robot-$1.log" "logs/robot-$1.part"; then
    old="logs/robot-$1.log.$(date +%Y-%m-%dT%H-%M-%S)"
    mv "logs/robot-$1.log" "$old"
    echo "the earlier log is kept as $old"
fi
mv "logs/robot-$1.part" logs/robot-"$1".log
