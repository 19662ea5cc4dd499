# Sourced by the tests with: build folder, source folder, work folder. Each test works in a new folder of its own.
set -euo pipefail
build=$1 source=$2
tiny_model="$3/train/run/checkpoints/last.safetensors"
own="$3/$(basename "$0" .sh)"
rm -rf "$own"
mkdir -p "$own"
cd "$source"

# The python3 that has the modules of scripts/report; fails where there is none.
report_python() {
  local python
  for python in python3 /usr/bin/python3; do
    if "$python" scripts/report/check_modules.py 2>/dev/null; then echo "$python"; return; fi
  done
  return 1
}

train() { "$build/bin/diffsac_train" "$@"; }
evaluate() { "$build/bin/diffsac_eval" "$@"; }
prepare() { "$build/bin/diffsac_prepare" "$@"; }
fail() { echo "FAILED: $*" >&2; exit 1; }
# report SCRIPT ARGUMENTS...: of scripts/report; an empty SCRIPT makes the tables and pictures of a folder.
report() { "$(report_python)" "scripts/report/$1" "${@:2}"; }
expect_file() { local file; for file in "$@"; do [[ -s "$file" ]] || fail "missing or empty: $file"; done; }

# A network and a run small enough for a few seconds.
tiny=(--config configs/line.yaml --threads 1 --device cpu --seed 3
  --set data.num_points=40 --set network.features.residual_draws=20 --set network.features.residual_kept=4
  --set network.denoiser.width=16 --set network.denoiser.encoder_layers=1 --set network.denoiser.layers=1
  --set train.batch_size=8 --set train.noise_copies=2 --set train.warmup_iterations=2 --set train.log_every=5
  --set validation.problems=8 --set "validation.outlier_ratios=[0.5]" --set inference.num_diffusion_samples=4)

# run_expecting STATUS COMMAND...: runs it with its output in $own/out and $own/err.
run_expecting() {
  local status=$1 got=0
  shift
  "$@" >"$own/out" 2>"$own/err" || got=$?
  if ((got != status)); then
    cat "$own/out" "$own/err" >&2
    fail "exit status $got instead of $status: $*"
  fi
}

# expect_error PATTERN PROGRAM ARGUMENTS...: exit status 2 and one line of the program's on stderr that has PATTERN.
expect_error() {
  local pattern=$1 name="diffsac_${2/evaluate/eval}"
  name=${name/diffsac_convert/convert}  # A script.
  shift
  run_expecting 2 "$@"
  local lines
  lines=$(grep -c "^$name: " "$own/err" || true)
  ((lines == 1)) || { cat "$own/err" >&2; fail "$lines lines of $name instead of one: $*"; }
  grep -qE "^$name: .*($pattern)" "$own/err" || { cat "$own/err" >&2; fail "no '$pattern' in the message: $*"; }
  ! grep -qiE 'terminate called|segmentation|backtrace' "$own/err" || { cat "$own/err" >&2; fail "a crash: $*"; }
}

# same_results RUN_A RUN_B WHAT: what their problems.csv say is the same but for times; else WHAT went wrong.
same_results() { diff <(without_times "$1") <(without_times "$2") || fail "$3"; }
without_times() {
  python3 - "$1/problems.csv" <<'PYTHON'
import csv, sys
rows = list(csv.reader(open(sys.argv[1])))
for row in rows:
    print(*(value for name, value in zip(rows[0], row) if not name.startswith("ms_")), sep=",")
PYTHON
}

# same_network RUN_A RUN_B WHAT: the networks of both trainings estimate the same.
same_network() {
  local run
  for run in "$1" "$2"; do
    run_expecting 0 evaluate --config configs/tables/line.yaml --methods diffsac --limit 8 --device cpu --threads 1 \
      --checkpoint "$run/checkpoints/last.safetensors" --output "$run.evaluated"
  done
  same_results "$1.evaluated" "$2.evaluated" "$3"
}

# start_ranks NAME COMMAND...: two processes with a launcher's variables in the background, `ranks`, their output in $own/NAME.RANK.
start_ranks() {
  local rank port name=$1
  shift
  port=$(python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
  ranks=()
  for rank in 0 1; do
    env RANK=$rank WORLD_SIZE=2 LOCAL_RANK=$rank LOCAL_WORLD_SIZE=2 MASTER_ADDR=127.0.0.1 MASTER_PORT="$port" \
      OMP_WAIT_POLICY=passive "$@" >"$own/$name.$rank" 2>"$own/$name.$rank.err" &
    ranks+=($!)
  done
}

# gray_blobs WIDTH HEIGHT BLOBS SEED SHIFT: a PGM image of blobs, moved to the right.
gray_blobs() {
  awk -v width="$1" -v height="$2" -v blobs="$3" -v seed="$4" -v shift_x="$5" 'BEGIN {
    srand(seed)
    for (b = 0; b < blobs; ++b) { x = rand() * width; y = rand() * height; r = 2 + 3 * rand(); h = 240 * rand() - 120
      for (i = int(y - 3 * r); i <= y + 3 * r; ++i) for (j = int(x - 3 * r); j <= x + 3 * r; ++j)
        sum[i, j] += h * exp(-((i - y) ^ 2 + (j - x) ^ 2) / (2 * r * r)) }
    print "P2\n" width, height, 255
    for (i = 0; i < height; ++i) for (j = 0; j < width; ++j) {
      v = int(128 + sum[i, j - shift_x]); v = v < 0 ? 0 : (v > 255 ? 255 : v); print v } }'
}

# room WIDTH HEIGHT FOCAL TURN PITCH: a PGM image of a room with tiled walls, its camera turned and pitched (up) by degrees.
room() {
  awk -v width="$1" -v height="$2" -v focal="$3" -v turn="$4" -v pitch="$5" 'BEGIN {
    degree = atan2(0, -1) / 180
    ct = cos(turn * degree); st = sin(turn * degree); cp = cos(pitch * degree); sp = sin(pitch * degree)
    split("3 1.5 4", half, " ")
    print "P2\n" width, height, 255
    for (v = 0; v < height; ++v) for (u = 0; u < width; ++u) {
      sum = 0
      for (s = 0; s < 4; ++s) {
        x = (u + (s % 2) / 2 - 0.25 - (width - 1) / 2) / focal; y = (v + int(s / 2) / 2 - 0.25 - (height - 1) / 2) / focal
        # From the camera to the world, whose y axis points down.
        d[2] = cp * y - sp; z = sp * y + cp; d[1] = ct * x - st * z; d[3] = st * x + ct * z
        least = 1e9
        for (k = 1; k <= 3; ++k) { t = d[k] == 0 ? 1e9 : half[k] / (d[k] < 0 ? -d[k] : d[k]); if (t < least) { least = t; wall = k } }
        a = wall == 1 ? 2 : 1; b = wall == 3 ? 2 : 3
        i = int(least * d[a] / 0.75 + 100); j = int(least * d[b] / 0.75 + 100)
        shade = 43758.5453 * (1 + sin(12.9898 * i + 78.233 * j + 37.719 * wall + (d[wall] > 0)))
        sum += 40 + 180 * (shade - int(shade))
      }
      print int(sum / 4) } }'
}
