# cmake --install, then somebody else's projects with find_package(diffsac) and with pkg-config in a folder with a space in its
# name, which moves.
. "$(dirname "$0")/common.sh"
run_expecting 0 cmake --install "$build" --prefix "$own/in stalled"
compiler=$(sed -n 's/^CMAKE_CXX_COMPILER:[^=]*=//p' "$build/CMakeCache.txt")
# The library alone: nothing but Eigen and TBB is looked for, and nothing else is linked.
consume() {
  run_expecting 0 cmake -S "$source/tests/integration/consumer" -B "$own/$1" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_PREFIX_PATH="$own/in stalled" "${@:2}"
  run_expecting 0 cmake --build "$own/$1"
}
consume build
grep -q -i -E "yaml|HDF5|torch|opencv|sqlite|spdlog" "$own/build/CMakeCache.txt" && fail "the library asks for more than Eigen and TBB"
for name in pose estimates fit_line circle upright; do
  if ldd "$own/build/$name" | cut -d "(" -f 1 | grep -E "torch|libc10|yaml|hdf5|opencv|sqlite|spdlog|fmt"; then fail "$name is linked with more"; fi
done
run_expecting 0 "$own/build/fit_line"
grep -q "slope 0.500 intercept 1.000 inliers 7" "$own/out" || { cat "$own/out" >&2; fail "another line"; }
# Own models: a circle that is known; a pose that is, in real pairs where they were prepared.
run_expecting 0 "$own/build/circle"
cat "$own/out"
python=$(report_python) || python=
for folder in runs/pairs/test/castle-P19 runs/pairs/test/lund_door runs/pairs/test/kitti_01_step_02; do
  if [[ -z "$python" || ! -d "$folder" ]]; then echo "upright: skipped, no $folder or no python3 with h5py"; continue; fi
  "$python" tests/integration/consumer/upright_matches.py "$folder" >"$own/rays"
  upright() { "$own/build/upright" <"$own/rays"; }
  run_expecting 0 upright
  echo "upright: $folder: $(cat "$own/out")"
done
# Points before two cameras, every fourth match wrong: every function has an answer, those of E and of poses the motion's inliers.
awk 'BEGIN { srand(1); for (i = 0; i < 200; ++i) { x = 4 * rand() - 2; y = 3 * rand() - 1.5; z = 4 + 4 * rand(); w = i % 4 == 0
  x2 = 0.995 * x + 0.0998 * z + 0.9; z2 = 0.995 * z - 0.0998 * x + 0.2
  printf "%.9f %.9f %.9f %.9f %.9f %.9f %.9f %g\n", x, y, z, 600 * x / z + 320, 600 * y / z + 240,
    w ? 640 * rand() : 600 * x2 / z2 + 320, w ? 480 * rand() : 600 * (y + 0.1) / z2 + 240, w ? 0.9 : 0.5 } }' >"$own/rows"
estimates() { "$own/build/estimates" <"$own/rows"; }
run_expecting 0 estimates
for name in essential fundamental homography absolute_pose shared_focal one_focal two_focals line plane; do
  grep -q "^$name.model [-0-9]" "$own/out" || { cat "$own/out" >&2; fail "no $name"; }
done
for name in essential absolute_pose; do
  (($(grep "^$name.inliers" "$own/out" | grep -o ' 1' | wc -l) >= 145)) || { cat "$own/out" >&2; fail "another $name"; }
done
for name in essentials fundamentals homographies absolute_poses lines planes vanishing; do
  grep -q "^$name.assignment" "$own/out" || { cat "$own/out" >&2; fail "no $name"; }
