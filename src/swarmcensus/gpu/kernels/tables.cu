// The tables that readings of one round are drawn by.

KERNEL(tables) {
    PHASE {
        const int64_t n = BLOCK * THREADS + thread;
        if (n < given.tables_made * given.sensors) {
            renew(given, n / given.sensors, n % given.sensors, given.k);
        }
    }
}
