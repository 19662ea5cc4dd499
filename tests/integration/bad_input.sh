# Mistakes and broken files end with status 2 and one clear line.
. "$(dirname "$0")/common.sh"
table=(--config configs/tables/line.yaml --methods diffsac --limit 2 --device cpu)

# Configuration.
printf 'name: x\ntrain:\n  batch_sise: 3\n' >"$own/key.yaml"
expect_error 'key\.yaml:3: .*batch_size' train --config "$own/key.yaml" --output "$own/run"
printf 'name: x\ntrain: {learning_rate: fast}\n' >"$own/type.yaml"
expect_error 'type\.yaml:2: ' train --config "$own/type.yaml" --output "$own/run"
printf 'name: [1\n' >"$own/syntax.yaml"
expect_error 'syntax\.yaml' evaluate --config "$own/syntax.yaml" --output "$own/run"
printf 'problems: -4\n' >"$own/range.yaml"
expect_error 'range\.yaml:1: ' evaluate --config "$own/range.yaml" --output "$own/run"
expect_error 'nothere\.yaml' evaluate --config "$own/nothere.yaml"
: >"$own/empty.yaml"
expect_error '.' evaluate --config "$own/empty.yaml" --output "$own/run"
expect_error 'diffsac' evaluate "${table[@]}" --methods difsac --output "$own/run"
expect_error 'train\.batch_size|batch_size' train "${tiny[@]}" --set train.batch_size=0 --output "$own/run"

# Checkpoints.
expect_error 'nothere\.pt' evaluate "${table[@]}" --checkpoint "$own/nothere.pt" --output "$own/run"
size=$(stat -c %s "$tiny_model")
head -c $((size / 2)) "$tiny_model" >"$own/truncated.pt"
expect_error 'truncated\.pt' evaluate "${table[@]}" --checkpoint "$own/truncated.pt" --output "$own/run"
: >"$own/empty.pt"
expect_error 'empty\.pt' evaluate "${table[@]}" --checkpoint "$own/empty.pt" --output "$own/run"
expect_error "$(basename "$tiny_model")" evaluate --config configs/tables/plane.yaml --methods diffsac --limit 2 \
  --checkpoint "$tiny_model" --output "$own/run"
expect_error '.' train "${tiny[@]}" --resume --output "$own/never_started"

# Data.
printf '\211HDF\r\n\032\n\000\000' >"$own/truncated.h5"
expect_error 'truncated\.h5' evaluate --config configs/tables/line.yaml --methods ransac_20 --output "$own/run" \
  --set "data={type: point_sets, paths: ['$own/truncated.h5'], inlier_threshold: 0.1}" --set 'sweep=~' --set 'figures={}' --set 'paper={}'
expect_error 'nowhere' evaluate --config configs/tables/line.yaml --methods ransac_20 --output "$own/run" \
  --set "data={type: point_sets, paths: ['$own/nowhere'], inlier_threshold: 0.1}" --set 'sweep=~' --set 'figures={}' --set 'paper={}'

# Output that cannot be written: below a regular file, and on a disk that is full (a file size limit acts alike).
touch "$own/file"
expect_error 'file' evaluate "${table[@]}" --checkpoint "$tiny_model" --output "$own/file/run"
expect_error 'file' train "${tiny[@]}" --output "$own/file/run"
with_full_disk() { (trap '' XFSZ; ulimit -f 4; "$@"); }
got=0
with_full_disk train "${tiny[@]}" --set train.iterations=2 --output "$own/full" >"$own/out" 2>"$own/err" || got=$?
((got == 2)) || { cat "$own/err" >&2; fail "a full disk ends training with $got"; }
grep -q '^diffsac_train: .*checkpoints' "$own/err" || { cat "$own/err" >&2; fail "no clear line about the full disk"; }
[[ ! -e "$own/full/checkpoints/last.pt" ]] || fail "half a checkpoint was left"
