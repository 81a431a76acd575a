"""Always black: it always says that everything is black."""


def lie(me, x):
    return 1.0
