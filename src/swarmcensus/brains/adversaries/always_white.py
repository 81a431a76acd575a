"""Always white: it always says that everything is white."""


def lie(me, x):
    return 0.0
