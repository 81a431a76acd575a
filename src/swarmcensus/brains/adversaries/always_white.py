"""Always white: whatever it sees and hears, it says that all is white."""


def lie(me, x):
    return 0.0
