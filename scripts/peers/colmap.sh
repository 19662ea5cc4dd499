#!/usr/bin/env bash
# COLMAP's verification of matches beside ours: the same database, the same raw matches, one thread each, both mapped by
# COLMAP. Prints the rows of docs/results/colmap.md. Needs colmap, sqlite3 and python3; not part of the build.
#
#   scripts/peers/colmap.sh DIR [SCENE...]    DIR/lund_door, DIR/strecha/castle-P19, DIR/fox, DIR/mobilebrick
#
# SCENE:unknown tells nobody the calibration: cameras have what COLMAP finds in EXIF data, else its guess. Features and
# matches stay in runs/colmap/SCENE/raw.db and are found once.
set -euo pipefail
data=$(cd "${1:?usage: scripts/peers/colmap.sh DIR [SCENE...]}" && pwd)
shift
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
(($#)) || set -- lund_door castle-P19
bin=build/release/bin
export OMP_NUM_THREADS=1 OMP_WAIT_POLICY=passive QT_QPA_PLATFORM=offscreen

# scene NAME[:unknown]: images, COLMAP's camera (its pixels begin at the corner of the first one), every which image, true poses
scene() {
  every=1 tasks="essential fundamental"
  case "${1%:unknown}" in
    lund_door) images=lund_door/images camera="SIMPLE_RADIAL 2435.38,648,968,-0.0336422" truth="colmap lund_door/colmap_ground_truth" ;;
    castle-P19) images=strecha/castle-P19/images camera="PINHOLE 2759.48,2764.16,1521.19,1007.31" truth="strecha strecha/castle-P19" ;;
    fox) images=fox/images camera="OPENCV 1375.52,1374.49,554.558,965.268,0.0578421,-0.0805099,-0.000980296,0.00015575"
         truth="nerf fox" every=3 ;;
    mobilebrick) images=mobilebrick/image camera="PINHOLE 1459.5,1459.5,962.65,725.1" truth="poses mobilebrick" ;;
    *) echo "unknown scene $1" >&2; return 1 ;;
  esac
  [[ "$1" != *:unknown ]] || camera="" tasks="fundamental shared_focal"
}

# seconds LOG COMMAND...: processor seconds that it takes, its output in LOG.
seconds() {
  local log=$1 TIMEFORMAT='%U %S'
  shift
  { time "$@" >"$log" 2>&1; } 2>&1 | awk '{ printf "%.2f", $1 + $2 }'
}

# total_seconds FILE: the sum of ms_total of a problems.csv.
total_seconds() {
  awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == "ms_total") column = i; next }
           { sum += $column } END { printf "%.2f", sum / 1000 }' "$1"
}

find_matches() {
  ls "$data/$images" | grep -iE '\.jpg$' | awk -v every="$every" '(NR - 1) % every == 0' >"$work/images.txt"
  local given=()
  [[ -z "$camera" ]] || given=(--ImageReader.camera_model "${camera% *}" --ImageReader.camera_params "${camera#* }")
  colmap feature_extractor --database_path "$work/new.db" --image_path "$data/$images" --image_list_path "$work/images.txt" \
    --ImageReader.single_camera 1 "${given[@]}" --SiftExtraction.use_gpu 0 --SiftExtraction.num_threads 1 >"$work/extract.log" 2>&1
  colmap exhaustive_matcher --database_path "$work/new.db" --SiftMatching.use_gpu 0 --SiftMatching.num_threads 1 >"$work/match.log" 2>&1
  sqlite3 "$work/new.db" "DELETE FROM two_view_geometries"
  mv "$work/new.db" "$work/raw.db"
}

# value NAME: what the analysis of $model says.
value() { awk -F': ' -v name="$1" '$1 ~ name"$" { print $2 }' "$model/analysis"; }

# map SCENE NAME TIMES: reconstructs $work/NAME.db and prints the row, of the model with the most images.
map() {
  local models="$work/model_$2" model
  rm -rf "$models" && mkdir -p "$models"
  colmap mapper --database_path "$work/$2.db" --image_path "$data/$images" --output_path "$models" --Mapper.num_threads 1 >"$models/log" 2>&1
  for model in "$models"/*/; do
    colmap model_analyzer --path "$model" >"$model/analysis" 2>&1
    echo "$(value 'Registered images') $model"
  done | sort -rn >"$models/list"
  model=$(head -n 1 "$models/list" | cut -d ' ' -f 2)
  mkdir "$model/text"
  colmap model_converter --input_path "$model" --output_path "$model/text" --output_type TXT >/dev/null 2>&1
  local poses pairs
  poses=$(scripts/peers/colmap_poses.py "$model/text" "${truth% *}" "$data/${truth#* }")
  pairs=$(sqlite3 -separator ' | ' "$work/$2.db" "SELECT count(*), sum(rows) FROM two_view_geometries WHERE rows >= 15")
  echo "| $1 | $2 | $pairs | $(value 'Registered images') of $(wc -l <"$work/images.txt") | $(value Points) |" \
    "$(value Observations) | $(value 'Mean reprojection error') | ${poses/ / | } | $3 |"
}

compare() {
  scene "$1"
  work=runs/colmap/${1/:/_}
  mkdir -p "$work"
  [[ -f "$work/raw.db" ]] || find_matches
  local name task time start
  for name in colmap $tasks; do
    rm -f "$work/$name.db"*
    cp "$work/raw.db" "$work/$name.db"
  done
  time=$(seconds "$work/colmap.log" colmap exhaustive_matcher --database_path "$work/colmap.db" --SiftMatching.use_gpu 0 --SiftMatching.num_threads 1)
  map "$1" colmap "$time | – | –"
  for task in $tasks; do
    start=$(seconds "$work/prepare.log" "$bin/diffsac_prepare" pairs --format colmap_database --input "$work/$task.db" \
      --output "$work/pairs" --scene "${1/:/_}" --overwrite --threads 1)
    time=$(seconds "$work/$task.log" "$bin/diffsac_eval" --config configs/colmap/verify.yaml --set "task=$task" --set "data.paths=[$work/pairs/${1/:/_}]" \
      --output "$work/run_$task" --threads 1 --export-colmap "$work/$task.db")
    map "$1" "$task" "$(total_seconds "$work/run_$task/problems.csv") | $start | $time"
  done
}

echo "| scene | verified by | pairs | inliers | registered | points | observations | reprojection error | rotation, ° | baseline, ° | verification, s | prepare, s | evaluate, s |"
echo "|---|---|---|---|---|---|---|---|---|---|---|---|---|"
for name in "$@"; do compare "$name"; done
