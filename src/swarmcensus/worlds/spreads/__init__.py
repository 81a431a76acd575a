"""Spreads of accuracies over a swarm, one file each, and each found because it lies here.

`quantile(u, a, b)` turns uniform numbers, an array in (0, 1), into accuracies in [0, 1], or into errors in [-1, 1]; the
parameters after the first are the numbers in the brackets of a study file's "beta(8, 2)". Where a file needs it:

- `check(a, b)` raises ValueError for numbers that mean nothing.

Another package adds a spread by an entry point of the group `swarmcensus.spreads`. Files here may further have:

- `LETTER`, which all of them have: what study files and datasets call it, after the paper;
- `draw(key, first_trial, out, a, b)` fills accuracies (trial, robot) in another way, at an address (two uint64);
- `error(u, a, b)` and `centre(a, b)`, with `draw` in place of `quantile`, where one uniform number does not make one
  value: the first turns two of them, (2, trial, robot), into an error, the second is what must lie in bounds.
"""
