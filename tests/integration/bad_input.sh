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
expect_error 'nothere\.safetensors' evaluate "${table[@]}" --checkpoint "$own/nothere.safetensors" --output "$own/run"
size=$(stat -c %s "$tiny_model")
head -c $((size / 2)) "$tiny_model" >"$own/truncated.safetensors"
expect_error 'truncated\.safetensors' evaluate "${table[@]}" --checkpoint "$own/truncated.safetensors" --output "$own/run"
: >"$own/empty.safetensors"
expect_error 'empty\.safetensors' evaluate "${table[@]}" --checkpoint "$own/empty.safetensors" --output "$own/run"
expect_error "$(basename "$tiny_model")" evaluate --config configs/tables/plane.yaml --methods diffsac --limit 2 \
  --checkpoint "$tiny_model" --output "$own/run"
# An archive as older programs kept networks in, which runs code when LibTorch opens it: its __setstate__ writes the file
# hostile_was_here. Made in C++ by
#   torch::jit::Module m("Hostile");  m.register_parameter("x", torch::zeros({1}), false);
#   m.define("def __getstate__(self):\n  return self.x\n"
#            "def __setstate__(self, state: Tensor) -> None:\n  torch.save(state, \"hostile_was_here\")\n  self.x = state\n"
#            "def forward(self, x: Tensor) -> Tensor:\n  return x\n");  m.save("hostile_archive.zip");
hostile=$source/tests/integration/hostile_archive.zip
cd "$own"
expect_error 'hostile_archive\.zip: not a safetensors file: a zip archive.*train again' \
  evaluate --config "$source/configs/tables/line.yaml" --methods diffsac --limit 2 --checkpoint "$hostile" --output "$own/run"
expect_error 'a zip archive' train --config "$source/configs/line.yaml" --set "train.start_from=$hostile" --output "$own/start"
expect_error 'a zip archive' train --config "$source/configs/line.yaml" --import "$hostile" --output "$own/import"
mkdir -p "$own/resume/checkpoints" && cp "$hostile" "$own/resume/checkpoints/last.safetensors"
expect_error 'a zip archive' train --config "$source/configs/line.yaml" --resume --output "$own/resume"
[[ ! -e hostile_was_here ]] || fail "a checkpoint ran code"
cd "$source"
expect_error '.' train "${tiny[@]}" --resume --output "$own/never_started"

# Devices: names that are none, and devices that are not there, before anything is written.
rows=(--config configs/tables/line.yaml --methods ransac_20 --limit 2)
mkdir -p "$own/made" && echo '{}' >"$own/made/results.json"
for device in tpu '' cuda:x; do
  expect_error "device '$device': expected auto, cpu, cuda or cuda:INDEX" train --config configs/line.yaml --device "$device" --output "$own/none"
  expect_error "device '$device': expected auto, cpu, cuda or cuda:INDEX" evaluate "${rows[@]}" --device "$device" --output "$own/made"
done
for device in cuda:99; do
  expect_error "device '$device': (this LibTorch sees no|there are)" train --config configs/line.yaml --device "$device" --output "$own/none"
  expect_error "device '$device': (this LibTorch sees no|there are)" evaluate "${rows[@]}" --device "$device" --output "$own/made"
done
expect_error "device 'tpu'" train --config configs/line.yaml --import "$hostile" --device tpu --output "$own/none"
[[ ! -e "$own/none" && -s "$own/made/results.json" ]] || fail "a device that is not there changed a run folder"

# Data.
mkdir "$own/truncated" && printf '\211HDF\r\n\032\n\000\000' >"$own/truncated/matches.h5"
printf '%s\n' 'name: pairs' 'task: fundamental' "data: {type: correspondences, paths: ['$own/truncated']}" \
  'methods: {ransac_20: {type: ransac, max_iterations: 20}}' >"$own/pairs.yaml"
expect_error 'truncated/matches\.h5' evaluate --config "$own/pairs.yaml" --output "$own/run"
expect_error 'nowhere' evaluate --config configs/tables/line.yaml --methods ransac_20 --output "$own/run" \
  --set "data={type: point_sets, paths: ['$own/nowhere'], inlier_threshold: 0.1}" --set 'sweep=~'

# Output that cannot be written: below a regular file, and on a disk that is full (a file size limit acts alike).
touch "$own/file"
expect_error 'file' evaluate "${table[@]}" --checkpoint "$tiny_model" --output "$own/file/run"
expect_error 'file' train "${tiny[@]}" --output "$own/file/run"
with_full_disk() { (trap '' XFSZ; ulimit -f 4; "$@"); }
got=0
with_full_disk train "${tiny[@]}" --set train.iterations=2 --output "$own/full" >"$own/out" 2>"$own/err" || got=$?
((got == 2)) || { cat "$own/err" >&2; fail "a full disk ends training with $got"; }
grep -q '^diffsac_train: .*checkpoints' "$own/err" || { cat "$own/err" >&2; fail "no clear line about the full disk"; }
[[ ! -e "$own/full/checkpoints/last.safetensors" ]] || fail "half a checkpoint was left"
