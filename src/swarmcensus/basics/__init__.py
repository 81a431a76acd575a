"""What every room uses and none owns: errors, files, plain files, doors, hints, times, digits, intervals, the terminal.

In: plain values.
Out: plain values, text, InputError.
Must not know: any other room.
"""
