from .paper import reproducing as reproducing
from .paper.report import Reproduction as Reproduction
from .paper.reproducing import reproduce as reproduce
from .ranking import Leaderboard as Leaderboard, leaderboard as leaderboard
