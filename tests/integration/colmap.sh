# The chain of docs/colmap.md with COLMAP itself: its features and matches, our verification, its mapper.
. "$(dirname "$0")/common.sh"
photos="$source/../shared/data/lund_door/images"
skip() { echo "SKIPPED: $*"; exit 4; }
command -v colmap >/dev/null || skip "no colmap on this machine (docs/colmap.md says how to install it)"
[[ -d "$photos" ]] || skip "no photographs in $photos"
export QT_QPA_PLATFORM=offscreen OMP_NUM_THREADS=1
database="$own/database.db"
# sql STATEMENT: runs it on the database and prints what it gives.
sql() { python3 -c 'import sqlite3, sys
with sqlite3.connect(sys.argv[1]) as database: print(*[" ".join(map(str, row)) for row in database.execute(sys.argv[2])], sep="\n")' "$database" "$1"; }
verify=(evaluate --config configs/colmap/verify.yaml --set "data.paths=[$own/pairs]" --output "$own/run" --threads 1 --export-colmap)

mkdir "$own/images"
for i in 4 5 6 7; do ln -s "$photos/DSC_000$i.JPG" "$own/images/"; done
run_expecting 0 colmap feature_extractor --database_path "$database" --image_path "$own/images" \
  --ImageReader.camera_model SIMPLE_RADIAL --ImageReader.single_camera 1 --ImageReader.camera_params 2435.38,648,968,-0.0336422 \
  --SiftExtraction.use_gpu 0 --SiftExtraction.num_threads 1 --SiftExtraction.max_image_size 800 --SiftExtraction.max_num_features 1500
run_expecting 0 colmap exhaustive_matcher --database_path "$database" --SiftMatching.use_gpu 0 --SiftMatching.num_threads 1

# All pairs, and nothing of COLMAP's own verification in the way unless that is said.
run_expecting 0 prepare pairs --format colmap_database --input "$database" --output "$own/pairs" --ratios --threads 1
for file in matches match_conf match_indices K1_K2 sizes; do expect_file "$own/pairs/database/$file.h5"; done
expect_error '6 of the 6 pairs have a two-view geometry already; --export-overwrite' "${verify[@]}" "$database"
expect_file "$own/run/run.json"
colmaps=$(sql "SELECT sum(rows) FROM two_view_geometries")
sql "DELETE FROM two_view_geometries" >/dev/null
run_expecting 0 "${verify[@]}" "$database"
grep -q 'database.db: 6 of 6 pairs verified' "$own/out" || { cat "$own/out" >&2; fail "pairs are missing"; }
# Uncalibrated ones by F, calibrated ones by E.
for task in "fundamental 3" "essential 2"; do
  run_expecting 0 "${verify[@]}" "$database" --export-overwrite --set "task=${task% *}"
  ours=$(sql "SELECT sum(rows) FROM two_view_geometries WHERE config = ${task#* }")
  ((10 * ours > 9 * colmaps)) || fail "$ours inliers by ${task% *} where COLMAP finds $colmaps"
done

mkdir "$own/model"
run_expecting 0 colmap mapper --database_path "$database" --image_path "$own/images" --output_path "$own/model" --Mapper.num_threads 1
run_expecting 0 colmap model_analyzer --path "$own/model/0"
cat "$own/err" >>"$own/out"
grep -qE 'Registered images: 4$' "$own/out" || { cat "$own/out" >&2; fail "not all images are registered"; }
awk -F: '/Mean reprojection error/ { exit !($2 + 0 < 1) }' "$own/out" || { cat "$own/out" >&2; fail "a large error"; }

# Bad databases: one line each, and nothing is written.
expect_error 'no such file' "${verify[@]}" "$own/nowhere.db"
head -c 100000 "$database" >"$own/cut.db"
expect_error 'cut.db: (damaged or truncated|.*no table)' prepare pairs --format colmap_database --input "$own/cut.db" --output "$own/bad"
echo "no database" >"$own/text.db"
expect_error 'text.db: not an SQLite database' prepare pairs --format colmap_database --input "$own/text.db" --output "$own/bad"
sql "DELETE FROM matches" >/dev/null
expect_error 'it holds no matches' prepare pairs --format colmap_database --input "$database" --output "$own/bad"
[[ ! -e "$own/bad" ]] || fail "a bad database left files"
