# diffsac_prepare and convert.py on images of its own: matches, their summary, mistakes, Ctrl-C.
. "$(dirname "$0")/common.sh"
convert() { /usr/bin/python3 "$source/data_tools/convert.py" "$@"; }

# image SHIFT: grey blobs, moved to the right.
image() { gray_blobs 160 120 90 3 "$1"; }

mkdir "$own/views"
image 0 >"$own/views/img1.pgm"
image 9 >"$own/views/img2.pgm"
printf '1 0 9\n0 1 0\n0 0 1\n' >"$own/views/H1to2p"
run_expecting 0 prepare pairs --format homographies --input "$own/views" --output "$own/scenes" --threads 1
for file in matches match_conf Hgt sizes; do expect_file "$own/scenes/views/$file.h5"; done
run_expecting 0 convert inspect "$own/scenes"
grep -qE '^views +1 .* ok +ratio similarities sizes H$' "$own/out" || { cat "$own/out" >&2; fail "no summary of the scene"; }
awk '$1 == "views" && $4 > 50 { found = 1 } END { exit !found }' "$own/out" ||
  { cat "$own/out" >&2; fail "the matches do not follow the shift"; }

# The sets of a list: those that are there, by name or by the folders that they make.
printf 'sets:\n  - {name: shifted, input: [absent, views], format: homographies, output: %s, scenes: [views]}\n' "$own/listed" >"$own/sets.yaml"
printf '  - {name: elsewhere, input: [nowhere], format: images, output: %s, scenes: [nowhere]}\n' "$own/listed" >>"$own/sets.yaml"
sets=(convert sets --config "$own/sets.yaml" --data "$own" --program "$build/bin/diffsac_prepare")
run_expecting 0 "${sets[@]}"
grep -q 'left out: elsewhere' "$own/out" "$own/err" || fail "a set that is not there is not named"
expect_file "$own/listed/views/matches.h5"
run_expecting 0 "${sets[@]}" --only "$own/listed/views"
grep -q 'views: already there' "$own/out" "$own/err" || fail "a listed set was made again"
expect_error 'none of the sets' "${sets[@]}" --only elsewhere
expect_error 'no_sets' convert sets --config "$own/no_sets.yaml" --data "$own"

# Mistakes.
expect_error 'format' prepare pairs --format tiff --input "$own/views" --output "$own/scenes"
expect_error 'nowhere' prepare pairs --format images --input "$own/nowhere" --output "$own/scenes"
expect_error 'sequence' prepare pairs --format kitti --input "$own/views" --output "$own/scenes"
expect_error 'nowhere' convert inspect "$own/nowhere"
expect_error 'subcommand' prepare
touch "$own/file"
expect_error 'file' prepare pairs --format images --input "$own/views" --output "$own/file/scenes"
head -c 300 "$own/scenes/views/Hgt.h5" >"$own/cut"
mv "$own/cut" "$own/scenes/views/Hgt.h5"
expect_error 'Hgt\.h5' convert inspect "$own/scenes"
rm "$own/scenes/views/matches.h5"
expect_error 'matches\.h5' convert inspect "$own/scenes"

# A broken image is named and left out with its pairs; the rest is done, and is not done again.
mkdir "$own/some"
for i in 1 2 3; do cp "$own/views/img$((1 + i % 2)).pgm" "$own/some/$i.pgm"; done
echo "no image" >"$own/some/4.pgm"
some=(prepare pairs --format images --input "$own/some" --output "$own/scenes")
run_expecting 0 "${some[@]}" --steps 1,2
grep -q '4\.pgm' "$own/err" "$own/out" || { cat "$own/out" "$own/err" >&2; fail "the broken image is not named"; }
grep -q '1 of 4 images were left out' "$own/err" "$own/out" || { cat "$own/err" >&2; fail "no count at the end"; }
expect_file "$own/scenes/some_step_01/matches.h5" "$own/scenes/some_step_02/matches.h5"
run_expecting 0 "${some[@]}" --steps 1,2
grep -q 'some_step_01: already there' "$own/err" "$own/out" || { cat "$own/err" >&2; fail "the scene was made again"; }
run_expecting 0 "${some[@]}" --scene orb --features orb --descriptors
expect_file "$own/scenes/orb/descriptors.h5"

