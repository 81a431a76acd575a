#!/usr/bin/env bash
# Tests with the lowest versions that pyproject.toml allows, in an environment of their own:
#   tools/lowest.sh         the quick tests with all extras
#   tools/lowest.sh core    main paths with the core alone; what .ci/run does
set -euo pipefail
cd "$(dirname "$0")/.."

environment=$(mktemp -d)
trap 'rm -rf "$environment"' EXIT
python3 -m venv "$environment"
scripts="$environment/bin"
if [ -d "$environment/Scripts" ]; then scripts="$environment/Scripts"; fi # as it is called on Windows
unset PIP_CONSTRAINT # the versions that are tested otherwise
"$scripts/python" -m pip install uv
export UV_PYTHON="$scripts/python"
if [ "${1:-all}" = all ]; then
	"$scripts/uv" pip install --quiet --resolution lowest-direct '.[test,parquet,film,cluster,tune,ros,watch]'
	"$scripts/python" -m pytest -n 2 -m "not long"
else
	"$scripts/uv" pip install --quiet --resolution lowest-direct .
	"$scripts/uv" pip install --quiet --no-build pytest pytest-xdist hypothesis
	"$scripts/python" -m pytest -n 2 -m "not long" \
		tests/unit/{runs/test_merging,results/test_dataset,simulation/test_traces}.py tests/cli/test_{piping,plot}.py -k "not parquet"
fi
