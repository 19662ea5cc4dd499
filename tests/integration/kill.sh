#!/usr/bin/env bash
# kill.sh BUILD_DIR [SOURCE_DIR WORK_DIR] [--kills N] [--seed S]: `kill -9` at moments spread over the whole run of a
# training, an evaluation, a preparation and one of two processes of a group. What is killed is started again, and at
# times killed again, and must end as a run that nobody disturbed; in between no final name may be that of a half file.
build=$(realpath "$1")
shift
source=$(realpath "$(dirname "$0")/../..") work=""
if (($# >= 2)) && [[ "$1" != --* ]]; then source=$1 work=$2; shift 2; fi
kills=0 seed=1
while (($# >= 2)); do
  case "$1" in --kills) kills=$2 ;; --seed) seed=$2 ;; *) echo "unknown: $1" >&2; exit 2 ;; esac
  shift 2
done
set -- "$build" "$source" "${work:-$(mktemp -d)}"
. "$(dirname "$0")/common.sh"
files="$source/tests/integration/run_files.py"
export OMP_WAIT_POLICY=passive OMP_NUM_THREADS=1
RANDOM=$seed
# The kills of each kind: 40, 30, 20 and 10 of a hundred.
train_kills=2 eval_kills=2 prepare_kills=2 group_kills=1
if ((kills > 0)); then
  train_kills=$((kills * 4 / 10)) eval_kills=$((kills * 3 / 10)) prepare_kills=$((kills * 2 / 10))
  group_kills=$((kills - train_kills - eval_kills - prepare_kills))
fi

now_ms() { echo $(($(date +%s%N) / 1000000)); }
seconds() { printf '%d.%03d' $(($1 / 1000)) $(($1 % 1000)); }

# Each kind has: NAME_command FOLDER sets `command` to what a user types, now that the folder holds what it holds;
# NAME_folder FOLDER makes what is there before.
training=("$build/bin/diffsac_train" "${tiny[@]}" --set train.iterations=60 --set train.validate_every=15
  --set train.log_every=4 --set train.checkpoint_every=5)
# Now and then the folder holds another training, in whose place this one is to be.
training_folder() {
  overwritten=""
  if ((RANDOM % 2)); then
    cp -r "$own/other_training" "$1"
    overwritten=$1
  fi
  mkdir -p "$1"
}
training_command() {
  command=("${training[@]}" --output "$1")
  if [[ "$1" == "${overwritten:-}" ]]; then
    command+=(--overwrite)
  elif [[ -f "$1/checkpoints/last.safetensors" ]]; then
    command+=(--resume)
  fi
}
table=("$build/bin/diffsac_eval" --config configs/tables/line.yaml --methods diffsac,ransac_20,theil_sen,oracle
  --limit 6 --device cpu --threads 1 --set estimates=true --update)
# Now and then the folder holds the results of another configuration, which must not pass for these.
evaluation_folder() {
  if ((RANDOM % 2)) && [[ -d "$own/other" ]]; then cp -r "$own/other" "$1"; fi
}
evaluation_command() {
  command=("${table[@]}" --checkpoint "$own/training_whole/checkpoints/best.safetensors" --output "$1")
}
preparation_folder() { :; }
preparation_command() {
  command=("$build/bin/diffsac_prepare" pairs --format images --input "$own/images" --output "$1" --steps 1,2
    --descriptors --threads 1)
}

# uninterrupted KIND: the run that all others are compared with; sets `wall` to its milliseconds.
uninterrupted() {
  local start
  "$1_command" "$own/$1_whole"
  start=$(now_ms)
  run_expecting 0 "${command[@]}"
  wall=$(($(now_ms) - start))
  python3 "$files" whole "$own/$1_whole"
}

# kill_at MILLISECONDS FOLDER: starts the command and kills it; false when it had ended by itself before.
kill_at() {
  local job status=0
  "${command[@]}" >"$own/out" 2>"$own/err" &
  job=$!
  sleep "$(seconds "$1")"
  kill -KILL "$job" 2>/dev/null || true
  wait "$job" 2>/dev/null || status=$?
  [[ ! -d "$2" ]] || python3 "$files" whole "$2"
  ((status == 137)) && return 0
  ((status == 0)) || { cat "$own/err" >&2; fail "ends with $status after a kill: ${command[*]}"; }
  return 1
}

# killed_runs KIND KILLS: one to three kills in a row, then the run to its end, until there were so many kills. The
# first kills are spread evenly, a random one in each of so many parts of the wall time; those that follow are anywhere.
killed_runs() {
  local kind=$1 wanted=$2 done=0 runs=0 late=0 folder row moment start tenths=(0 0 0 0 0 0 0 0 0 0)
  while ((done < wanted)); do
    folder="$own/${kind}_$((++runs))"
    "${kind}_folder" "$folder"
    for ((row = RANDOM % 4 < 2 ? 1 : 2 + RANDOM % 2; row > 0 && done < wanted; --row)); do
      moment=$((wall * (done * 32768 + RANDOM) / (wanted * 32768)))
      ((row == 1)) || moment=$((wall * RANDOM / 32768))
      "${kind}_command" "$folder"
      if kill_at "$moment" "$folder"; then
        done=$((done + 1)) tenths[moment * 10 / (wall + 1)]=$((tenths[moment * 10 / (wall + 1)] + 1))
      else
        late=$((late + 1)) wall=$((wall * 29 / 30))
        break
      fi
    done
    ((late <= wanted + 5)) || fail "$kind: the runs end before they can be killed"
    "${kind}_command" "$folder"
    start=$(now_ms)
    run_expecting 0 "${command[@]}"
    # On a busy machine runs become slower and faster; one that began anew says how long they are now.
    [[ "$kind" == training ]] || ((row > 0)) || wall=$(((wall + $(now_ms) - start) / 2))
    python3 "$files" same "$own/${kind}_whole" "$folder" || fail "$kind: seed $seed, run $runs ends otherwise"
    rm -rf "$folder"
  done
  echo "$kind: $done kills in $runs runs of about $(seconds "$wall") s, by tenths of that: ${tenths[*]}; $late came too late"
}

. "$source/tests/integration/kill_group.sh"

if ((train_kills + eval_kills > 0)); then
  training_command "$own/other_training"
  run_expecting 0 "${command[@]}" --set train.learning_rate=0.01
  uninterrupted training
  killed_runs training "$train_kills"
fi
if ((eval_kills > 0)); then
  evaluation_command "$own/other"
  run_expecting 0 "${command[@]}" --seed 7
  uninterrupted evaluation
  killed_runs evaluation "$eval_kills"
fi
if ((prepare_kills > 0)); then
  mkdir "$own/images"
  for i in 1 2 3 4 5; do gray_blobs 200 150 140 3 $((6 * i)) >"$own/images/$i.pgm"; done
  uninterrupted preparation
  killed_runs preparation "$prepare_kills"
fi
if ((group_kills > 0)); then killed_groups "$group_kills"; fi
[[ -n "$work" ]] || rm -rf "$(dirname "$own")"
