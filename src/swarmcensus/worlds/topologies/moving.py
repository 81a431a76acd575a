"""No fixed network: robots walk in an arena and hear those nearby (paper, Sec. IV-C; see arena.py, bodies.py)."""

MOVES = True
