#!/usr/bin/env bash
# Sets up, builds with warnings as errors and runs every test. Options go to ctest: scripts/test.sh -R geometry
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/setup.sh
cmake --preset ci
cmake --build --preset ci
ctest --preset ci -j2 "$@"
