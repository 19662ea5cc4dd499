# Two processes with a launcher's variables: one that is killed ends the other, and the run continues to where an
# undisturbed one ends.
. "$(dirname "$0")/common.sh"

# both NAME COMMAND...: two ranks that end well.
both() {
  local status=0
  start_ranks "$@"
  wait "${ranks[0]}" || status=$?
  wait "${ranks[1]}" || status=$?
  ((status == 0)) || { cat "$own/$1".?.err >&2; fail "$1 ends with $status"; }
}

training=("$build/bin/diffsac_train" "${tiny[@]}" --set train.iterations=100 --set train.validate_every=100000
  --set train.checkpoint_every=10 --group-timeout 60)
both training "${training[@]}" --output "$own/whole"

# Once more into the same folder: rank 0 refuses, the other does not wait for it.
before=$(sha256sum "$own"/whole/checkpoints/* "$own"/whole/*.*)
start_ranks refused "${training[@]}" --output "$own/whole"
status=0
wait "${ranks[0]}" || status=$?
((status == 2)) && grep -q '^diffsac_train: .*whole: holds a training already' "$own/refused.0.err" ||
  { cat "$own"/refused.?.err >&2; fail "a group trains over another training: $status"; }
status=0
wait "${ranks[1]}" || status=$?
((status == 2)) || fail "the other process ends with $status"
[[ "$(sha256sum "$own"/whole/checkpoints/* "$own"/whole/*.*)" == "$before" ]] || fail "a refused group changed files"

start_ranks killed "${training[@]}" --output "$own/parts"
for ((i = 0; i < 2000; ++i)); do
  [[ ! -f "$own/parts/checkpoints/last.safetensors" ]] || break
  sleep 0.02
done
kill -KILL "${ranks[1]}" || { cat "$own"/killed.?.err >&2; fail "training ended before a process could be killed"; }
status=0
wait "${ranks[0]}" || status=$?
wait "${ranks[1]}" 2>/dev/null || true
((status == 2)) || { cat "$own/killed.0.err" >&2; fail "the other process ends with $status"; }
lines=$(grep -c '^diffsac_train: ' "$own/killed.0.err" || true)
((lines == 1)) || { cat "$own/killed.0.err" >&2; fail "$lines lines instead of one"; }
grep -q '^diffsac_train: process 0 of 2: another process has ended.*last\.safetensors' "$own/killed.0.err" ||
  { cat "$own/killed.0.err" >&2; fail "no clear line"; }
run_expecting 0 evaluate --config configs/tables/line.yaml --methods diffsac --limit 2 --device cpu --threads 1 \
  --checkpoint "$own/parts/checkpoints/last.safetensors" --output "$own/early"

both resumed "${training[@]}" --output "$own/parts" --resume
same_network "$own/whole" "$own/parts" "a run that lost a process gives another model"
