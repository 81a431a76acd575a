"""Random: in each round, all white or all black at random; with uniform = 1, any number in [0, 1]."""

PARAMETERS = {"uniform": 0.0}
MEMORY = {"said": -1.0}  # below 0: nothing is drawn yet


def lie(me, x):
    return x if me.said < 0.0 else me.said


def plot(me):
    me.said = me.luck if me.uniform > 0.5 else float(int(2.0 * me.luck))