done
consume lab -DLAB=ON
run_expecting 0 "$own/lab/make_data"
grep -q "points 30" "$own/out" || { cat "$own/out" >&2; fail "other data"; }
# What is installed runs from any folder, under a prefix that was moved: configurations lie beside the program.
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
room 320 240 260 35 8 >"$own/room.pgm"
run_expecting 0 "$own/mo ved/bin/diffsac_vanish" ../room.pgm --picture ""
grep -q '^focal length: [0-9]* px' "$own/out" || { cat "$own/out" >&2; fail "no focal length"; }
run_expecting 0 pair --calibration ../K.txt --json ../pair.json --matches ../matches.txt
# Configurations by their names, and all that --help names.
if [[ -x "$build/bin/diffsac_train" ]]; then
  lab() { "$own/mo ved/bin/diffsac_$1" --config line.yaml --threads 1 --device cpu "${@:2}"; }
  run_expecting 0 lab train "${tiny[@]:6}" --set train.iterations=2 --output run
  run_expecting 0 lab eval --limit 2 --output table
  expect_file run/checkpoints/last.safetensors table/run.json
fi
# What installed pages link to is installed.
while IFS=: read -r page link; do
  [[ -e "$(dirname "$page")/${link:2:-1}" ]] || fail "$page links to ${link:2:-1}, which is not installed"
done < <(grep -roE '\]\([^]#: ;)]+[#)]' --include='*.md' "$own/mo ved/share/doc/diffsac")
for program in "$own/mo ved/bin/"*; do
  "$program" --help >../help
  for file in $(grep -oE '(docs|data_tools)/[A-Za-z_/]+\.md' ../help); do expect_file "$own/mo ved/share/doc/diffsac/$file"; done
  for file in $(grep -oE 'configs/[a-z_/]+\.yaml' ../help); do expect_file "$own/mo ved/share/diffsac/$file"; done
  if command -v help2man >/dev/null; then expect_file "$own/mo ved/share/man/man1/$(basename "$program").1.gz"; fi
done
pose() { "$own/$1/pose" 300 100 75 <../matches.txt; }
# What was compiled before the move needs no file of the prefix, and no variable.
unset DIFFSAC_MODELS
pose build >../pose.txt || fail "the README's program failed"
run_expecting 0 cmake -S "$source/tests/integration/consumer" -B "$own/build" -DCMAKE_PREFIX_PATH="$own/mo ved"
run_expecting 0 cmake --build "$own/build" --target pose
same_pose() { run_expecting 0 pose "$1"; diff "$own/out" ../pose.txt || fail "another estimate by $1"; }
same_pose build
if command -v pkg-config >/dev/null; then
  flags() { PKG_CONFIG_PATH=$(find "$own/mo ved" -name pkgconfig) pkg-config "$1" diffsac; }
  link() { eval "'$compiler' pose.o -o pose $(flags --libs)"; }
  mkdir ../pkg-config && cd ../pkg-config
  eval "'$compiler' -O2 -c '$source/tests/integration/consumer/pose.cpp' $(flags --cflags)"
  link
  same_pose pkg-config
  # The shared library has its networks in itself.
  for component in shared namelink; do run_expecting 0 cmake --install "$build" --component $component --prefix "$own/mo ved"; done
  link
  version=$(sed -n 's/.*kVersion\[\] = "\([0-9]*[.][0-9]*\).*/\1/p' "$source/lib/diffsac/core/version.h")
  objdump -p pose > "$own/needs"
  grep -q "NEEDED *libdiffsac.so.$version$" "$own/needs" || fail "no shared library of $version"
  LD_LIBRARY_PATH=$(dirname "$(find "$own/mo ved" -name libdiffsac.so)") same_pose pkg-config
  cd "$own/empty"
fi
# The function of the library gives the digits of diffsac_pair.
python3 -c 'import json, sys
model = [float(x) for x in " ".join(open(sys.argv[2]).read().splitlines()[4:7]).split()]
theirs = json.load(open(sys.argv[1]))["model"]
assert all(abs(a - b) < 1e-10 for a, b in zip(model, theirs)), (model, theirs)' ../pair.json ../pose.txt ||
  fail "the library and diffsac_pair estimate differently"
# Networks of somebody else's.
mkdir "$own/theirs"
cp -r "$source/models/homography" "$own/theirs"
run_expecting 0 pair --task homography --models "$own/theirs"
rm -r "$own/theirs/homography"
expect_error "theirs/homography/model.safetensors" pair --task homography --models "$own/theirs"
