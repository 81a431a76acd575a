# Runs in MicroPython: brains live in a recorded world. The page puts functions of the package behind the class `np`,
# as they are: the order of calls is that of swarmcensus.simulation.reference, and liars are made as in its brains.
import builtins
import json
from array import array
from collections import OrderedDict, deque, namedtuple

import page

JAMS, NONE, SLACK = "jams", float("nan"), 1e-6
DRAW_OBSERVE, DRAW_FUSE, DRAW_STEER = range(3)
Field = namedtuple("Field", ("name", "role", "length"))
Prefixes = namedtuple("Prefixes", ("own", "honest", "helper"))
_zip = zip


class np:
    isnan = staticmethod(lambda x: x != x)
    uint64 = chance = staticmethod(lambda x: x)


chance = np.chance


def zip(*them, strict=True):  # MicroPython's knows no keywords
    return _zip(*them)


def reversed(items):  # MicroPython's wants a sequence
    return list(items)[::-1]


def own_draws(swarm, trial, number, part, robots):  # nobody steers here
    return [page.luck(0, swarm.tick, part, i) for i in range(robots)] if swarm.luck and part != DRAW_STEER else ()


def word_of(key, _, trial, tick, receiver, sender):
    return page.luck(1, tick, receiver, sender)


# REFERENCE


class Thing:
    pass


def content(name):
    with open(name, "rb") as file:
        return file.read()


def filled(state, *tables):
    """A state with the fields of these tables."""
    for table in tables:
        for field, value in table.items():
            setattr(state, field, list(value) if isinstance(value, (tuple, list)) else 1.0 * value)
    return state


class Program:
    """A file, run: its functions, and its constants."""

    def __init__(self, name):
        self.source, self.names = content(name).decode(), {}
        exec(compile(self.source, name, "exec"), self.names)
        self.tables = self.names.get("MEMORY", {}), self.names.get("PARAMETERS", {})


class Brain:
    """A brain as the reference takes it; `names` are those of its file, with a liar's functions in place of some."""

    def __init__(self, program, luck, names, more=lambda me: me):
        self.program, self.uses, self.functions, self.more = program, Thing(), Thing(), more
        self.uses.luck, self.ends, self.jams = luck, "done" in names, "jam" in names
        for name in ("MEMORY", "MESSAGE", "observe", "broadcast", "receive", "fuse", "estimate"):
            if name not in names:
                raise ValueError("%s is missing" % name)
        for name in names:
            setattr(self.functions, name, names[name])

    def robot(self, accuracy, name):
        """A blank state."""
        me = filled(Thing(), *self.program.tables)
        me.b, me.w, me.name, me.luck = accuracy, accuracy, name, 0.5
        return self.more(me)


def fields_of(program):
    """The fields of messages."""
    message, memory, said = program.names["MESSAGE"], program.tables[0], []
    roles = program.names.get("ROLES", {name: role for role, names in ROLES.items() for name in names})
    # dicts of MicroPython have no order
    begin = program.source.find("MESSAGE")
    names = sorted(message, key=lambda name: program.source.find('"%s"' % name, begin)) if isinstance(message, dict) else message
    for name in names:
        value = message[name] if isinstance(message, dict) else memory.get(name, 0.0)
        said.append(Field(name, roles.get(name, ""), len(value) if isinstance(value, (tuple, list)) else 0))
    return said


def lying(program, lies):
    """A brain that an adversary wraps."""
    names, knows = dict(program.names), lies.names.get("KNOWS", ())
    optional = {name for name in lies.names if name in MAY_HAVE or name.startswith(SAYS)}

    def of(function):
        def call(me, *given):
            own = me.liar
            own.b, own.w, own.name, own.luck = me.b, me.w, me.name, me.luck * 1048576.0 % 1.0
            for field in knows:
                setattr(own, field, getattr(me, field, 0.0))
            return function(own, *given)

        return call

    for name, function in program.names.items():
        names["honest_" + name] = function
    for name in optional | {"lie"}:
        names["liar_" + name] = of(lies.names[name])
    fields = fields_of(program)
    if not [field for field in fields if field.role in VALUES]:
        raise ValueError("the adversary cannot lie: no field of MESSAGE is known to be one of " + ", ".join(VALUES))
    source = functions_source(fields, optional, Prefixes("liar_", "honest_", "worn_"), names.get("OPTIONS", 2), True, False)
    exec(source, names)

    def more(me):
        me.liar = filled(Thing(), *lies.tables)
        return me

    return Brain(program, ".luck" in program.source or ".luck" in lies.source, names, more)


class Swarm:
    """The robots of a world, which go on from tick to tick."""

    def __init__(self, job):
        program = Program("brain.py")
        own = Brain(program, ".luck" in program.source, program.names)
        liar = lying(program, Program("adversary.py")) if job["liars"] else own
        self.robots, self.looks, self.tick, self.at = job["robots"], float(job["looks"]), 0, 0
        self.brains = [liar if i in job["liars"] else own for i in range(self.robots)]
        self.states = [brain.robot(job["accuracy"], float(i)) for i, brain in enumerate(self.brains)]
        self.blacks, self.pairs, self.counts = content("blacks"), content("pairs"), array("H", content("counts"))
        self.luck, self.spoke = own.uses.luck or liar.uses.luck, bytearray()
        self.said = deque([], job["delay"] + 1)
        if job["delay"]:  # robots that move also hear messages from before the first tick
            self.said.append([message_by(brain, me) for brain, me in zip(self.brains, self.states)])

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
        drowned = [pairs[k] for k in self.here if news[pairs[k + 1]] is JAMS] if JAMS in news else ()
        for k in self.here:
            receiver, message = pairs[k], news[pairs[k + 1]]
            if message is not None and message is not JAMS and receiver not in drowned:
                if self.luck:
                    place = 0, self.tick, receiver, pairs[k + 1]
                yield receiver, message, place

    def steps(self, many):
        """The next ticks."""
        step = Thing()
        step.looks, step.heard, step.begins, step.ends = self.looks, self.heard, True, True
        for _ in range(many):
            row, moves = self.tick * self.robots, len(self.counts) > 1
            step.blacks = [NONE if k == 255 else float(k) for k in self.blacks[row : row + self.robots]]
            end = self.at + 2 * self.counts[self.tick if moves else 0]
            self.here = range(self.at, end, 2)
            self.at, self.tick = end if moves else 0, self.tick + 1
            yield step
            self.spoke.extend(bytes([speaks(message) for message in self.said[-1]]))

    def go(self, many):
        """Live so many ticks, and write what robots believe, and which of them spoke."""
        self.spoke = bytearray()
        estimates = array("d", [] if self.tick else [self.believes(i) for i in range(self.robots)])
        live(self.brains, self.states, self.steps(many), self, 0, self.said, lambda i, _: estimates.append(self.believes(i)))
        for name, values in (("estimates", estimates), ("spoke", self.spoke)):
            with open(name, "wb") as file:
                file.write(values)


def importing(name, *more, own=__import__):
    if name != "math":
        raise ImportError("a brain may import only math")
    return own(name, *more)


builtins.__import__ = importing
SWARM = Swarm(json.loads(content("job")))
