"""Forger: it says `value` under another name each round, one of so many `names`, and so counts as many robots."""

PARAMETERS = {"value": 1.0, "names": 1000000.0}
MEMORY = {"alias": -1.0}  # below 0: its own name, for it has none yet


def lie(me, x):
    return me.value


def forge(me, name):
    return name if me.alias < 0.0 else me.alias


def plot(me):
    me.alias = float(int(me.luck * me.names))
