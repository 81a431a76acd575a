"""No fixed network: robots walk in an arena and hear whom they meet (paper, Sec. IV-C; see arena.py, bodies.py)."""

MOVES = True
