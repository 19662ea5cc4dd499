# Two processes with a launcher's variables: evaluation is that of one; one that is killed ends the other, and the run
# continues to where an undisturbed one ends.
. "$(dirname "$0")/common.sh"

free_port() { python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'; }

# start NAME RANK PORT PROGRAM ARGUMENTS...: rank RANK of two in the background, its output in $own/NAME.RANK.
start() {
  local name=$1 rank=$2 port=$3
  shift 3
  env RANK="$rank" WORLD_SIZE=2 LOCAL_RANK="$rank" LOCAL_WORLD_SIZE=2 MASTER_ADDR=127.0.0.1 MASTER_PORT="$port" \
    OMP_WAIT_POLICY=passive "$build/bin/$1" "${@:2}" >"$own/$name.$rank" 2>"$own/$name.$rank.err" &
  started=$!
}

# both NAME PROGRAM ARGUMENTS...: two ranks that end well.
both() {
  local name=$1 port status=0
  shift
  port=$(free_port)
  start "$name" 0 "$port" "$@"; local first=$started
  start "$name" 1 "$port" "$@"; local second=$started
  wait "$first" || status=$?
  wait "$second" || status=$?
  ((status == 0)) || { cat "$own/$name".?.err >&2; fail "$name ends with $status"; }
}

table=(--config configs/tables/line.yaml --checkpoint "$tiny_model" --methods diffsac,ransac_20,oracle --limit 6 --device cpu
  --threads 1)
run_expecting 0 evaluate "${table[@]}" --output "$own/one"
both evaluation diffsac_eval "${table[@]}" --output "$own/two"
diff <(grep -v ',ms_' "$own/one/results.csv") <(grep -v ',ms_' "$own/two/results.csv") || fail "two processes change results"
diff <(cd "$own/one" && ls) <(cd "$own/two" && ls) || fail "two processes write other files"
grep -q 'mAA@0.5deg' "$own/evaluation.0" || fail "rank 0 prints no table"
[[ ! -s "$own/evaluation.1" ]] || fail "rank 1 prints something"

training=(diffsac_train "${tiny[@]}" --set train.iterations=100 --set train.validate_every=100000
  --set train.checkpoint_every=10 --group-timeout 60)
both training "${training[@]}" --output "$own/whole"

# Once more into the same folder: rank 0 refuses, the other does not wait for it.
before=$(sha256sum "$own"/whole/checkpoints/* "$own"/whole/*.*)
port=$(free_port)
start refused 0 "$port" "${training[@]}" --output "$own/whole"; first=$started
start refused 1 "$port" "${training[@]}" --output "$own/whole"; second=$started
status=0
wait "$first" || status=$?
((status == 2)) && grep -q '^diffsac_train: .*whole: holds a training already' "$own/refused.0.err" ||
  { cat "$own"/refused.?.err >&2; fail "a group trains over another training: $status"; }
status=0
wait "$second" || status=$?
((status == 2)) || fail "the other process ends with $status"
[[ "$(sha256sum "$own"/whole/checkpoints/* "$own"/whole/*.*)" == "$before" ]] || fail "a refused group changed files"

port=$(free_port)
start killed 0 "$port" "${training[@]}" --output "$own/parts"; first=$started
start killed 1 "$port" "${training[@]}" --output "$own/parts"; second=$started
for ((i = 0; i < 2000; ++i)); do
  [[ ! -f "$own/parts/checkpoints/last.safetensors" ]] || break
  sleep 0.02
done
kill -KILL "$second" || { cat "$own"/killed.?.err >&2; fail "training ended before a process could be killed"; }
status=0
wait "$first" || status=$?
wait "$second" 2>/dev/null || true
((status == 2)) || { cat "$own/killed.0.err" >&2; fail "the other process ends with $status"; }
lines=$(grep -c '^diffsac_train: ' "$own/killed.0.err" || true)
((lines == 1)) || { cat "$own/killed.0.err" >&2; fail "$lines lines instead of one"; }
grep -q '^diffsac_train: process 0 of 2: another process has ended.*last\.safetensors' "$own/killed.0.err" ||
  { cat "$own/killed.0.err" >&2; fail "no clear line"; }
run_expecting 0 evaluate --config configs/tables/line.yaml --methods diffsac --limit 2 --device cpu --threads 1 \
  --checkpoint "$own/parts/checkpoints/last.safetensors" --output "$own/early"

both resumed "${training[@]}" --output "$own/parts" --resume
for run in whole parts; do
  run_expecting 0 evaluate --config configs/tables/line.yaml --methods diffsac --limit 8 --device cpu --threads 1 \
    --checkpoint "$own/$run/checkpoints/last.safetensors" --output "$own/eval_$run"
done
diff <(grep -v ',ms_' "$own/eval_whole/results.csv") <(grep -v ',ms_' "$own/eval_parts/results.csv") ||
  fail "a run that lost a process gives another model"
