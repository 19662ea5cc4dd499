# Ctrl-C leaves a checkpoint, and --resume ends where an uninterrupted run does.
. "$(dirname "$0")/common.sh"
long=("${tiny[@]}" --set train.iterations=1500 --set train.validate_every=100000 --set train.checkpoint_every=100000)
run_expecting 0 train "${long[@]}" --output "$own/whole"

# Job control gives the background job the default SIGINT, which a script's jobs otherwise ignore.
set -m
"$build/bin/diffsac_train" "${long[@]}" --output "$own/parts" >"$own/out" 2>"$own/err" &
job=$!
set +m
for ((i = 0; i < 1000; ++i)); do
  [[ ! -f "$own/parts/metrics.csv" ]] || (($(wc -l <"$own/parts/metrics.csv") < 3)) || break
  sleep 0.02
done
kill -INT "$job" || { cat "$own/err" >&2; fail "training ended before it could be interrupted"; }
status=0
wait "$job" || status=$?
((status == 130)) || { cat "$own/err" >&2; fail "an interrupted run ends with $status"; }
expect_file "$own/parts/checkpoints/last.safetensors"
run_expecting 0 train "${long[@]}" --resume --output "$own/parts"

same_network "$own/whole" "$own/parts" "a resumed run gives another model"
