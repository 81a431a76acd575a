from . import code_cache as code_cache, codegen as codegen, compiler as compiler
from .addresses import address as address
from .code_cache import cache_root as cache_root, keeps as keeps, not_compiled as not_compiled
from .codegen import record_fields as record_fields
from .compiler import (
    IN_SUMS as IN_SUMS,
    IN_SUMS_OF_ALL as IN_SUMS_OF_ALL,
    ONE_BY_ONE as ONE_BY_ONE,
    blank_record as blank_record,
    compile_metric as compile_metric,
    compile_world as compile_world,
)
from .compiling import INSIDE as INSIDE
from .failures import works as works
from .layout import (
    ALONE as ALONE,
    NO_LINKS as NO_LINKS,
    NOT_RECORDED as NOT_RECORDED,
    Bodies as Bodies,
    Chunk as Chunk,
    Inputs as Inputs,
    Intervals as Intervals,
    Links as Links,
    Measures as Measures,
    Neighbours as Neighbours,
    Reception as Reception,
    Recorded as Recorded,
    Segments as Segments,
    Sensors as Sensors,
    States as States,
    Swarm as Swarm,
    Tally as Tally,
    Work as Work,
    parts_of as parts_of,
    runs_of as runs_of,
)
from .python_errors import make_strict as make_strict
from .random import (
    block as block,
    chance as chance,
    counter as counter,
    single_chance as single_chance,
    unit as unit,
    word_of as word_of,
    words as words,
)
from .records import record_type as record_type
from .return_values import spoken as spoken
from .states import heard_by as heard_by
from .threads import (
    LeavableThreads as LeavableThreads,
    interruptible as interruptible,
    run_together as run_together,
)
