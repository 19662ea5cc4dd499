#!/usr/bin/env bash
# Reproduces tables: sets up, builds the programs in Release and runs them. Everything is written under runs/; a whole table goes
# to docs/results/TABLE.md as well. Stopped and started again, it continues. With --data it begins with images.
set -euo pipefail
caller=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/.."
mapfile -t tables < <(basename -as .yaml configs/tables/*.yaml)
readonly quick_problems=40
usage() {
  echo "usage: scripts/reproduce.sh TABLE...|all [--data DIR] [--again] [--quick|--verify] [options of diffsac_eval, such as --threads 1, --limit 100]"
  echo "       scripts/reproduce.sh multi_motions|pairs|kitti|data --data DIR"
  echo "       scripts/reproduce.sh scoreboard [--data DIR] [options]"
  echo "tables: ${tables[*]}"
  echo "--data: where image sets (configs/sets.yaml), meshes and scans are; matches go to runs/pairs/ (data_tools/README.md)"
  echo "--again: also tables that were made here already"
  echo "--quick: $quick_problems problems a condition and one seed, in runs/quick/; no page is written"
  echo "--verify: makes the tables again in runs/verify/, and says which values of their pages differ; no page is written"
  echo "multi_motions: the tables adelaide_motions and adelaide_planes"
  echo "pairs: the tables learned_*; kitti: those on KITTI alone, in runs/kitti/; data: all matches, no table"
  echo "scoreboard: the tables scoreboard_*, and of all of them the page docs/results/what_decides.md"
}
fail() { echo "reproduce: $*" >&2; exit 1; }

scoreboard=(scoreboard_{essential,fundamental,homography,absolute_pose,line,plane})
wanted=() options=() only=() output=() effects=() mode="" data="" page=yes update=--update quick="" verify="" differing=0
while (($#)) && [[ "$1" != -* ]]; do wanted+=("$1"); shift; done
case "${wanted[*]}${1:-}" in -h | --help) usage; exit ;; "" | -*) usage >&2; exit 1 ;; esac
case "${wanted[*]}" in
  all) wanted=("${tables[@]}") ;;
  data) mode=data wanted=() ;;
  scoreboard) effects=("${scoreboard[@]/#/runs/}") wanted=()
              for table in "${scoreboard[@]}"; do [[ ! -e "configs/tables/$table.yaml" ]] || wanted+=("$table"); done ;;
  multi_motions) wanted=(adelaide_motions adelaide_planes) ;;
  pairs) mode=pairs wanted=(learned_essential learned_fundamental learned_homography) ;;
  kitti) mode=kitti page="" wanted=(learned_essential learned_fundamental)
         options=(--set "data.paths=[$(printf 'runs/pairs/test/kitti_01_step_%s,' 01 02 05 10)]") ;;
esac
while (($#)); do
  case "$1" in
    --data) data=${2:-}; if [[ -z "$data" ]]; then fail "--data needs a folder"; fi; shift ;;
    --again) update="" ;;
    --quick) quick=yes page="" options+=(--limit "$quick_problems") ;;
    --verify) verify=yes page="" ;;
    --threads) options+=("$1" "${2:-}"); shift ;;
    *) options+=("$1") page="" ;;   # A table with other options is another table than the one that docs/results shows.
  esac
  shift
done
if [[ -n "$mode" && -z "$data" ]]; then fail "$mode needs --data DIR, the folder of the images"; fi
[[ -z "$data" || "$data" == /* ]] || data=$caller/$data
[[ -z "$data" || -d "$data" ]] || fail "--data: there is no folder $data"
for table in "${wanted[@]}"; do
  [[ " ${tables[*]} " == *" $table "* ]] || { usage >&2; fail "there is no table '$table'"; }
done
[[ ${#wanted[@]} -lt 2 || " ${options[*]} " != *" --output"* ]] || fail "--output works with one table"
scripts/setup.sh && mkdir -p build/release && echo "reproduce: building (details in build/release/reproduce.log)"
# Programs alone; scripts/test.sh, run afterwards, compiles only the tests.
{ cmake --preset release && cmake --build --preset release --target programs; } >build/release/reproduce.log 2>&1 ||
  { tail -n 30 build/release/reproduce.log >&2; fail "the build failed; all of its output is in build/release/reproduce.log"; }

# What each table's page says that its run took, before anything starts.
estimate() {
  local table seconds total=0 unknown=()
  for table in "$@"; do
    seconds=$(sed -n 's/^- time: \([0-9]*\) s$/\1/p' "docs/results/$table.md" 2>/dev/null || true)
    if [[ -n "$seconds" ]]; then total=$((total + seconds)); else unknown+=("$table"); fi
  done
  echo "reproduce: $# tables; $((total / 3600)) h $((total % 3600 / 60)) min by the times on their pages"
  [[ ${#unknown[@]} -eq 0 ]] || echo "reproduce: no time is known of: ${unknown[*]}"
}
if [[ ${#wanted[@]} -gt 1 && -z "$quick" ]]; then estimate "${wanted[@]}"; fi
# evaluate TABLE OPTIONS...
evaluate() {
  local seeds=()
  if [[ -n "$quick" ]] && grep -q '^sweep:.*seed:' "configs/tables/$1.yaml"; then seeds=(--set "sweep.seed=[1]"); fi
  build/release/bin/diffsac_eval --config "configs/tables/$1.yaml" ${data:+--data "$data"} "${options[@]}" "${seeds[@]}" "${@:2}"
}
for table in "${wanted[@]}"; do mapfile -t -O "${#only[@]}" only < <(evaluate "$table" --needs); done
if [[ "$mode" == data || ( -n "$data" && ${#only[@]} -gt 0 ) ]]; then
  build/release/bin/diffsac_prepare sets --config configs/sets.yaml --data "$data" ${only:+--only "${only[@]}"} ||
    { code=$?; if [[ -n "$mode" || $code != 2 ]]; then exit $code; fi; }   # A table may do without.
fi
for table in "${wanted[@]}"; do
  if [[ "$mode" == kitti ]]; then output=(--output "runs/kitti/$table"); fi
  if [[ -n "$quick" ]]; then output=(--output "runs/quick/$table"); fi
  if [[ -n "$verify" ]]; then output=(--output "runs/verify/$table" --page "runs/verify/$table.md" --page-command verify); fi
  evaluate "$table" --train-missing $update "${output[@]}" \
    ${page:+--page "docs/results/$table.md" --page-command "scripts/reproduce.sh $table${data:+ --data DIR}"}
  if [[ -n "$verify" ]]; then
    build/release/bin/diffsac_docs --compare "docs/results/$table.md" "runs/verify/$table.md" || differing=1
  fi
done
if [[ ${#effects[@]} -gt 0 ]]; then   # Names those that are not made.
  build/release/bin/diffsac_eval --effects "${effects[@]}" \
    ${page:+--page docs/results/what_decides.md --page-command "scripts/reproduce.sh scoreboard${data:+ --data DIR}"}
fi
if [[ -n "$page" ]]; then build/release/bin/diffsac_docs README.md docs/*.md docs/results/claims.md; fi   # Their figures.
if [[ "$differing" != 0 ]]; then fail "some values of the pages differ"; fi
