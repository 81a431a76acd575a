"""Jammer: it makes noise in a share `often` of the rounds, in which robots near it hear nothing; else it is honest."""

PARAMETERS = {"often": 1.0}
MEMORY = {"lot": 0.0}  # 0: it jams in the first round, if `often` is above 0


def lie(me, x):
    return x


def jam(me):
    return me.lot < me.often


def plot(me):
    me.lot = me.luck
