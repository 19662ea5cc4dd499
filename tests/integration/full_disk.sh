# A disk that fills, files that may not grow, and folders that cannot be written to: each program ends with status 2 and
# one line that names a file, leaves nothing half, and continues when there is room. The disk is a small tmpfs, and
# read-only is a mount; where this process may not mount, only the rest is tried.
. "$(dirname "$0")/common.sh"
files="$source/tests/integration/run_files.py"
mkdir "$own/images" "$own/disk"
for i in 1 2 3; do gray_blobs 160 120 90 3 $((6 * i)) >"$own/images/$i.pgm"; done

# KIND_on FOLDER: the call, continued where it was begun.
train_on() {
  local resume=()
  [[ ! -f "$1/checkpoints/last.safetensors" ]] || resume=(--resume)
  train "${tiny[@]}" --set train.iterations=20 --set train.validate_every=10 --set train.checkpoint_every=5 --output "$1" \
    "${resume[@]}"
}
evaluate_on() {
  evaluate --config configs/tables/line.yaml --methods ransac_20,theil_sen,oracle --limit 40 --set estimates=true --threads 1 \
    --update --output "$1"
}
prepare_on() { prepare pairs --format images --input "$own/images" --output "$1" --steps 1,2 --descriptors --threads 1; }
kinds=(train evaluate prepare)
for kind in "${kinds[@]}"; do run_expecting 0 "${kind}_on" "$own/${kind}_whole"; done

# ends_clearly KIND STATUS FOLDER: one line of the program's that names a file below FOLDER, nothing half, nothing left.
ends_clearly() {
  local name="diffsac_${1/evaluate/eval}" lines
  lines=$(grep -c "^$name: " "$own/err" || true)
  (($2 == 2 && lines == 1)) && grep -q "^$name: .*$3" "$own/err" || { cat "$own/err" >&2; fail "$1: status $2, $lines clear lines"; }
  ! grep -qiE 'terminate called|HDF5-DIAG|infinite loop|segmentation' "$own/err" || { cat "$own/err" >&2; fail "$1: noise"; }
  [[ ! -d "$3" ]] || python3 "$files" whole "$3"
  [[ -z "$(find "$3" -name '*.tmp*' 2>/dev/null)" ]] || fail "$1 leaves temporary files"
}

# continues KIND FOLDER: there is room again.
continues() {
  run_expecting 0 "$1_on" "$2"
  python3 "$files" same "$own/$1_whole" "$2" || fail "$1: continues to another result"
}

# Files of at most so many KiB, as `ulimit -f` has it; the signal that would end the program is ignored.
for kind in "${kinds[@]}"; do
  failed=0
  for most in 1 24; do
    folder="$own/${kind}_$most" status=0
    (trap '' XFSZ; ulimit -f "$most"; "${kind}_on" "$folder") >"$own/out" 2>"$own/err" || status=$?
    ((status == 0)) || { failed=$((failed + 1)); ends_clearly "$kind" "$status" "$folder"; }
    continues "$kind" "$folder"
  done
  ((failed > 0)) || fail "$kind needs no file of more than a KiB"
done

# A path below a file.
touch "$own/file"
for kind in "${kinds[@]}"; do
  status=0
  "${kind}_on" "$own/file/run" >"$own/out" 2>"$own/err" || status=$?
  ends_clearly "$kind" "$status" "$own/file/run"
done

if ! mount -t tmpfs -o size=4m diffsac_test "$own/disk" 2>/dev/null; then
  echo "without a full disk: no tmpfs and no read-only folder, as nothing can be mounted here"
  exit 0
fi
trap 'umount "$own/disk"' EXIT
for kind in "${kinds[@]}"; do
  failed=0
  for free in 0 40 160; do
    rm -rf "$own"/disk/*
    # What does not fit into a full disk is no failure of head.
    head -c 4m /dev/zero >"$own/disk/filler" 2>/dev/null || true
    truncate -s "-${free}K" "$own/disk/filler"
    status=0
    "${kind}_on" "$own/disk/run" >"$own/out" 2>"$own/err" || status=$?
    ((status == 0)) || { failed=$((failed + 1)); ends_clearly "$kind" "$status" "$own/disk/run"; }
    rm "$own/disk/filler"
    continues "$kind" "$own/disk/run"
  done
  ((failed > 1)) || fail "$kind fits into a full disk"

  mount -o remount,ro "$own/disk"
  status=0
  "${kind}_on" "$own/disk/new" >"$own/out" 2>"$own/err" || status=$?
  ends_clearly "$kind" "$status" "$own/disk/new"
  mount -o remount,rw "$own/disk"
done
