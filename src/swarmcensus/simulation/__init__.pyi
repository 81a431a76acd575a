from . import (
    inferring as inferring,
    metrics as metrics,
    reference as reference,
    sampling as sampling,
)
from .blame import (
    NO_ESTIMATE as NO_ESTIMATE,
    blaming as blaming,
)
from .connecting import (
    Connections as Connections,
    connections as connections,
    networks_of as networks_of,
    warn_of_connections as warn_of_connections,
)
from .file_metrics import MetricFails as MetricFails
from .inferring import infer as infer, rows_of as rows_of, warn_of_estimates as warn_of_estimates
from .inputs import inputs_of as inputs_of
from .intervals import ENDS as ENDS
from .living import STRETCH_BYTES as STRETCH_BYTES, Stepped as Stepped
from .metrics import (
    agreement as agreement,
    convergence as convergence,
    correct as correct,
    error_at as error_at,
)
from .recorded import Readings as Readings, known as known, readings_of as readings_of
from .reference import fixed as fixed
from .rerunning import line_of_failure as line_of_failure, packed as packed
from .rides import prepare as prepare, run_ride as run_ride, senders_heard as senders_heard
from .swarming import (
    DECIDED as DECIDED,
    IS_DONE as IS_DONE,
    consensus_of as consensus_of,
    ended as ended,
    fields_of as fields_of,
    foreknowledge as foreknowledge,
    free as free,
    right_option as right_option,
    states_of as states_of,
    swarm as swarm,
    swarm_of as swarm_of,
    tally_of as tally_of,
)
from .traces import (
    TICK as TICK,
    States as States,
    Stretch as Stretch,
    Trace as Trace,
    dataset_of as dataset_of,
    in_ticks as in_ticks,
)
from .trials import (
    Batch as Batch,
    Metrics as Metrics,
    batch_of as batch_of,
    bins_at as bins_at,
    is_crowd as is_crowd,
    is_shared as is_shared,
    measures_of as measures_of,
    record_estimates as record_estimates,
    record_readings as record_readings,
    run_batch as run_batch,
    seconds as seconds,
    walk_seconds as walk_seconds,
)
