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
