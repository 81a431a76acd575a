"""What every room uses and none owns: errors, files, hints, times, digits, intervals over trials, the terminal.

In: plain values.
Out: plain values, text, InputError.
Must not know: any other room.
"""
