"""Spreads of accuracies over a swarm, one file each, and each found because it lies here.

`quantile(u, a, b)` turns uniform numbers, an array in (0, 1), into accuracies in [0, 1], or into errors in [-1, 1]; the
parameters after the first are the numbers in the brackets of a study file's "beta(8, 2)". Where a file needs it:

- `check(a, b)` raises ValueError for numbers that mean nothing;
- `LETTER` is what it is called in study files in place of its own name;
- `draw(key, first_trial, out, a, b)` and `error(u, a, b)` instead of `quantile`, where one uniform number does not make
  one value: they fill accuracies (trial, robot), and turn two uniform numbers, (2, trial, robot), into an error;
  `centre(a, b)` is then what lies in bounds for certain.

Another package adds a spread by an entry point of the group `swarmcensus.spreads`.
"""
