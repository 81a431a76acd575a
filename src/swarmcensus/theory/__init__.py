"""Closed forms to compare measurements with: exact distributions, bounds, mixing on networks, finite floors.

In: numbers and arrays, graphs.
Out: numbers and arrays.
Must not know: brains, studies, settings, results.
"""

from swarmcensus.theory.bounds import (
    information,
    median_error,
    neighbourhood_bound,
    reading_variance,
    robot_bound,
    swarm_bound,
)
from swarmcensus.theory.cut_mixing import cut_squared_error, terms_for
from swarmcensus.theory.floor import (
    Truth,
    cluster_covariance,
    concentration,
    covariance_variance,
    even_concentration,
    floor_variance,
    sensing_variance,
    tiles_variance,
)
from swarmcensus.theory.local import (
    Law,
    bin_shares,
    cut_off,
    error_law,
    local_law,
    local_squared_error,
    mixed_law,
    normal_median_error,
    normal_right_share,
    pulled_squared_error,
    right_share,
)
from swarmcensus.theory.matrices import mixing_matrix
from swarmcensus.theory.mixing import Mixed, mixed_sums, mixing_variance, variance_factors
from swarmcensus.theory.spectra import (
    alike_factors,
    factor_bounds,
    full_spectrum,
    mixing_time,
    mixing_time_bound,
    relaxation_of,
    relaxation_time,
    ring_spectrum,
    spectral_gap,
    stationary_efficiency,
    stationary_law,
    torus_spectrum,
)

__all__ = [
    "Law",
    "Mixed",
    "Truth",
    "alike_factors",
    "bin_shares",
    "cluster_covariance",
    "concentration",
    "covariance_variance",
    "cut_off",
    "cut_squared_error",
    "error_law",
    "even_concentration",
    "factor_bounds",
    "floor_variance",
    "full_spectrum",
    "information",
    "local_law",
    "local_squared_error",
    "median_error",
    "mixed_law",
    "mixed_sums",
    "mixing_matrix",
    "mixing_time",
    "mixing_time_bound",
    "mixing_variance",
    "neighbourhood_bound",
    "normal_median_error",
    "normal_right_share",
    "pulled_squared_error",
    "reading_variance",
    "relaxation_of",
    "relaxation_time",
    "right_share",
    "ring_spectrum",
    "robot_bound",
    "sensing_variance",
    "spectral_gap",
    "stationary_efficiency",
    "stationary_law",
    "swarm_bound",
    "terms_for",
    "tiles_variance",
    "torus_spectrum",
    "variance_factors",
]
