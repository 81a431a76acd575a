from .paper import report as report, reproducing as reproducing
from .paper.page import Reproduction as Reproduction
from .paper.reproducing import reproduce as reproduce
from .ranking.board import Board as Board, leaderboard as leaderboard
from .ranking.table import flat as flat, print_board as print_board, rows as rows, sentences as sentences
