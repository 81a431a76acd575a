from . import theory as theory
from .analysis import (
    Agreement as Agreement,
    Comparison as Comparison,
    Explanation as Explanation,
    Interaction as Interaction,
    compare as compare,
    explain as explain,
)
from .brains import Brain as Brain
from .checks import Conformance as Conformance, check as check
from .evaluation import (
    Leaderboard as Leaderboard,
    Reproduction as Reproduction,
    leaderboard as leaderboard,
    reproduce as reproduce,
)
from .figures import plot as plot
from .live import Watching as Watching, watch as watch
from .results import frame as frame, load as load, merge as merge, save as save
from .robots import calibrate as calibrate, deploy as deploy
from .runs import Verification as Verification, run as run, verify as verify
from .search import Plan as Plan, Tuned as Tuned, plan as plan, tune as tune
from .simulation import infer as infer
from .studies import (
    Measure as Measure,
    Members as Members,
    Schedule as Schedule,
    Setting as Setting,
    Study as Study,
    Swarm as Swarm,
    Until as Until,
    World as World,
)
from .summaries import replay as replay, summary as summary
from .support.errors import InputError as InputError, Interrupted as Interrupted
from .support.version import __version__ as __version__
from .worlds import Body as Body, Fault as Fault
