"""Self-taught: commons of robots that may be wrong about their sensors; who does not fit takes its evidence back.

With k = b + w - 1, as told, a robot of n black of t readings believes by itself in x = (n/t - 1 + w)/k, with a variance
of at most e = 1/(4 k^2 t). It puts three numbers into sums that all mix as those of `commons` do:

    g, g x, g (x^2 - e)    with    g = 1/(e + d);    f = s/v;    d <- max(0, m/v - f^2), smoothed

d is by how much more robots differ than by chance, as in a random-effects mean (DerSimonian, Laird, 1986): where all
agree d is 0 and this is commons; where they do not, no robot counts for more than 1/d, however much it has seen. What a
robot has put in it remembers and renews: all fades by 1/memory a round, and what is missing is put in, or too much is
taken back, little by little: a haul at once would leave the others' x behind, and mislead whoever looks.

    does not fit    where (x - f)^2 > z^2 e + apart d,  or x lies outside [0, 1] by more than z sqrt(e)
    fits again      where (x - f)^2 and the way outside, squared, are below a quarter of that, or nobody vouches for f

Who does not fit takes its g down to 0 in steps; b = w = (n/t + f - 1)/(2 f - 1) is what the swarm makes of its sensor.
Of a share p that is wrong by D, all alike, (x - f)^2 = (1 - p)^2 D^2 and d = p (1 - p) D^2: they go where (1 - p)/p is
above `apart`, and who is right then stays. Where about half are wrong alike nothing can be known.
"""

STEP = 0.02  # share of its evidence that a robot takes back, or puts in again, in a round
LEAST = 1e-6  # of the own weight: where less than that is left of all, nobody vouches for anything

PARAMETERS = {
    "z": 4.0,  # standard deviations that chance explains
    "apart": 1.2,  # in units of d, from where on a robot does not fit
    "memory": 1000.0,  # rounds after which what was put in has faded
}
MEMORY = {
    "t": 0.0,  # observations made
    "n": 0.0,  # of which said black
    "out": 0.0,  # 1: it does not fit
    "part": 1.0,  # of its evidence that is to count: falls to 0 while out, rises to 1 else
    "accuracy": 0.5,  # b = w, as the swarm has it, while out
    "s": 0.0,  # mixed: weights times estimates
    "v": 0.0,  # weights
    "m": 0.0,  # weights times squares, less what chance makes of them
    "x": 0.5,  # estimate
    "spread": 0.0,  # d, smoothed
    "given_s": 0.0,  # what it has put into these itself
    "given_v": 0.0,
    "given_m": 0.0,
    "heard": 0.0,  # messages since the last round
    "heard_s": 0.0,  # the sums in them
    "heard_v": 0.0,
    "heard_m": 0.0,
}
MESSAGE = ("s", "v", "m")
ROLES = {"s": "information", "v": "confidence"}
SUMS = ("heard", "heard_s", "heard_v", "heard_m")


def observe(me, blacks, looks):
    """Count."""
    me.t += looks
    me.n += blacks


def broadcast(me):
    """The sums."""
    return me.s, me.v, me.m


def receive(me, message):
    """A neighbour's sums."""
    s, v, m = message
    me.heard += 1.0
    me.heard_s += s
    me.heard_v += v
    me.heard_m += m


def fuse(me):
    """The mean of all voices, faded; then see whether it fits, and put in or take back."""
    keep = 1.0 - 1.0 / max(me.memory, 1.0)
    share = keep / (1.0 + me.heard)
    me.s = share * (me.s + me.heard_s)
    me.v = share * (me.v + me.heard_v)
    me.m = share * (me.m + me.heard_m)
    me.given_s *= keep
    me.given_v *= keep
    me.given_m *= keep
    me.heard = 0.0
    me.heard_s = 0.0
    me.heard_v = 0.0
    me.heard_m = 0.0
    me.x = ratio(me)
    slope = me.b + me.w - 1.0
    if me.t == 0.0 or abs(slope) < 1e-12:
        return
    x = (me.n / me.t - 1.0 + me.w) / slope
    chance = 0.25 / (slope * slope * me.t)
    alone = me.v <= 0.0
    if not alone:
        f = me.s / me.v
        spread = max(me.m / me.v - f * f, 0.0)
        me.spread += STEP * (spread - me.spread)
        judge(me, x, chance, f, max(spread, me.spread))
        me.part = min(max(me.part + STEP * (1.0 - 2.0 * me.out), 0.0), 1.0)
    give(me, x, chance)
    if alone:
        me.x = ratio(me)


def judge(me, x, chance, f, spread):
    """Withdraw, or return, and learn what the swarm makes of the sensor."""
    most = me.z * me.z * chance
    limit = most + me.apart * spread
    off = (x - f) * (x - f)
    beyond = max(x - 1.0, -x, 0.0)
    if me.v * (chance + me.spread) < LEAST and beyond * beyond <= most:
        me.out = 0.0
    elif off > limit or beyond * beyond > most:
        me.out = 1.0
    elif off < 0.25 * limit and beyond * beyond < 0.25 * most:
        me.out = 0.0
    me.accuracy = 0.5 * (me.b + me.w)
    if me.out > 0.0 and abs(2.0 * f - 1.0) > 1e-12:
        me.accuracy = min(max((me.n / me.t + f - 1.0) / (2.0 * f - 1.0), 0.0), 1.0)


def give(me, x, chance):
    """Put in what is missing from the own evidence, or take back some of what is too much."""
    weight = me.part / (chance + me.spread)
    s = weight * x - me.given_s
    v = weight - me.given_v
    m = weight * (x * x - chance) - me.given_m
    part = 1.0
    most = min(STEP * me.given_v, 0.5 * me.v)
    if v < -most:
        part = most / -v
    me.s += part * s
    me.v += part * v
    me.m += part * m
    me.given_s += part * s
    me.given_v += part * v
    me.given_m += part * m


def ratio(me):
    """The ratio of the sums, with the prior of commons, in [0, 1]."""
    if me.v <= 0.0:
        return 0.5
    prior = min(1.0, 1.0 / me.v)
    return min(max((me.s + 0.5 * prior) / (me.v + prior), 0.0), 1.0)


def estimate(me):
    """The ratio before this round's own readings, which would weigh too much until they are mixed."""
    return me.x
