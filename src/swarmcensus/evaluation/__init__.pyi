from .paper import reproducing as reproducing
from .paper.report import Reproduction as Reproduction
from .paper.reproducing import reproduce as reproduce
from .ranking.board import Board as Board, leaderboard as leaderboard
