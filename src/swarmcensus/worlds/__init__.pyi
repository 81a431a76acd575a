from . import (
    arena as arena,
    distributions as distributions,
    faults as faults,
    networks as networks,
    patterns as patterns,
    sensors as sensors,
    wiring as wiring,
)
from .arena import tiles_across as tiles_across
from .bodies import Body as Body, Least as Least, Positive as Positive
from .chance import Chance as Chance
from .changes import (
    OR_CHANGE as OR_CHANGE,
    Change as Change,
    along as along,
    read_change as read_change,
    steady as steady,
)
from .connected import components as components
from .distributions import (
    OR_SPREAD as OR_SPREAD,
    Distribution as Distribution,
    spanned_fills as spanned_fills,
)
from .edge_lists import (
    STEPS as STEPS,
    TIMES as TIMES,
    edges_of_matrix as edges_of_matrix,
    from_one as from_one,
    links_of as links_of,
    read_links as read_links,
    unlinked as unlinked,
)
from .faults import NAMES as NAMES, Fault as Fault, Named as Named, outages as outages
from .generators import numbered as numbered
from .graph_files import FileEdges as FileEdges
from .graphs import network as network, whole as whole
from .ground import Ground as Ground, reachable as reachable
from .lattices import rows_and_columns as rows_and_columns
from .networks import (
    MOVING as MOVING,
    Topology as Topology,
    parse_topologies as parse_topologies,
    parse_topology as parse_topology,
)
from .patterns import Floor as Floor, parse_floors as parse_floors
from .pictures import Picture as Picture
from .robot_table import (
    KnownRobot as KnownRobot,
    inlined as inlined,
    read_robots as read_robots,
    write_robots as write_robots,
)
from .robustness import is_rs_robust as is_rs_robust, r_robustness as r_robustness
from .sensors import (
    Accuracy as Accuracy,
    Misjudgement as Misjudgement,
    parse_accuracies as parse_accuracies,
    parse_accuracy as parse_accuracy,
    parse_assumed as parse_assumed,
    parse_beliefs as parse_beliefs,
)
