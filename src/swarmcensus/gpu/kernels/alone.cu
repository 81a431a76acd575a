// Local estimates, observation by observation: nobody hears anything. `rounds` counts observations.
KERNEL(alone) {
    PHASE {
        const int64_t n = BLOCK * THREADS + thread;
        if (n < given.trials * given.robots) {
            Place at = {};
            at.trial = n / given.robots, at.i = n % given.robots;
            at.group = group_of(given, at.trial, at.i);
            Robot me;
            begin(me, given, at);
            double blacks = 0.0;
            for (int64_t k = 1; k <= given.rounds; k++) {
                const int64_t left = given.looks - (k - 1) % given.looks, tick = (k - 1) / given.looks + 1;
                if (left == given.looks) {
#if CHANGES
                    if (tick > 1) {
                        renew(given, at.trial, at.i, tick);
                    }
#endif
                    blacks = blacks_of(given, at.trial, at.i, tick);
                }
                const int64_t trial = given.first + at.trial;
                const bool black = unit_of(word_for(given.order_key, trial, k, 0, at.i)) * (double)left < blacks;
                blacks -= black;
#if LUCKY
                const uint64_t *key = given.luck_key;
#endif
                if (works(given, at.trial, SENSING, at.i, tick) && !robot_done(me.brains, at.group)) {
#if LUCKY
                    robot_luck(me.brains, at.group, luck_of(word_for(key, trial, k, 3, at.i)));
#endif
                    robot_look(me.brains, at.group, black, 1.0);
                }
#if LUCKY
                robot_luck(me.brains, at.group, luck_of(word_for(key, trial, k, 4, at.i)));
#endif
                robot_fuse(me.brains, at.group);
                note_estimate(given, at, k, robot_estimate(me.brains, at.group));
            }
        }
    }
}
