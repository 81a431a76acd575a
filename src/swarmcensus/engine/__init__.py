"""Compiles brains, addresses random numbers, runs worlds. Knows nothing of studies."""
