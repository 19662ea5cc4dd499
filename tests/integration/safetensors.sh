# Checkpoints, shipped and fresh, are read by a program that is not ours.
. "$(dirname "$0")/common.sh"
if ! command -v python3 >/dev/null; then echo "skipped: there is no python3"; exit 4; fi
show() { run_expecting 0 python3 tests/integration/read_safetensors.py "$1"; }
expect_line() { grep -qxE "$1" "$own/out" || { cat "$own/out" >&2; fail "no line '$1'"; }; }
for model in models/*/model.safetensors; do
  show "$model"
  expect_line 'average [0-9]+ [0-9]+ finite'
  expect_line '(diffsac|ng_ransac|clnet|structure_chooser) (line|plane|essential|fundamental|homography|vanishing_point) [0-9]+'
  if grep -qE '^(network|optimizer)' "$own/out"; then fail "$model: a shipped model with what training alone reads"; fi
done
show models/line/model.safetensors
expect_line 'average 76 409562 finite' # models/README.md
expect_line 'diffsac line 500'
show "$tiny_model"
iteration=$(sed -n 's/^diffsac line //p' "$own/out")
expect_line "steps $iteration"
expect_line 'network [0-9]+ [0-9]+ finite'
expect_line 'optimizer [0-9]+ [0-9]+ finite'
