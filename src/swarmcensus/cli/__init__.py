"""The command line: options parsed, packages called, tables printed. Imports wait until a command needs them.

In: arguments.
Out: an exit code, what is printed.
Must not know: mathematics.
"""
