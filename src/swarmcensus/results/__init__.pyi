from . import merging as merging, schema as schema, shards as shards, store as store
from .existing_files import check_there as check_there, folder_of as folder_of
from .merging import merge as merge
from .outlines import (
    MAY_DIFFER as MAY_DIFFER,
    differences as differences,
    laid_out as laid_out,
    most_trials as most_trials,
    outline as outline,
    positions as positions,
    settings_of as settings_of,
)
from .partial import open_partial as open_partial, say_partial as say_partial
from .reading import packed as packed, readable as readable
from .shards import Identity as Identity, Parts as Parts, shard_files as shard_files
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
    as_dataset as as_dataset,
    dataset as dataset,
    frame as frame,
    load as load,
    load_packed as load_packed,
    provenance as provenance,
    save as save,
)
from .values import (
    ESTIMATES as ESTIMATES,
    INTERVALS as INTERVALS,
    LOCAL as LOCAL,
    MARKS as MARKS,
    MISSING as MISSING,
    NETWORKS as NETWORKS,
    ArrayStore as ArrayStore,
    Columns as Columns,
    Piece as Piece,
    Values as Values,
    bounds_in as bounds_in,
    changed_plugin as changed_plugin,
    failed_in as failed_in,
    failed_trials as failed_trials,
    finished_trials as finished_trials,
    is_missing as is_missing,
    kinds_in as kinds_in,
    metric_of as metric_of,
    metrics_in as metrics_in,
    metrics_label as metrics_label,
    missing_value as missing_value,
    others as others,
    parameters_in as parameters_in,
    robots_in as robots_in,
    same_bits as same_bits,
    sources_of as sources_of,
)
