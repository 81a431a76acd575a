def clock():
    """Milliseconds, on boards and on computers."""
    if hasattr(time, "ticks_ms"):
        return time.ticks_ms()
    return int(time.monotonic() * 1000) & WRAP


def own_number():
    """The robot's number, or one made of the chip's: two robots have the same by a chance of 1 in 65536."""
    if settings.NUMBER is not None:
        return settings.NUMBER
    try:
        import machine
    except ImportError:
        raise SystemExit(
            "NUMBER in settings.py should be this robot's: a computer has no chip that tells one"
        ) from None

    return crc32(machine.unique_id()) & 0xFFFF


def quietly(call):
    """Call what some boards cannot do."""
    try:  # noqa: SIM105 - boards have no contextlib
        call()
    except Exception:
        pass


def seed(number, boot):
    """Have random numbers of its own for each robot and boot; some boards begin with the same at every start."""
    noise = os.urandom(8) if hasattr(os, "urandom") else b""
    random.seed(crc32(noise + b"%d %d" % (number, boot)))


def made(sensor, radio, number, clock=clock, memory="memory", log="robot.log"):
    """The robot, with the memory that it saved; `memory` and `log` are files."""
    s = settings
    if s.B is None or s.W is None:
        raise SystemExit("B and W in settings.py should be those of this sensor: calibrate.py counts for them")
    messages = Messages(s.LENGTHS, s.PLAN, s.MARK, s.CHECKED)
    robot = Robot(
        brain, messages, sensor, radio, clock, s.B, s.W, number, s.PERIOD, s.READINGS, s.PARAMETERS,
        random.random if s.LUCK else None,
    )  # fmt: skip
    robot.keep(memory, s.SAVE_EVERY)
    if s.LUCK:
        seed(robot.number, robot.boot)
    kept, reported = getattr(s, "LOG", None), getattr(s, "REPORT", None)
    if kept or reported:
        from log import Log

        now = 0 if hasattr(time, "ticks_ms") else int(time.time() * 1000)  # a board seldom knows the date
        is_single = 1.0 + 2.0**-30 == 1.0
        robot.record(Log(log if kept else None, s.HASH, s.FORM, now, kept, is_single, s.HOLD))
    return robot


def reports_of(robot):
    """Its reports to those who watch, if there are any: it waits until they start it."""
    if not getattr(settings, "REPORT", None):
        return None
    from reports import Reports

    return Reports(settings.REPORT, robot)


def main():
    """Run for ever; a line every hundred ticks tells how the robot is."""
    robot = made(Sensor(), Radio, own_number())  # the class, so that the robot tries again if it cannot be made
    # dog = machine.WDT(timeout=8000)  # restarts the board if a sensor or a radio never returns
    reported, reports = robot.ticks, reports_of(robot)
    try:
        while True:
            if reports and not reports.obey():
                time.sleep(0.2)
                continue
            time.sleep(robot.poll() / 1000)
            # dog.feed()
            if robot.ticks >= reported + 100:
                reported = robot.ticks
                print(robot.status() + (f" log_faults {robot.log.faults}" if robot.log else ""))
                if robot.trouble:
                    print(f"last trouble: {robot.trouble}")
                    robot.trouble = None
    finally:
        if robot.log:
            robot.log.close()


if __name__ == "__main__":
    main()
