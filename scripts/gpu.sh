#!/usr/bin/env bash
# What needs a GPU, on a machine that has one and builds nothing.
#
#   scripts/gpu.sh pack BUILD FILE.tar.xz [PATH...]   here: the programs of a build with -DDIFFSAC_CUDA=ON, the libraries they need beside
#                                                     LibTorch, configs, models, and other paths of this folder (runs/pairs/...)
#   scripts/gpu.sh run FOLDER                         there, where FILE was unpacked: device_test, then trainings; FOLDER/gpu.md tells
#
# There LibTorch comes from python3's torch, which must be of the version that was built with. DEVICE (default cuda; cpu for a rehearsal),
# MINUTES for each training (default 10), CONFIGS (default: lines and planes at the paper's size, then E and F).
set -euo pipefail

usage() {
  sed -n '2,11s/^# \{0,1\}//p' "$0" >&2
  exit 2
}

# Libraries that the other machine has: its own C library, and what comes with LibTorch.
is_theirs() { [[ "$1" =~ /(ld-linux|libc|libm|libdl|librt|libpthread|libresolv|libutil|libstdc\+\+|libgcc_s|libtorch|libc10|libcu(da|blas|dnn|fft|rand|solver|sparse|pti|file)|libnv|libnccl|libgomp-) ]]; }

pack() {
  local build=$1 file=$2
  [[ -x "$build/bin/diffsac_train" && -x "$build/bin/device_test" ]] || { echo "gpu: $build/bin has no diffsac_train and device_test" >&2; exit 2; }
  folder=$(mktemp -d)
  trap 'rm -rf "$folder"' EXIT     # So it is no local variable.
  mkdir -p "$folder/bin" "$folder/lib"
  for program in device_test diffsac_train; do
    strip -o "$folder/bin/$program" "$build/bin/$program"
    { ldd "$build/bin/$program" || true; } | awk '$3 ~ "^/" {print $3}' | while read -r library; do
      is_theirs "$library" || cp -Lu "$library" "$folder/lib/"
    done
  done
  sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$build/CMakeCache.txt" > "$folder/source_dir"
  cp -r configs scripts "$folder/"
  for path in models "${@:3}"; do
    mkdir -p "$folder/$(dirname "$path")"
    cp -r "$path" "$folder/$path"
  done
  tar c -C "$folder" . | xz -T0 -3 > "$file"
  echo "gpu: $file, $(du -h "$file" | cut -f1)"
}

run() {
  local folder device=${DEVICE:-cuda} minutes=${MINUTES:-10} source torch
  folder=$(cd "$1" && pwd)
  source=$(cat "$folder/source_dir")
  torch=$(python3 -c 'import os, torch; print(os.path.dirname(torch.__file__))' 2> /dev/null || true)
  # Tests know where their files are by the path that they were built in.
  [[ -e "$source" ]] || { mkdir -p "$(dirname "$source")" && ln -s "$folder" "$source"; }
  cd "$folder"
  ours() { LD_LIBRARY_PATH="${torch:+$torch/lib:}$folder/lib" "$@"; }
  local page=$folder/gpu.md
  { echo "# On a GPU"; echo; nvidia-smi --query-gpu=name,driver_version --format=csv,noheader 2> /dev/null || echo "device $device"; } > "$page"
  local status=0
  DIFFSAC_TEST_DEVICE=$device ours "$folder/bin/device_test" -d yes > device_test.log 2>&1 || status=$?
  printf '\ndevice_test: status %s; %s\n\n| training | steps | steps a second | loss |\n|---|---|---|---|\n' \
    "$status" "$(grep -E '^(test cases|All tests)' device_test.log | tail -n 1)" >> "$page"
  for config in ${CONFIGS:-configs/paper/line.yaml configs/paper/plane.yaml configs/essential.yaml configs/fundamental.yaml}; do
    local name start seconds steps loss
    name=$(basename "$config" .yaml)
    start=$(date +%s)
    ours timeout -s INT "${minutes}m" "$folder/bin/diffsac_train" --config "$config" --device "$device" --output "runs/gpu_$name" \
      --overwrite --set train.log_every=10 --set train.workers=4 > "$name.log" 2>&1 || true
    seconds=$(($(date +%s) - start))
    if [[ ! -s "runs/gpu_$name/metrics.csv" ]]; then
      echo "| $config | $(tail -n 1 "$name.log") | | |" >> "$page"
      continue
    fi
    read -r steps loss < <(tail -n 1 "runs/gpu_$name/metrics.csv" | tr , ' ' | cut -d ' ' -f 1,2)
    [[ "$steps" =~ ^[0-9]+$ ]] || steps=0 loss=-
    echo "| $config | $steps | $(awk "BEGIN {printf \"%.2f\", $steps / ($seconds > 0 ? $seconds : 1)}") | $loss |" >> "$page"
  done
  cat "$page"
  return "$status"
}

case "${1:-}" in
  pack) [[ $# -ge 3 ]] || usage; pack "${@:2}" ;;
  run) [[ $# -eq 2 ]] || usage; run "$2" ;;
  *) usage ;;
esac
