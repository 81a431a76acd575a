"""Small helpers for all packages: errors, files, plugins, text; statistics of trials; names of what is measured.

In: plain values and arrays.
Out: plain values, text, InputError; intervals, p-values and ranks; `QUANTITIES`.
Must not know: any other package.
"""
