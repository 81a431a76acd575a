"""Spreads: distributions of accuracies over a swarm. Each file in this folder is one.

`quantile(u, a, b)` turns uniform numbers, an array in (0, 1), into accuracies in [0, 1], or into errors in [-1, 1]. The
parameters after the first are the numbers in brackets of a study file's "beta(8, 2)". Further, if needed:

- `check(a, b)` raises ValueError for numbers that make no distribution.

Another package adds a spread by an entry point of the group `swarmcensus.spreads`. Files in this
folder also have:

- `LETTER`: the name in study files and datasets, after the paper;
- `moments(a, b)`, optional: the mean and the standard deviation, in place of those of many quantiles;
- `draw(key, first_trial, out, a, b)`, optional: fills accuracies (trial, robot) at an address (two uint64);
- `error(u, a, b)` and `centre(a, b)`, with `draw` and without `quantile`, if one uniform number is not enough for one
  value: `error` turns two of them, (2, trial, robot), into an error; `centre` is what must be in bounds.
"""
