"""The live page: one trial that is computed while it is watched in a browser, or recorded in one HTML file.

In: a study or results; requests of a page.
Out: frames as bytes, the memory of a robot as JSON, a server on loopback, an HTML file.
Must not know: the command line; how a page draws.
"""
