from .comparing import comparison as comparison
from .comparing.cells import column_head as column_head, p_equals as p_equals
from .comparing.comparison import Comparison as Comparison, compare as compare, compare_dataset as compare_dataset
from .comparing.contenders import grid_of as grid_of
from .comparing.effects import Effect as Effect, effects as effects
from .comparing.interactions import Interaction as Interaction
from .comparing.pair_tests import (
    ContestInput as ContestInput,
    contests as contests,
    in_worlds_too_few as in_worlds_too_few,
    overall_too_few as overall_too_few,
)
from .comparing.standings import Standings as Standings
from .comparing.tables import is_time as is_time
from .comparing.verdicts import win_shares as win_shares
from .explaining.agreement import Agreement as Agreement, explain as explain
from .explaining.expectations import (
    ALONE as ALONE,
    SWARM as SWARM,
    Line as Line,
    expect as expect,
)
from .explaining.one_setting import Explanation as Explanation
from .explaining.wrong_beliefs import (
    Cost as Cost,
    accuracy_of as accuracy_of,
    costs as costs,
    costs_of as costs_of,
    goes_to as goes_to,
)
