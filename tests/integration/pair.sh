# diffsac_pair: two images in, model, pose, inliers, times and a picture out; mistakes.
. "$(dirname "$0")/common.sh"
pair() { "$build/bin/diffsac_pair" "$@"; }

# image SHIFT SEED: grey blobs, moved to the right.
image() { gray_blobs 200 150 140 "$2" "$1"; }
image 0 3 >"$own/a.pgm"
image 12 3 >"$own/b.pgm"
image 0 9 >"$own/other.pgm"
printf '300 0 100\n0 300 75\n0 0 1\n' >"$own/K.txt"

# A homography of a shift, with the shipped network and without one.
for method in learned_prosac prosac_marginalised; do
  run_expecting 0 pair "$own/a.pgm" "$own/b.pgm" --task homography --method $method --threads 1 --picture "$own/$method.png" \
    --json "$own/$method.json"
  grep -q 'homography matrix: [0-9]* inliers' "$own/out" || { cat "$own/out" >&2; fail "no model"; }
  grep -q 'milliseconds: keypoints' "$own/out" || fail "no times"
  expect_file "$own/$method.png" "$own/$method.json"
  python3 - "$own/$method.json" <<'END' || fail "the JSON does not say the shift"
import json, sys
pair = json.load(open(sys.argv[1]))
h = [x / pair["model"][8] for x in pair["model"]]
assert pair["status"] == "ok" and not pair["may_be_chance"], pair
assert abs(h[2] - 12) < 1 and abs(h[5]) < 1, h
END
done
# From any folder: configuration and network are found beside the program.
mkdir "$own/empty"
(cd "$own/empty" && run_expecting 0 pair ../a.pgm ../b.pgm --task homography --threads 1 --picture "")
# The essential matrix where there is a calibration; else with the focal length, or the fundamental one.
run_expecting 0 pair "$own/a.pgm" "$own/b.pgm" --calibration "$own/K.txt" --method prosac_marginalised --picture ""
grep -q 'x2 = R x1 + t' "$own/out" || { cat "$own/out" >&2; fail "no pose"; }
run_expecting 0 pair "$own/a.pgm" "$own/b.pgm" --picture "" --json "$own/focal.json"
grep -q '^essential matrix and focal length: ' "$own/out" || { cat "$own/out" >&2; fail "no focal length"; }
# A shift of the image, as a plane or a turn in place gives it, says nothing of the focal length.
grep -q ' f = [0-9.]* px, 68 % within .*not observable' "$own/out" || { cat "$own/out" >&2; fail "the focal length of a shift"; }
grep -q '"observable": false' "$own/focal.json" || fail "the JSON has no focal length"
run_expecting 0 pair "$own/a.pgm" "$own/b.pgm" --task fundamental --method prosac_marginalised --picture ""
grep -q '^fundamental matrix' "$own/out" || fail "not the fundamental matrix"
# Images that share nothing.
run_expecting 0 pair "$own/a.pgm" "$own/other.pgm" --task homography --method prosac_marginalised --picture ""
grep -q 'may share nothing' "$own/out" "$own/err" || { cat "$own/out" "$own/err" >&2; fail "chance was taken for a model"; }

# Mistakes: one line each, and what is there stays.
cp "$own/learned_prosac.png" "$own/kept.png"
head -c 200 "$own/a.pgm" >"$own/cut.pgm"
expect_error 'cut\.pgm' pair "$own/a.pgm" "$own/cut.pgm" --picture "$own/kept.png"
expect_error 'none\.jpg: no such file' pair "$own/a.pgm" "$own/none.jpg" --picture "$own/kept.png"
cmp -s "$own/learned_prosac.png" "$own/kept.png" || fail "an error wrote over a picture"
# No output is an input, and no other file than an earlier picture is replaced.
cp "$own/a.pgm" "$own/first.pgm"
ln -s first.pgm "$own/link.pgm"
echo '# no matches' >"$own/mine.png"
expect_error 'first\.pgm. would be written over an input' pair "$own/first.pgm" "$own/b.pgm" --picture "$own/first.pgm"
expect_error 'link\.pgm. would be written over an input' pair "$own/first.pgm" "$own/b.pgm" --picture "" --json "$own/link.pgm"
expect_error 'K\.txt. would be written over' pair "$own/a.pgm" "$own/b.pgm" --calibration "$own/K.txt" --matches "$own/./K.txt" \
  --picture ""
expect_error 'are one file' pair "$own/a.pgm" "$own/b.pgm" --picture "" --json "$own/x" --matches "$own/./x"
expect_error 'mine\.png. is there already' pair "$own/a.pgm" "$own/b.pgm" --picture "$own/mine.png"
cmp -s "$own/a.pgm" "$own/first.pgm" || fail "a photograph was written over"
expect_error 'needs --calibration' pair "$own/a.pgm" "$own/b.pgm" --task essential
expect_error 'takes no --calibration' pair "$own/a.pgm" "$own/b.pgm" --task shared_focal --focal 300 --center 100,75
expect_error 'positive --focal' pair "$own/a.pgm" "$own/b.pgm" --focal 0 --center 100,75
expect_error 'no such row; there are prosac_marginalised' pair "$own/a.pgm" "$own/b.pgm" --method shiped
expect_error 'images' pair "$own/a.pgm"
expect_error 'task' pair "$own/a.pgm" "$own/b.pgm" --task line
expect_error 'nowhere' pair "$own/a.pgm" "$own/b.pgm" --config "$own/nowhere.yaml"
expect_error 'K2\.txt' pair "$own/a.pgm" "$own/b.pgm" --calibration "$own/K2.txt"
expect_error 'no/picture' pair "$own/a.pgm" "$own/b.pgm" --method prosac_marginalised --picture "$own/no/picture.png"
