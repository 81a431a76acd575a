from . import (
    measures as measures,
    recordings as recordings,
    replaying as replaying,
    selecting as selecting,
    summaries as summaries,
)
from .cautions import (
    AGREED_AT_START as AGREED_AT_START,
    Origins as Origins,
    caution_of_learning as caution_of_learning,
    cautions_of as cautions_of,
    cautions_of_edges as cautions_of_edges,
    cautions_of_fill_ratios as cautions_of_fill_ratios,
    cautions_of_needs as cautions_of_needs,
    cautions_of_trials as cautions_of_trials,
    failed_trials as failed_trials,
    failures as failures,
    known_origins as known_origins,
    settled_far_off as settled_far_off,
)
from .estimates import cells as cells
from .labels import (
    contender_names as contender_names,
    groups_in as groups_in,
    labels_in as labels_in,
    renamed_contender as renamed_contender,
    titles_in as titles_in,
    with_labels as with_labels,
)
from .measures import (
    COSTS as COSTS,
    MEASURES as MEASURES,
    SIZES as SIZES,
    Measure as Measure,
    choose_measures as choose_measures,
    missing_inputs as missing_inputs,
)
from .never_learnt import (
    QUANTITIES_AT_K as QUANTITIES_AT_K,
    SETTLING_TIMES as SETTLING_TIMES,
    learnt_cells as learnt_cells,
    learnt_numbers as learnt_numbers,
    never_learnt as never_learnt,
)
from .recordings import write_trace as write_trace
from .replaying import honest_in as honest_in, replay as replay
from .selecting import places_with as places_with, require as require, where as where
from .summaries import (
    EMPTY_CELL as EMPTY_CELL,
    derived_size as derived_size,
    done_trials as done_trials,
    is_idle as is_idle,
    repeated_coordinates as repeated_coordinates,
    summary as summary,
    value_text as value_text,
    world_text as world_text,
)
from .table_of_summary import (
    Summary as Summary,
    coordinate_columns as coordinate_columns,
    varied_and_same as varied_and_same,
)
from .tails import (
    TAIL_QUANTITY as TAIL_QUANTITY,
    TIMES as TIMES,
    far_off as far_off,
    has_tail as has_tail,
    shows_tail as shows_tail,
)
