from .beliefs import asymptote as asymptote, belief_error as belief_error, calibration_error as calibration_error
from .bounds import (
    information as information,
    median_error as median_error,
    neighbourhood_bound as neighbourhood_bound,
    reading_variance as reading_variance,
    swarm_bound as swarm_bound,
)
from .floor import (
    Truth as Truth,
    even_concentration as even_concentration,
    tiles_variance as tiles_variance,
)
from .local import (
    Law as Law,
    cut_off as cut_off,
    error_law as error_law,
    local_law as local_law,
    local_squared_error as local_squared_error,
    mixed_law as mixed_law,
    normal_median_error as normal_median_error,
    normal_right_share as normal_right_share,
    pulled_squared_error as pulled_squared_error,
    right_share as right_share,
)
from .matrices import from_links as from_links, mixing_matrix as mixing_matrix, spectrum_of as spectrum_of
from .mixing import (
    Mixed as Mixed,
    mixed_sums as mixed_sums,
    variance_factors as variance_factors,
)
from .spectra import (
    relaxation_time as relaxation_time,
    stationary_efficiency as stationary_efficiency,
    stationary_law as stationary_law,
)
