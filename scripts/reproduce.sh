#!/usr/bin/env bash
# Reproduces tables: sets up, builds the programs in Release and runs them. Everything is written under runs/, and a whole table is
# compared with its page, docs/results/TABLE.md; --page writes that anew. Stopped or killed and started again, it continues: tables that are made stay, and a table's
# trainings go on from their checkpoints. With --data it begins with images.
set -euo pipefail
caller=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/.."
mapfile -t tables < <(basename -as .yaml configs/tables/*.yaml)
readonly quick_problems=40
usage() {
  echo "usage: scripts/reproduce.sh TABLE...|all [--data DIR] [--again] [--train] [--jobs N] [--quick|--verify|--page] [options of diffsac_eval, such as --threads 1, --limit 100]"
  echo "       scripts/reproduce.sh multi_motions|pairs|kitti|data --data DIR"
  echo "       scripts/reproduce.sh scoreboard [--data DIR] [options]"
  echo "tables: ${tables[*]}"
  echo "--data: where image sets (configs/sets.yaml), meshes and scans are; matches go to runs/pairs/ (data_tools/README.md)"
  echo "--again: also tables that were made here already"
  echo "--train: trains missing networks, minutes to an hour each; without it their rows are left out, or the table fails and names them (--page implies --train)"
  echo "--jobs: N tables side by side, each on one thread; what they print goes to runs/logs/TABLE.log"
  echo "--quick: $quick_problems problems a condition and one seed, in runs/quick/"
  echo "--verify: makes the tables again in runs/verify/; fails where values differ from their pages"
  echo "--page: writes the tables' pages in docs/results/, and the figures of documents (for who changes the project)"
  echo "multi_motions: the tables adelaide_motions and adelaide_planes"
  echo "pairs: the tables learned_*; kitti: those on KITTI alone, in runs/kitti/; data: all matches, no table"
  echo "scoreboard: the tables scoreboard_*, and of all of them the page docs/results/what_decides.md"
}
fail() { echo "reproduce: $*" >&2; exit 1; }

scoreboard=(scoreboard_{essential,fundamental,homography,absolute_pose,line,plane})
wanted=() options=() only=() effects=() mode="" data="" whole=yes page="" train="" update=--update quick="" verify="" jobs=1
while (($#)) && [[ "$1" != -* ]]; do wanted+=("$1"); shift; done
case "${wanted[*]}${1:-}" in -h | --help) usage; exit ;; "" | -*) usage >&2; exit 1 ;; esac
case "${wanted[*]}" in
  all) wanted=("${tables[@]}") effects=("${scoreboard[@]/#/runs/}") ;;
  data) mode=data wanted=() ;;
  scoreboard) effects=("${scoreboard[@]/#/runs/}") wanted=()
              for table in "${scoreboard[@]}"; do [[ ! -e "configs/tables/$table.yaml" ]] || wanted+=("$table"); done ;;
  multi_motions) wanted=(adelaide_motions adelaide_planes) ;;
  pairs) mode=pairs wanted=(learned_essential learned_fundamental learned_homography) ;;
  kitti) mode=kitti whole="" wanted=(learned_essential learned_fundamental)
         options=(--set "data.paths=[$(printf 'runs/pairs/test/kitti_01_step_%s,' 01 02 05 10)]") ;;
esac
while (($#)); do
  case "$1" in
    --data) data=${2:-}; if [[ -z "$data" ]]; then fail "--data needs a folder"; fi; shift ;;
    --again) update="" ;;
    --train) train=--train-missing ;;
    --jobs) jobs=${2:-}; [[ "$jobs" =~ ^[1-9][0-9]*$ ]] || fail "--jobs needs a number of tables"; shift ;;
    --quick) quick=yes whole="" options+=(--limit "$quick_problems") ;;
    --verify) verify=yes ;;
    --page) page=yes ;;
    --threads) [[ "${2:-}" =~ ^[0-9]+$ ]] || fail "--threads needs a number"; options+=("$1" "$2"); shift ;;
    # A table with other options is another table than the one that docs/results shows.
    --checkpoint | --methods | --limit | --seed | --device | --set | --output)
      [[ $# -ge 2 ]] || fail "$1 needs a value"
      options+=("$1" "$2") whole=""
      shift ;;
    *) usage >&2; fail "there is no option '$1'" ;;
  esac
  shift
done
if [[ -n "$page" && ( -z "$whole" || -n "$verify" ) ]]; then fail "--page is of whole tables alone, without other options"; fi
[[ -z "$page" ]] || train=--train-missing   # A page has every row.
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

# What a table's page says that its run took; nothing where there is none.
known_seconds() { sed -n 's/^- time: \([0-9]*\) s$/\1/p' "docs/results/$1.md" 2>/dev/null || true; }
estimate() {
  local table seconds total=0 unknown=()
  for table in "$@"; do
    seconds=$(known_seconds "$table")
    if [[ -n "$seconds" ]]; then total=$((total + seconds)); else unknown+=("$table"); fi
  done
  echo "reproduce: $# tables; $((total / jobs / 3600)) h $((total / jobs % 3600 / 60)) min by the times on their pages, $jobs at a time"
  [[ ${#unknown[@]} -eq 0 ]] || echo "reproduce: no time is known of: ${unknown[*]}"
}
# script FILE OPTIONS...: by a python3 that has the modules of scripts/report.
script() {
  local python
  for python in python3 /usr/bin/python3; do
    if "$python" scripts/report/check_modules.py 2>/dev/null; then "$python" "$@"; return; fi
  done
  fail "no python3 has the modules of scripts/report (scripts/setup.sh installs them)"
}
report() { script "scripts/report/$1" "${@:2}"; }
tool() { script "data_tools/$1" "${@:2}"; }
# evaluate TABLE OPTIONS...
evaluate() {
  local seeds=()
  if [[ -n "$quick" ]]; then seeds=(--seed 1); fi
  build/release/bin/diffsac_eval --config "configs/tables/$1.yaml" ${data:+--data "$data"} "${options[@]}" "${seeds[@]}" "${@:2}"
}
# make_table TABLE: the table, and what differs from its page, or with --page that.
make_table() {
  local output=()
  if [[ "$mode" == kitti ]]; then output=(--output "runs/kitti/$1"); fi
  if [[ -n "$quick" ]]; then output=(--output "runs/quick/$1"); fi
  if [[ -n "$verify" ]]; then output=(--output "runs/verify/$1"); fi
  evaluate "$1" $train $update "${output[@]}" || return
  # Nothing is here of a table that was skipped.
  local made=runs/${verify:+verify/}$1 code=0
  if [[ -z "$whole" || ! -e "$made/run.json" ]]; then return; fi
  report "" "$made" || return
  if [[ -n "$page" ]]; then
    report page.py "$made" --page "docs/results/$1.md" --command "scripts/reproduce.sh $1${data:+ --data DIR}"
    return
  fi
  report page.py "$made" --page "$made/page.md" --command "scripts/reproduce.sh $1${data:+ --data DIR}" || return
  if [[ ! -e "docs/results/$1.json" ]]; then echo "reproduce: no page has been written of $1"; return; fi
  report docs.py --compare "docs/results/$1.json" "$made/page.json" || code=$?
  # Another kind of processor rounds in another way, and data may be other data: for the reader to judge.
  [[ -z "$verify" && $code == 1 ]] || return $code
}
# A table among others. What it printed is in runs/logs/TABLE.log; its last lines are shown where it failed.
make_logged() {
  local start=$SECONDS code=0 told
  make_table "$1" >"runs/logs/$1.log" 2>&1 || code=$?
  told=$(grep -m 1 -e ': skipped, ' -e ': made already' "runs/logs/$1.log" || true)
  echo "reproduce: $1: ${told:-$((SECONDS - start)) s}$([[ $code == 0 ]] || echo ", FAILED ($code), see runs/logs/$1.log")"
  [[ $code == 0 ]] || tail -n 3 "runs/logs/$1.log" >&2
  return $code
}
# The longest first, so that the last ones end together; those of which no time is known come last.
make_side_by_side() {
  local table failed=0 options=("${options[@]}" --threads 1)
  mkdir -p runs/logs
  # Not the terminal's Ctrl-C alone: the programs end tidily, and the same call goes on.
  trap 'pkill -TERM -P "$(jobs -pr | paste -sd,)" || true; wait; exit 130' INT TERM
  while read -r _ table; do
    while (($(jobs -pr | wc -l) >= jobs)); do wait -n || failed=1; done
    make_logged "$table" &
  done < <(for table in "$@"; do echo "$(known_seconds "$table" | grep . || echo 0) $table"; done | sort -rn)
  while [[ -n "$(jobs -pr)" ]]; do wait -n || failed=1; done
  return $failed
}

if [[ ${#wanted[@]} -gt 1 && -z "$quick" ]]; then estimate "${wanted[@]}"; fi
for table in "${wanted[@]}"; do mapfile -t -O "${#only[@]}" only < <(evaluate "$table" $train --needs); done
if [[ "$mode" == data || ( -n "$data" && ${#only[@]} -gt 0 ) ]]; then
  tool convert.py sets --config configs/sets.yaml --data "$data" --program build/release/bin/diffsac_prepare \
    ${only:+--only "$(IFS=,; echo "${only[*]}")"} ||
    { code=$?; if [[ -n "$mode" || $code != 2 ]]; then exit $code; fi; }   # A table may do without.
fi
failed=0
if [[ "$jobs" != 1 ]]; then
  make_side_by_side "${wanted[@]}" || failed=1
else
  for table in "${wanted[@]}"; do make_table "$table" || { [[ -n "$verify" ]] || exit; failed=1; }; done
fi
if [[ ${#effects[@]} -gt 0 ]]; then   # Names those that are not made.
  report effects.py "${effects[@]}" \
    ${page:+--page docs/results/what_decides.md} --command "scripts/reproduce.sh scoreboard${data:+ --data DIR}"
fi
if [[ -n "$page" ]]; then report docs.py README.md docs/*.md docs/results/claims.md; fi   # Their figures.
if [[ "$failed" != 0 ]]; then fail "not every table was made, or is as its page says"; fi
