from .metric import (
    GIVEN as GIVEN,
    PLUGINS as PLUGINS,
    Metric as Metric,
    find as find,
    load as load,
    parse as parse,
    variable_of as variable_of,
)
