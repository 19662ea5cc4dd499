# The Debian package and the archive, unpacked into empty folders: what is in them runs there, without LibTorch and without the
# build.
. "$(dirname "$0")/common.sh"
command -v dpkg-deb >/dev/null && command -v dpkg-shlibdeps >/dev/null || { echo "skipped: no dpkg-dev here"; exit 4; }
run_expecting 0 cpack --config "$build/CPackConfig.cmake" -B "$own/packages"
version=$(sed -n 's/.*kVersion\[\] = "\(.*\)".*/\1/p' lib/diffsac/core/version.h)
deb=$(echo "$own"/packages/diffsac_"${version}"_*.deb) archive=$(echo "$own"/packages/diffsac-"${version}"-*.tar.gz)
expect_file "$deb" "$archive"
run_expecting 0 dpkg-deb --info "$deb"
grep -q "Depends: .*libtbb12.*" "$own/out" || { cat "$own/out" >&2; fail "the package does not say what it needs"; }
grep -qi "torch" "$own/out" && fail "the package needs LibTorch"
dpkg-deb -x "$deb" "$own/root"
mkdir "$own/archive"
tar -xzf "$archive" -C "$own/archive" --strip-components=1
gray_blobs 200 150 140 3 0 >"$own/a.pgm"
gray_blobs 200 150 140 3 12 >"$own/b.pgm"
room 320 240 260 35 8 >"$own/room.pgm"
mkdir "$own/empty"
cd "$own/empty"
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
  expect_file "$prefix/include/diffsac/diffsac.h" "$prefix/share/diffsac/models/essential/model.safetensors"
  if grep -rlF "$source" "$prefix/lib/cmake" "$prefix/share" "$prefix/bin"; then fail "the sources' folder is named"; fi
done
