# diffsac_train writes what it promises; its checkpoint is the other tests' model.
. "$(dirname "$0")/common.sh"
run_expecting 0 train --version
grep -q diffsac "$own/out" || fail "--version names no program"
run_expecting 0 train --help
for option in --resume --overwrite; do grep -q -- "$option" "$own/out" || fail "--help does not name $option"; done
run_expecting 0 train "${tiny[@]}" --set train.iterations=30 --set train.validate_every=15 \
  --set train.checkpoint_every=10 --output "$own/run"
expect_file "$own"/run/{config.yaml,metrics.csv,log.txt,report.html} \
  "$own"/run/checkpoints/{last,best}.safetensors
tail -n 1 "$own/out" | grep -q "^results are in $own/run: report.html .*checkpoints/best.safetensors" ||
  { cat "$own/out"; fail "the last line does not say where results are"; }
grep -qE '30/30 .*loss [0-9.e+-]+, mAA [0-9.]+ \(best [0-9.]+\)' "$own/run/log.txt" || fail "no loss and validation in the progress line"
! grep -q 'http-equiv="refresh"' "$own/run/report.html" || fail "the page of a finished training loads itself again"

# A second training into its folder: refused, with all of the first kept, whatever it is of.
kept() { cat "$own"/run/{config.yaml,metrics.csv,log.txt} "$own"/run/checkpoints/*.safetensors | sha256sum; }
before=$(kept)
plane=("${tiny[@]}" --config configs/plane.yaml --set train.iterations=4)
expect_error "$own/run: holds a training already .*--resume.*--overwrite" train "${plane[@]:2}" --output "$own/run"
expect_error "$own/run: holds a training already" train "${tiny[@]}" --set train.iterations=30 --output "$own/run"
expect_error 'another configuration .train\.batch_size: 8, now 4\)' train "${tiny[@]}" --set train.batch_size=4 --resume \
  --output "$own/run"
expect_error '--resume excludes --overwrite' train --resume --overwrite --output "$own/run"
expect_error '30 iterations are done' train --resume --set train.iterations=20 --device cpu --output "$own/run"
expect_error '--config, or --resume with --output' train --resume
expect_error 'no such checkpoint, so there is no training to resume' train --resume --output "$own/nowhere"
[[ ! -e "$own/nowhere" ]] || fail "--resume made a folder"
[[ "$(kept)" == "$before" ]] || fail "a training that was refused changed another one's files"

# --resume needs nothing else: the run says what it is. Iterations grow.
cp -r "$own/run" "$own/resumed"
run_expecting 0 train --resume --device cpu --threads 1 --output "$own/resumed"
grep -q 'all 30 iterations are done' "$own/resumed/log.txt" || fail "a finished run does not say that it is"
run_expecting 0 train --resume --set train.iterations=36 --device cpu --threads 1 --output "$own/resumed"
grep -q 'at iteration 30 with train.iterations: 30, now 36' "$own/resumed/log.txt" || fail "what changed is not said"
[[ "$(tail -1 "$own/resumed/metrics.csv")" == 36,* ]] || fail "iterations do not grow"
diff "$own/run/metrics.csv" <(head -n "$(wc -l <"$own/run/metrics.csv")" "$own/resumed/metrics.csv") ||
  fail "a resumed run loses rows of metrics.csv"

# Another one in its place, where that is said.
run_expecting 0 train "${plane[@]:2}" --overwrite --output "$own/resumed"
grep -q '^task: plane' "$own/resumed/config.yaml" || fail "--overwrite trains another task"
[[ "$(tail -1 "$own/resumed/metrics.csv")" == 4,* ]] || fail "--overwrite leaves rows of the earlier training"

# Validations at steps that are no multiple of log_every, the first before any row of losses.
run_expecting 0 train "${tiny[@]}" --set train.iterations=12 --set train.log_every=100 --set train.validate_every=5 \
  --output "$own/rare"
[[ "$(cut -d, -f1 "$own/rare/metrics.csv" | tail -n +2 | xargs)" == '5 10 12' ]] || fail "validations vanish from metrics.csv"
! grep -E ',$' "$own/rare/metrics.csv" || fail "a row of a validation without its value"
grep -qE 'mAA.*>3</td></tr>' "$own/rare/report.html" || fail "validations vanish from the report"
