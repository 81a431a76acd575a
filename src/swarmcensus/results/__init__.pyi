from . import (
    measures as measures,
    merging as merging,
    recordings as recordings,
    replaying as replaying,
    selecting as selecting,
    shards as shards,
    store as store,
    structure as structure,
    summaries as summaries,
)
from .cautions import (
    TOGETHER as TOGETHER,
    Origins as Origins,
    caution_of_learning as caution_of_learning,
    cautions_of as cautions_of,
    cautions_of_edges as cautions_of_edges,
    cautions_of_needs as cautions_of_needs,
    cautions_of_settling as cautions_of_settling,
    known_origins as known_origins,
    settled_far_off as settled_far_off,
    warn_of_course as warn_of_course,
    warn_of_edges as warn_of_edges,
)
from .check_against_study import settings_of as settings_of, unchecked as unchecked, unlike as unlike
from .estimates import Cells as Cells, cells as cells
from .existing_files import check_there as check_there, folder_of as folder_of
from .labels import (
    contender_names as contender_names,
    groups_in as groups_in,
    labels_in as labels_in,
    renamed as renamed,
    titles_in as titles_in,
    with_labels as with_labels,
)
from .measures import (
    COSTS as COSTS,
    OURS as OURS,
    SIZES as SIZES,
    Measure as Measure,
    at_checkpoints as at_checkpoints,
    chosen as chosen,
    derivable as derivable,
    head_of as head_of,
    inputs_of as inputs_of,
    is_share as is_share,
    lacks as lacks,
    named as named,
    numbers as numbers,
    sample as sample,
    statistic_of as statistic_of,
)
from .merging import merge as merge
from .never_learnt import (
    AT_K as AT_K,
    SETTLING as SETTLING,
    learnt_cells as learnt_cells,
    learnt_numbers as learnt_numbers,
    never_learnt as never_learnt,
)
from .partial import opened as opened, say_partial as say_partial
from .reading import packed as packed, readable as readable
from .recordings import write_trace as write_trace
from .relived import dataset_of as dataset_of
from .remeasuring import remeasure as remeasure
from .replaying import honest_in as honest_in, replay as replay
from .selecting import (
    TooMuch as TooMuch,
    places_with as places_with,
    require as require,
    where as where,
)
from .shards import Identity as Identity, Parts as Parts, listed as listed
from .source_study import (
    Brains as Brains,
    check_held as check_held,
    metrics_may_run as metrics_may_run,
    must_be_read as must_be_read,
    origins_of as origins_of,
    round_of as round_of,
    setting_of as setting_of,
    studies_of as studies_of,
)
from .store import (
    frame as frame,
    load as load,
    loaded as loaded,
    provenance as provenance,
    save as save,
    stored as stored,
    wrong_layout as wrong_layout,
)
from .structure import failures as failures, finished as finished
from .summaries import (
    asked_anew as asked_anew,
    derived_size as derived_size,
    done as done,
    failed_trials as failed_trials,
    is_idle as is_idle,
    records as records,
    restated as restated,
    summary as summary,
)
from .table_of_summary import (
    NOTHING as NOTHING,
    Summary as Summary,
    coordinate_columns as coordinate_columns,
    varied_and_same as varied_and_same,
)
from .tails import TAIL as TAIL, TIMES as TIMES, far_off as far_off, has_tail as has_tail, shows_tail as shows_tail
from .values import (
    AGREEMENT as AGREEMENT,
    ESTIMATES as ESTIMATES,
    EVERY as EVERY,
    INTERVALS as INTERVALS,
    LOCAL as LOCAL,
    MISSING as MISSING,
    ArrayStore as ArrayStore,
    Columns as Columns,
    Piece as Piece,
    Values as Values,
    blank as blank,
    bounds_in as bounds_in,
    edited as edited,
    is_missing as is_missing,
    kinds_in as kinds_in,
    metric_of as metric_of,
    metrics_in as metrics_in,
    metrics_label as metrics_label,
    parameters_in as parameters_in,
    robots_in as robots_in,
    same_bits as same_bits,
    sources_of as sources_of,
)
