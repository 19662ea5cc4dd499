# cmake --install, then somebody else's project with find_package(diffsac) in a folder with a space in its name.
. "$(dirname "$0")/common.sh"
run_expecting 0 cmake --install "$build" --prefix "$own/in stalled"
compiler=$(sed -n 's/^CMAKE_CXX_COMPILER:[^=]*=//p' "$build/CMakeCache.txt")
run_expecting 0 cmake -S "$source/tests/integration/consumer" -B "$own/build" -G Ninja \
  -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_PREFIX_PATH="$own/in stalled"
run_expecting 0 cmake --build "$own/build"
run_expecting 0 "$own/build/fit_line"
grep -q "slope 0.500 intercept 1.000 inliers 7" "$own/out" || { cat "$own/out" >&2; fail "another line"; }
run_expecting 0 "$own/build/make_data"
grep -q "points 30" "$own/out" || { cat "$own/out" >&2; fail "other data"; }
run_expecting 0 "$own/build/guide" "$source/models/line/model.safetensors"
grep -q "guided slope 0.500 inliers 12" "$own/out" || { cat "$own/out" >&2; fail "another guided line"; }
if ldd "$own/build/guide" | grep -q -E "torch|c10"; then fail "the guide is linked with LibTorch"; fi
for program in diffsac_train diffsac_eval; do
  if [[ -x "$build/bin/$program" ]]; then run_expecting 0 "$own/in stalled/bin/$program" --version; fi
done
# What is installed runs from any folder, under a prefix that was moved: configurations and models lie beside the program.
mv "$own/in stalled" "$own/mo ved"
gray_blobs 200 150 140 3 0 >"$own/a.pgm"
gray_blobs 200 150 140 3 12 >"$own/b.pgm"
printf '300 0 100\n0 300 75\n0 0 1\n' >"$own/K.txt"
mkdir "$own/empty"
cd "$own/empty"
pair() { "$own/mo ved/bin/diffsac_pair" ../a.pgm ../b.pgm --threads 1 --picture "" "$@"; }
run_expecting 0 pair --task homography
grep -q 'homography matrix: [0-9]* inliers' "$own/out" || { cat "$own/out" >&2; fail "no homography"; }
run_expecting 0 pair --task fundamental
run_expecting 0 pair --calibration ../K.txt
# A configuration of somebody else's: its paths are relative to its file.
cp -r "$own/mo ved/share/diffsac/models/homography" "$own/theirs"
printf '%s\n' 'name: theirs' 'task: homography' \
  'methods: [{name: theirs, type: diffsac, checkpoint: theirs/model.safetensors}]' >"$own/theirs.yaml"
run_expecting 0 pair --task homography --config "$own/theirs.yaml"
rm -r "$own/theirs"
expect_error "theirs.yaml:3: .*no such checkpoint; looked for $own/theirs/model.safetensors, theirs/model.safetensors" \
  pair --task homography --config "$own/theirs.yaml"
rm "$own/mo ved/share/diffsac/configs/pair/homography.yaml"
expect_error "looked for $own/mo ved/share/diffsac/configs/pair/homography.yaml, configs/pair/homography.yaml" \
  pair --task homography
