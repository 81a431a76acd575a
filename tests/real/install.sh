#!/usr/bin/env bash
# The programs that tests/real runs against, on Debian or Ubuntu, as root: other readers of results, and what they need.
set -euo pipefail
apt-get update
DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends \
  r-base-core r-cran-ncdf4 octave octave-netcdf ffmpeg
