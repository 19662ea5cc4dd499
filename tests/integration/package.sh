# The Debian packages and the archive, unpacked into empty folders: what is in them runs there, and is compiled with, without
# LibTorch and without the build.
. "$(dirname "$0")/common.sh"
command -v dpkg-deb >/dev/null && command -v dpkg-shlibdeps >/dev/null || { echo "skipped: no dpkg-dev here"; exit 4; }
run_expecting 0 cpack --config "$build/CPackConfig.cmake" -B "$own/packages"
version=$(sed -n 's/.*kVersion\[\] = "\(.*\)".*/\1/p' lib/diffsac/core/version.h)
archive=$(echo "$own"/packages/diffsac-"${version}"-*.tar.gz)
expect_file "$archive"
soname=${version%.*}
for package in "libdiffsac$soname" libdiffsac-dev diffsac-tools; do
  deb=$(echo "$own/packages/${package}_${version}"_*.deb)
  expect_file "$deb"
  run_expecting 0 dpkg-deb --info "$deb"
  grep -qi "torch" "$own/out" && fail "the package needs LibTorch"
  [[ $package == libdiffsac-* ]] || grep -q "Depends: .*libtbb12.*" "$own/out" ||
    { cat "$own/out" >&2; fail "$package does not say what it needs"; }
done
for deb in "$own"/packages/*.deb; do dpkg-deb -x "$deb" "$own/root"; done
mkdir "$own/archive"
tar -xzf "$archive" -C "$own/archive" --strip-components=1
gray_blobs 200 150 140 3 0 >"$own/a.pgm"
gray_blobs 200 150 140 3 12 >"$own/b.pgm"
room 320 240 260 35 8 >"$own/room.pgm"
mkdir "$own/empty"
cd "$own/empty"
if command -v pkg-config >/dev/null; then
  # A program that links the shared library of the packages.
  # shellcheck disable=SC2046
  run_expecting 0 c++ "$source/tests/integration/consumer/fit_line.cpp" -o fit_line \
    $(PKG_CONFIG_PATH="$own/root/usr/lib/pkgconfig" pkg-config --cflags --libs diffsac)
  LD_LIBRARY_PATH="$own/root/usr/lib" run_expecting 0 ./fit_line
  grep -q "slope 0.500 intercept 1.000 inliers 7" "$own/out" || fail "another line"
  LD_LIBRARY_PATH="$own/root/usr/lib" run_expecting 0 ldd fit_line
  grep -q "root/usr/lib/libdiffsac.so.$soname" "$own/out" || { cat "$own/out" >&2; fail "no shared library"; }
fi
python=$(sed -n 's/^Python_EXECUTABLE:[^=]*=//p' "$build/CMakeCache.txt")
if [[ -d "$own/root/usr/lib/python3" && -n "$python" ]]; then
  PYTHONPATH="$own/root/usr/lib/python3/dist-packages" run_expecting 0 "$python" -c 'import diffsac, numpy
points = numpy.random.default_rng(1).uniform(0, 600, (40, 2))
print(diffsac.__version__, diffsac.estimate_homography(points, points + 5, numpy.full(40, 0.5)).num_inliers)'
  grep -q "^$version 40$" "$own/out" || { cat "$own/out" >&2; fail "another estimate in Python"; }
fi
for prefix in "$own/root/usr" "$own/archive"; do
  for program in diffsac_pair diffsac_vanish diffsac_prepare; do
    run_expecting 0 "$prefix/bin/$program" --version
    grep -q "^$program $version " "$own/out" || { cat "$own/out" >&2; fail "another version"; }
  done
  run_expecting 0 "$prefix/bin/diffsac_pair" ../a.pgm ../b.pgm --threads 1 --task homography --picture ""
  grep -q 'homography matrix: [0-9]* inliers' "$own/out" || { cat "$own/out" >&2; fail "no homography"; }
  run_expecting 0 "$prefix/bin/diffsac_vanish" ../room.pgm --picture ""
  grep -q '^focal length: [0-9]* px' "$own/out" || { cat "$own/out" >&2; fail "no focal length"; }
  [[ ! -e "$prefix/bin/diffsac_train" ]] || fail "a program of the lab is packed"
  for program in diffsac_pair diffsac_vanish; do
    if ldd "$prefix/bin/$program" | grep -E "torch|libc10|not found"; then fail "$program is linked with it"; fi
  done
  expect_file "$prefix/include/diffsac/diffsac.h"
  [[ ! -e "$prefix/share/diffsac/models" ]] || fail "networks are packed, which the library has"
  if grep -rlF "$source" "$prefix/lib/cmake" "$prefix/share" "$prefix/bin"; then fail "the sources' folder is named"; fi
done
