"""A full network: every robot hears every other (paper, Sec. IV-B)."""

EVERYONE = True
