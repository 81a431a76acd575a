# Runs in MicroPython: brains live in a recorded world. In place of the line REFERENCE stand functions of the package as
# they are: of its CPython reference, for the order of calls, and of its adversaries, for what liars say.
import builtins
import json
import math
from array import array
from collections import OrderedDict, deque, namedtuple

import page

JAMS, NONE, SLACK = "jams", float("nan"), 1e-6
DRAW_OBSERVE, DRAW_FUSE, DRAW_STEER = range(3)
Field = namedtuple("Field", ("name", "role", "length"))
_zip = zip
ONLY = "me.%s: a robot has only b, w and the fields of MEMORY and PARAMETERS"


class Thing:
    def __getattr__(self, name):
        raise AttributeError(ONLY % name)


np = Thing()
np.isnan, np.uint64, chance = lambda x: x != x, lambda x: x, lambda x: x


def zip(*them, strict=True):  # MicroPython's knows no keywords
    return _zip(*them)


def reversed(items):  # MicroPython's takes only a sequence
    return list(items)[::-1]


def own_draws(swarm, trial, number, part, robots):  # nobody steers here
    return [page.luck(0, swarm.tick, part, i) for i in range(robots)] if swarm.luck and part != DRAW_STEER else ()


def word_of(key, _, trial, tick, receiver, sender):
    return page.luck(1, tick, receiver, sender)


# REFERENCE


def fault(source, part, text):
    """What is wrong with a brain, with the line in which a part of it first is."""
    line = source[: source.find(part)].count("\n") + 1
    return ValueError('File "brain.py", line %d\n%s' % (line, text))


def importing(name, *more):
    if name != "math":
        raise ImportError("a brain may import only math")
    return math


def content(name):
    with open(name, "rb") as file:
        return file.read()


def run(name):
    """The names that a file defines, and its source."""
    names = {"source": content(name).decode()}
    exec(compile(names["source"], name, "exec"), names)
    return names


def blank(names):
    """A state with the fields of a file."""
    me = Thing()
    for table in (names.get("MEMORY", {}), names.get("PARAMETERS", {})):
        for field, value in table.items():
            setattr(me, field, list(value) if isinstance(value, (tuple, list)) else 1.0 * value)
    return me


def fields_of(names):
    """The fields of a brain's message; dicts of MicroPython have no order."""
    message, source = names["MESSAGE"], names["source"]
    roles = names.get("ROLES", {name: role for role, usual in ROLES.items() for name in usual})
    lengths = message if isinstance(message, dict) else names["MEMORY"]
    if lengths is message:
        message = sorted(message, key=lambda name: source.find('"%s"' % name, source.find("MESSAGE")))
    values = [lengths.get(name, 0.0) for name in message]
    sizes = [len(value) if isinstance(value, (tuple, list)) else 0 for value in values]
    return [Field(name, roles.get(name, ""), size) for name, size in zip(message, sizes)]


def lying(brain, lies):
    """The names of a brain that an adversary wraps; its own state is `me.liar`."""
    fields, knows, names = fields_of(brain), lies.get("KNOWS", ()), dict(brain)
    if not any(field.role in VALUES for field in fields):
        raise ValueError("the adversary cannot lie: no field of MESSAGE is known to be one of " + ", ".join(VALUES))
    optional = {name for name in lies if name in MAY_HAVE or name.startswith(SAYS)}

    def of(function):
        def call(me, *given):
            own = me.liar
            own.b, own.w, own.name, own.luck = me.b, me.w, me.name, me.luck * 1048576.0 % 1.0
            for field in knows:
                setattr(own, field, getattr(me, field, 0.0))
            return function(own, *given)

        return call

    names.update({"honest_" + name: function for name, function in brain.items()})
    names.update({"liar_" + name: of(lies[name]) for name in optional | {"lie"}})
    exec(functions_source(fields, optional, ("liar_", "honest_", "worn_"), brain.get("OPTIONS", 2), True, False), names)
    names["source"] += lies["source"]
    return names


