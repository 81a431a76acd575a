"""Always black: whatever it sees and hears, it says that all is black."""


def lie(me, x):
    return 1.0
