"""Everyone hears everyone (paper, Sec. IV-B)."""

EVERYONE = True