class Brain:
    """A brain as the reference takes it."""

    def __init__(self, names):
        for name in ("MEMORY", "MESSAGE", "observe", "broadcast", "receive", "fuse", "estimate"):
            if name not in names:
                raise ValueError(name + " is missing")
        if not isinstance(names["MESSAGE"], (tuple, dict)):
            text = "MESSAGE is %r: should be a tuple of names, of one name such as ('x',)" % (names["MESSAGE"],)
            raise fault(names["source"], "MESSAGE", text)
        self.functions, self.uses, self.luck = Thing(), self, ".luck" in names["source"]
        self.ends, self.jams = "done" in names, "jam" in names
        for name, value in names.items():
            setattr(self.functions, name, value)


class Swarm:
    """The robots of a world, which go on from tick to tick."""

    def __init__(self, job):
        names, liars, robots = run("brain.py"), job["liars"], job["robots"]
        own, lies = Brain(names), run("adversary.py") if liars else {}
        self.source, self.size = names["source"], len(names["MESSAGE"])
        liar = Brain(lying(names, lies)) if liars else own
        self.looks, self.tick, self.at, self.luck = float(job["looks"]), 0, 0, own.luck or liar.luck
        self.brains = [liar if i in liars else own for i in range(robots)]
        self.states = [blank(names) for _ in self.brains]
        for i, me in enumerate(self.states):
            me.b, me.w, me.name, me.luck, me.liar = job["accuracy"], job["accuracy"], float(i), 0.5, blank(lies)
        self.honest = [me for i, me in enumerate(self.states) if i not in liars]
        self.fields = set(self.honest[0].__dict__)
        self.blacks, self.pairs, self.counts = content("blacks"), content("pairs"), array("H", content("counts"))
        self.estimates, self.spoke = array("d", [self.believes(i) for i in range(robots)]), bytearray()
        # robots that move also hear messages from before the first tick
        first = [message_by(brain, me) for brain, me in zip(self.brains, self.states)] if job["delay"] else None
        self.said = deque([first] if first else [], job["delay"] + 1)

    def __getitem__(self, k):  # where the reference looks for keys
        return 0

    def believes(self, i):
        """The estimate of a robot."""
        x = self.brains[i].functions.estimate(self.states[i])
        if not -SLACK <= x <= 1.0 + SLACK:
            raise ValueError("estimate gives %r to robot %d after tick %d: should be in [0, 1]" % (x, i, self.tick))
        return x

    def heard(self, said):
        """The messages that arrive, as the reference wants them."""
        news, pairs, place = said[0], self.pairs, ()
        wrong = [said for said in news if speaks(said) and not (isinstance(said, tuple) and len(said) == self.size)]
        if wrong:
            text = "broadcast gives %r, not a tuple of %d as MESSAGE says" % (wrong[0], self.size)
            raise fault(self.source, "def broadcast", text)
        drowned = [pairs[k] for k in self.here if news[pairs[k + 1]] is JAMS] if JAMS in news else ()
        for k in self.here:
            receiver, message = pairs[k], news[pairs[k + 1]]
            if message is not None and message is not JAMS and receiver not in drowned:
                if self.luck:
                    place = 0, self.tick, receiver, pairs[k + 1]
                yield receiver, message, place

    def steps(self, many):
        """The next ticks."""
        step, robots, moves = Thing(), len(self.brains), len(self.counts) > 1
        step.looks, step.heard, step.begins, step.ends = self.looks, self.heard, True, True
        for _ in range(many):
            row = self.blacks[self.tick * robots : (self.tick + 1) * robots]
            step.blacks = [NONE if k == 255 else float(k) for k in row]
            self.here = range(self.at, self.at + 2 * self.counts[self.tick if moves else 0], 2)
            self.at, self.tick = self.at + 2 * len(self.here) if moves else 0, self.tick + 1
            yield step
            self.spoke.extend(bytes([speaks(message) for message in self.said[-1]]))

    def go(self, many):
        """Live so many ticks, and write what robots believe, and which of them spoke."""
        believe = lambda i, _: self.estimates.append(self.believes(i))
        live(self.brains, self.states, self.steps(many), self, 0, self.said, believe)
        for me in self.honest:
            for field in set(me.__dict__) - self.fields:
                raise fault(self.source, "." + field, ONLY % field)
        for name, values in (("estimates", self.estimates), ("spoke", self.spoke)):
            with open(name, "wb") as file:
                file.write(values)
        self.estimates, self.spoke = array("d"), bytearray()


builtins.__import__ = importing
SWARM = Swarm(json.loads(content("job")))
