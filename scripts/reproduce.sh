#!/usr/bin/env bash
# Reproduces tables: sets up, builds the programs in Release, evaluates the shipped models and prints the tables.
# Everything is written under runs/TABLE/.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

tables() { for config in configs/tables/*.yaml; do [[ -e "$config" ]] && basename "$config" .yaml; done; true; }

usage() {
  echo "usage: scripts/reproduce.sh TABLE... [options of diffsac_eval, such as --limit 100 or --threads 1]"
  echo "tables: $(tables | tr '\n' ' ')all"
}

wanted=()
while (($#)) && [[ "$1" != -* ]]; do wanted+=("$1"); shift; done
if [[ "${1:-}" == "-h" || "${1:-}" == "--help" ]]; then usage; exit 0; fi
if ((${#wanted[@]} == 0)); then usage >&2; exit 1; fi
if [[ "${wanted[*]}" == "all" ]]; then mapfile -t wanted < <(tables); fi
for table in "${wanted[@]}"; do
  if [[ "$table" == */* || ! -f "configs/tables/$table.yaml" ]]; then
    echo "reproduce: there is no table '$table'" >&2
    usage >&2
    exit 1
  fi
done
for option in "$@"; do
  if [[ "$option" == --output* && ${#wanted[@]} -gt 1 ]]; then
    echo "reproduce: --output works with one table; without it each is written under runs/" >&2
    exit 1
  fi
done

scripts/setup.sh
log=build/release/reproduce.log
mkdir -p build/release
echo "reproduce: building (details in $log)"
if ! { cmake --preset release -DDIFFSAC_BUILD_TESTS=OFF && cmake --build --preset release; } >"$log" 2>&1; then
  tail -n 30 "$log" >&2
  echo "reproduce: the build failed; all of its output is in $log" >&2
  exit 1
fi

for table in "${wanted[@]}"; do
  output="runs/$table"
  # A later --output of the caller's replaces ours.
  arguments=(--config "configs/tables/$table.yaml")
  if [[ " $* " == *" --output"* ]]; then
    output=""
  else
    arguments+=(--output "$output")
  fi
  build/release/bin/diffsac_eval "${arguments[@]}" "$@"
  if [[ -n "$output" ]]; then
    echo "reproduce: tables, pictures and results are in $output/"
  fi
done
