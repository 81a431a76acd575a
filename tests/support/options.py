"""Options of commands that a test gives, and the usual ones."""


def with_usual(given, usual):
    """The options that are given, and those of the usual ones, each with a value, that they do not name."""
    pairs = zip(usual[::2], usual[1::2], strict=True)
    return [*given, *(word for pair in pairs if pair[0] not in given for word in pair)]
