"""Jammer: noise in a share `often` of the rounds; whom it reaches hears nothing then. In the others it is honest."""

PARAMETERS = {"often": 1.0}
MEMORY = {"lot": 0.0}  # in the first round it jams, if ever


def lie(me, x):
    return x


def jam(me):
    return me.lot < me.often


def plot(me):
    me.lot = me.luck
