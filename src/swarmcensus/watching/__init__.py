"""The live page: one trial computed while it is watched, in a browser, or written into one file.

In: a study, or results; what a page asks for.
Out: frames as bytes, what a robot holds as JSON, a server on loopback, an HTML file.
Must not know: the command line; how a page draws.
"""
