// What kernels look up in what they are given.

PART bool is_honest(const Given &given, int64_t trial, int64_t i) {
    return given.liars == 0 || given.honest[trial * given.robots + i];
}