# Mistakes in what chooses pairs, calibrates and describes.
expect_error 'nobody' "${some[@]}" --scene a --pairs-file "$own/nobody.txt"
echo '1 9' >"$own/list.txt"
expect_error 'list.txt:1' "${some[@]}" --scene a --pairs-file "$own/list.txt"
expect_error 'every' "${some[@]}" --scene a --every 0
expect_error 'center' "${some[@]}" --scene a --focal 500
expect_error 'features' "${some[@]}" --scene a --features surf
expect_error 'list.txt' "${some[@]}" --scene a --import-descriptors "$own/list.txt"
mkdir "$own/empty"
for format in images colmap homographies colmap_database; do
  expect_error 'empty' prepare pairs --format "$format" --input "$own/empty" --output "$own/scenes"
done

# A picture of matches, with and without the images.
run_expecting 0 "${some[@]}" --scene drawn
run_expecting 0 convert inspect --picture "$own/p.png" "$own/scenes/drawn" --pair 1-2 --images "$own/some"
run_expecting 0 convert inspect --picture "$own/q.png" "$own/scenes/drawn"
expect_file "$own/p.png" "$own/q.png"
grep -q '1-2, [0-9]* matches' "$own/out" || { cat "$own/out" >&2; fail "no count beside the picture"; }
expect_error 'no pair 9-9' convert inspect --picture "$own/p.png" "$own/scenes/drawn" --pair 9-9
expect_error 'picture' convert inspect "$own/scenes/drawn" --pair 1-2

# Descriptors for a scene in the tutorial's layout.
mkdir -p "$own/tutorial/val"
cp -r "$own/scenes/drawn" "$own/tutorial/val/drawn"
cp -r "$own/some" "$own/tutorial/val/drawn/images"
rm -f "$own"/tutorial/val/drawn/{sizes,descriptors}.h5
if /usr/bin/python3 -c 'import cv2' 2>/dev/null; then
  run_expecting 0 convert tutorial "$own/tutorial/val/drawn"
  expect_file "$own"/tutorial/val/drawn/{sizes,descriptors}.h5
  grep -q '3 pairs, 3 images, .* 100.0 % have a keypoint' "$own/out" || { cat "$own/out" >&2; fail "no share of keypoints"; }
else
  expect_error 'python3-opencv' convert tutorial "$own/tutorial/val/drawn"
fi
expect_error 'nowhere' convert tutorial "$own/nowhere"

# Views of a mesh.
printf 'OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n3 0 2 3\n3 1 2 3\n' >"$own/mesh.off"
run_expecting 0 prepare modelnet --input "$own/mesh.off" --output "$own/meshes" --pairs 3 --points 50 --outlier-ratio 0.4
run_expecting 0 convert inspect "$own/meshes" --threshold-px 4
grep -qE '^modelnet40 +3 .* 60\.0 .* ok +sizes K pose E F labels$' "$own/out" || { cat "$own/out" >&2; fail "no summary"; }
expect_error 'outlier-ratio' prepare modelnet --input "$own/mesh.off" --output "$own/meshes" --outlier-ratio 2
expect_error 'nowhere' prepare modelnet --input "$own/nowhere" --output "$own/meshes"

# Ctrl-C: no scene that is not complete, and the next call goes on with the keypoints. Job control gives the background
# job the default SIGINT.
mkdir "$own/many"
for ((i = 0; i < 200; ++i)); do cp "$own/views/img1.pgm" "$own/many/$i.pgm"; done
many=("$build/bin/diffsac_prepare" pairs --format images --steps 1 --input "$own/many" --output "$own/interrupted")
set -m
"${many[@]}" >"$own/out" 2>"$own/err" &
job=$!
set +m
for ((i = 0; i < 500; ++i)); do
  [[ ! -d "$own/interrupted" ]] || break
  sleep 0.02
done
kill -INT "$job" || { cat "$own/err" >&2; fail "it ended before it could be interrupted"; }
status=0
wait "$job" || status=$?
((status == 130)) || { cat "$own/err" >&2; fail "an interrupted run ends with $status"; }
[[ -z "$(ls "$own/interrupted")" ]] || fail "an interrupted run left a scene"
run_expecting 0 "${many[@]}"
expect_file "$own/interrupted/many_step_01/matches.h5"
[[ "$(ls -A "$own/interrupted")" == many_step_01 ]] || fail "the keypoints are still there"
