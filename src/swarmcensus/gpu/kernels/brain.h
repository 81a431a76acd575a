// What every brain has for the kernels, around its own functions. Its parts are written by source.py.

BRAIN_PART void robot_start(struct brain *me, const number *blank, int64_t i, double b, double w) {
    number *numbers = (number *)me;
    BRAIN_EACH_NUMBER {
        numbers[n] = blank[n];
    }
    me->b = (number)b;
    me->w = (number)w;
    ${name}
}

BRAIN_PART int32_t robot_say(struct brain *me, number *out, int64_t &clipped) {
    ${jam}
    struct message message;
    if (!broadcast(me, &message)) {
        ${quiet}
        return ${silent};
    }
    ${coded}
    ${kept}
    return ${said};
}

BRAIN_PART void robot_take(struct brain *me, const number *in) {
    ${taken}
}

BRAIN_PART void robot_get_sums(struct brain *me, number *out) {
    ${sums}
}

BRAIN_PART void robot_set_sums(struct brain *me, const number *in) {
    ${put}
}

BRAIN_PART void robot_add_sums(struct brain *me, const number *in, int64_t apart) {
    ${added}
}

BRAIN_PART void robot_luck(struct brain *me, number luck) {
    ${luck}
}

BRAIN_PART void robot_look(struct brain *me, double blacks, double looks) { observe(me, (number)blacks, (number)looks); }

BRAIN_PART void robot_fuse(struct brain *me) { fuse(me); }

BRAIN_PART double robot_estimate(struct brain *me) { return (double)estimate(me); }

BRAIN_PART double robot_decide(struct brain *me) { return ${decide}; }

BRAIN_PART bool robot_done(struct brain *me) { return ${done}; }

BRAIN_PART void robot_bound(struct brain *me, double *low, double *high) {
    ${bound}
}
