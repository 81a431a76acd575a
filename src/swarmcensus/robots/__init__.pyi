from .board_tests import compare as compare
from .calibrating import calibrate as calibrate
from .deploying import deploy as deploy
from .folders import check_free as check_free
from .logs import traces as traces
from .logs.answers import answer_of as answer_of, gaps_in as gaps_in
from .logs.bags import is_bag as is_bag, read_bag as read_bag
from .logs.clocks import Clock as Clock
from .logs.folders import (
    ABOUT as ABOUT,
    OWN as OWN,
    Recording as Recording,
    logs_in as logs_in,
    read_recording as read_recording,
    without_logs as without_logs,
)
from .logs.growing import GrowingRecording as GrowingRecording, may_grow as may_grow
from .logs.lives import relive_all as relive_all
from .logs.logs import Tick as Tick
from .logs.mcap_files import write_mcap as write_mcap
from .logs.replicas import format_of as format_of
from .logs.traces import (
    Logged as Logged,
    as_trace as as_trace,
    trace_in as trace_in,
)
from .swarm.fleet import Fleet as Fleet, run_fleet as run_fleet
from .swarm.links import links_to as links_to
from .swarm.plans import Air as Air, plan_of as plan_of
from .swarm.running import RunningSwarm as RunningSwarm, run as run
