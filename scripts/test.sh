#!/usr/bin/env bash
# Sets up, checks the format, builds with warnings as errors and runs every test. Options go to ctest: scripts/test.sh -R geometry
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/setup.sh

log=$(mktemp)
trap 'rm -f "$log"' EXIT
sources=(lib apps data_tools tests benchmarks)
if ! command -v clang-format-14 >/dev/null; then
  echo "test: the format is not checked: there is no clang-format-14 here"
elif ! find "${sources[@]}" \( -name '*.h' -o -name '*.cpp' \) -print0 |
  xargs -0 -P "$(nproc)" -n 40 clang-format-14 --dry-run --Werror 2>"$log"; then
  head -n 20 "$log" >&2
  echo "test: some files are not formatted; this mends them:
  find ${sources[*]} -name '*.h' -o -name '*.cpp' | xargs clang-format-14 -i" >&2
  exit 1
fi

cmake --preset release -DDIFFSAC_BUILD_TESTS=ON
cmake --build --preset release
ctest --preset release -j2 "$@"
