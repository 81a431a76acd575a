"""Forger: it says `value` under a new name each round, one of `names` names, and so counts as many robots."""

PARAMETERS = {"value": 1.0, "names": 1000000.0}
MEMORY = {"alias": -1.0}  # below 0: no name is forged yet, and it uses its own


def lie(me, x):
    return me.value


def forge(me, name):
    return name if me.alias < 0.0 else me.alias


def plot(me):
    me.alias = float(int(me.luck * me.names))
