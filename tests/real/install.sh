#!/usr/bin/env bash
# The programs that tests/real runs against, on Debian or Ubuntu, as root: a batch system, and other readers of results.
set -euo pipefail
apt-get update
DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends \
  munge slurm-wlm openssl r-base-core r-cran-ncdf4 octave octave-netcdf ffmpeg
