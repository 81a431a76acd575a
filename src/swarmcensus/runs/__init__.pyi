from . import pools as pools, verifying as verifying
from .collect import Progress as Progress, Report as Report, State as State
from .devices import (
    Device as Device,
    Hardware as Hardware,
    WhereToRun as WhereToRun,
    placing_of as placing_of,
)
from .pools import compile_for as compile_for
from .progress import bar_or_lines as bar_or_lines, log_compilation as log_compilation, showing as showing
from .running import predicted_seconds as predicted_seconds, recompute as recompute, run as run
from .status_of_run import status as status
from .verifying import Verification as Verification, verify as verify
