"""Small helpers for all packages: errors, files, plugins, hints, times, numbers as text, bins, the terminal.

In: plain values.
Out: plain values, text, InputError.
Must not know: any other room.
"""
