"""What every room uses and none owns: errors, files, doors, hints, times, digits, bins, intervals, the terminal.

In: plain values.
Out: plain values, text, InputError.
Must not know: any other room.
"""
