from .planning.mission import missions_of as missions_of, tables_of as tables_of
from .planning.planning import plan as plan
from .planning.plans import Need as Need, Plan as Plan
from .tuning.logs import (
    Candidates as Candidates,
    candidates_in as candidates_in,
    is_log as is_log,
)
from .tuning.targets import target_of as target_of
from .tuning.tuning import Tuned as Tuned, files_of as files_of, tune as tune
