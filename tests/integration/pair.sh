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
for method in network none; do
  run_expecting 0 pair "$own/a.pgm" "$own/b.pgm" --task homography --guidance $method --threads 1 --picture "$own/$method.png" \
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
# XFeat, where LibTorch is; without it the program says so.
run_expecting 0 pair "$own/a.pgm" "$own/b.pgm" --task homography --features xfeat --threads 1 --picture ""
grep -q 'homography matrix: [0-9]* inliers' "$own/out" || { cat "$own/out" >&2; fail "no model by XFeat"; }
mkdir -p "$own/alone/bin"
cp "$build/bin/diffsac_pair" "$own/alone/bin"
ln -s "$(realpath "$build")/share" "$own/alone/share"
build="$own/alone" expect_error 'LibTorch' pair "$own/a.pgm" "$own/b.pgm" --features xfeat --picture ""
# From any folder.
mkdir "$own/empty"
(cd "$own/empty" && run_expecting 0 pair ../a.pgm ../b.pgm --task homography --threads 1 --picture "")
# The essential matrix where there is a calibration; else with the focal length, or the fundamental one.
run_expecting 0 pair "$own/a.pgm" "$own/b.pgm" --calibration "$own/K.txt" --guidance none --picture ""
grep -q 'x2 = R x1 + t' "$own/out" || { cat "$own/out" >&2; fail "no pose"; }
run_expecting 0 pair "$own/a.pgm" "$own/b.pgm" --same-camera --picture "" --json "$own/focal.json"
grep -q '^essential matrix and focal length: ' "$own/out" || { cat "$own/out" >&2; fail "no focal length"; }
# A shift of the image, as a plane or a turn in place gives it, says nothing of the focal length.
grep -q ' f = [0-9.]* px, 68 % within .*not observable' "$own/out" || { cat "$own/out" >&2; fail "the focal length of a shift"; }
python3 -c 'import json, sys; f = json.load(open(sys.argv[1]))["focal"]; assert f["observable"] == [False] * 2 and f["source"] == ["prior"] * 2, f' \
  "$own/focal.json" || fail "the JSON has no focal length"
# That one camera took both nobody says: each has its own focal length.
run_expecting 0 pair "$own/a.pgm" "$own/b.pgm" --picture ""
grep -q '^essential matrix and two focal lengths: ' "$own/out" || { cat "$own/out" >&2; fail "no two focal lengths"; }
grep -q -- '--same-camera is surer' "$own/out" || fail "does not say how to say that it is one camera"
expect_error 'without a calibration' pair "$own/a.pgm" "$own/b.pgm" --same-camera --calibration "$own/K.txt"
run_expecting 0 pair "$own/a.pgm" "$own/b.pgm" --task fundamental --guidance none --picture ""
grep -q '^fundamental matrix' "$own/out" || fail "not the fundamental matrix"
# Its own matches, and others in any order of columns, give what the images give.
run_expecting 0 pair "$own/a.pgm" "$own/b.pgm" --task homography --picture "" --matches "$own/m.txt" --json "$own/images.json"
run_expecting 0 pair --from-matches "$own/m.txt" --sizes 200x150 --task homography --json "$own/given.json"
{ echo "ratio,x2,y2,x1,y1"; awk '{printf "%s,%s,%s,%s,%s\n", $5, $3, $4, $1, $2}' "$own/m.txt"; } >"$own/m.csv"
run_expecting 0 pair --from-matches "$own/m.csv" --task homography --guidance none --json "$own/columns.json"
# NumPy's, and SuperGlue's.
/usr/bin/python3 - "$own" <<'END'
import sys, numpy as np
own = sys.argv[1]
m = np.loadtxt(own + "/m.txt")
np.save(own + "/m.npy", m)
n = len(m)
np.savez(own + "/glue.npz", keypoints0=m[:, :2], keypoints1=m[::-1, 2:4], matches=np.arange(n)[::-1], match_confidence=1 - m[:, 4])
np.savez(own + "/two.npz", a=m, b=m)
END
run_expecting 0 pair --from-matches "$own/m.npy" --sizes 200x150 --task homography --json "$own/numpy.json"
python3 -c 'import json, sys; a, b = (json.load(open(f))["model"] for f in sys.argv[1:]); assert a == b, (a, b)' \
  "$own/given.json" "$own/numpy.json" || fail "NumPy's matches give something else"
run_expecting 0 pair --from-matches "$own/glue.npz" --task homography --json "$own/glue.json"
grep -q '"method": "none"' "$own/glue.json" || fail "scores are taken for ratios"
expect_error 'expected one array, or keypoints0' pair --from-matches "$own/two.npz" --task homography
run_expecting 0 pair --from-matches "$own/m.csv" --calibration "$own/K.txt" "$own/a.pgm" "$own/b.pgm" --picture "$own/given.png"
expect_file "$own/given.png"
{ echo "x1,y1,x2,y2,score"; awk '{printf "%s,%s,%s,%s,%s\n", $1, $2, $3, $4, 1 - $5}' "$own/m.txt"; } >"$own/scores.csv"
run_expecting 0 pair --from-matches "$own/scores.csv" --task homography --json "$own/scores.json" --matches "$own/scores.txt"
run_expecting 0 pair --from-matches "$own/scores.txt" --task homography --json "$own/scores_again.json"
python3 -c 'import json, sys; a, b = (json.load(open(f)) for f in sys.argv[1:]); assert (a["model"], a["method"]) == (b["model"], b["method"]), (a, b)' \
  "$own/scores.json" "$own/scores_again.json" || fail "scores that are written are not read as scores"
python3 - "$own"/{images,given,columns,scores}.json <<'END' || fail "given matches are estimated as others"
import json, sys
images, given, columns, scores = (json.load(open(path)) for path in sys.argv[1:])
assert given["model"] == images["model"] and given["inliers"] == images["inliers"], given["model"]
assert given["method"] == "network" and scores["method"] == "none", scores["method"]
for other in (columns, scores):
    assert other["status"] == "ok" and abs(other["model"][2] / other["model"][8] - 12) < 1, other["model"]
END
printf 'x1,y1,x2,y2,score\n1,2,3,4,1\n2,3,4,5,7\n' >"$own/bad_score.csv"
printf '1 2 3 4\n1 2 x 4\n' >"$own/bad.txt"
printf '1 2 3\n' >"$own/few.txt"
expect_error 'bad_score\.csv: match 2: expected a score in \[0, 1\], found 7' pair --from-matches "$own/bad_score.csv" --task homography
expect_error 'bad\.txt:2: expected a number' pair --from-matches "$own/bad.txt" --task homography
expect_error 'few\.txt:1: expected 4 to 8 columns, found 3' pair --from-matches "$own/few.txt" --task homography
expect_error 'needs the two images' pair --from-matches "$own/m.txt" --picture "$own/p.png"
run_expecting 0 pair --from-matches "$own/m.txt" --task homography --picture ""
expect_error 'give --sizes, or --center' pair --from-matches "$own/m.txt" --focal 300
expect_error 'images. middles: give --sizes' pair --from-matches "$own/m.txt"
expect_error 'expected sizes such as 640x480' pair --from-matches "$own/m.txt" --sizes 640
expect_error '--from-matches excludes --max-keypoints' pair --from-matches "$own/m.txt" --max-keypoints 10
expect_error '--sizes requires --from-matches' pair "$own/a.pgm" "$own/b.pgm" --sizes 640x480
# Many pairs: a folder of files, of which a bad one is named; a database of COLMAP's without matches.
mkdir "$own/given"
cp "$own/m.txt" "$own/given/a-b.txt"
cp "$own/m.txt" "$own/given/wall.txt"
run_expecting 0 pair --from-matches "$own/m.txt" --sizes 200x150 --task homography --calibration "$own/K.txt" --json "$own/one.json"
cp "$own/few.txt" "$own/given"
run_expecting 0 pair --from-matches "$own/given" --sizes 200x150 --task homography --calibration "$own/K.txt" --output "$own/many"
grep -q 'left out: .*few\.txt:1: expected 4 to 8 columns' "$own/err" || { cat "$own/err"; fail "the bad file is not named"; }
grep -q '^given: 2 pairs: 2 are sure' "$own/out" || { cat "$own/out"; fail "no summary"; }
expect_file "$own/many"/{poses.csv,report.html,pairs.json,matches/given/matches.h5}
python3 - "$own/many/poses.csv" "$own/one.json" <<'END' || fail "a pair of a folder is not what its file gives"
import csv, json, sys
rows = {row["image1"]: row for row in csv.DictReader(open(sys.argv[1]))}
assert set(rows) == {"a", "wall"} and rows["a"]["image2"] == "b" and not rows["wall"]["image2"], rows
model = json.load(open(sys.argv[2]))["model"]
for row in rows.values():
    found = [float(row[f"m{i}{j}"]) for i in (1, 2, 3) for j in (1, 2, 3)]
    assert all(abs(a - b) < 1e-7 for a, b in zip(found, model)), (found, model)
assert abs(float(rows["a"]["qw"])) > 0.99, rows["a"]
END
expect_error 'holds results already' pair --from-matches "$own/given" --task homography --output "$own/many"
expect_error 'expected files of matches' pair --from-matches "$own/empty" --task homography --output "$own/none"
expect_error 'is for two images' pair --from-matches "$own/given" --json "$own/x.json"
# Points of a known scene.
/usr/bin/python3 - "$own" <<'END'
import sys, numpy as np
rng, K, t = np.random.default_rng(1), np.array([[300, 0, 100], [0, 300, 75], [0, 0, 1.0]]), np.array([0.1, -0.2, 5])
X = rng.uniform(-1, 1, (80, 3))
x = (X + t) @ K.T
x = x[:, :2] / x[:, 2:] + rng.normal(0, 0.3, (80, 2))
x[::5] = rng.uniform(0, 150, (16, 2))
np.savetxt(sys.argv[1] + "/scene.txt", np.hstack([x, X]))
END
run_expecting 0 pair --task absolute_pose --from-matches "$own/scene.txt" --calibration "$own/K.txt" --json "$own/scene.json"
grep -q 'the camera is at (-0\.[01]' "$own/out" || { cat "$own/out"; fail "no absolute pose"; }
python3 -c 'import json, sys; t = json.load(open(sys.argv[1]))["pose"]["t"]; assert abs(t[2] - 5) < 0.05, t' "$own/scene.json" || fail "another pose"
expect_error 'absolute pose needs' pair --task absolute_pose --from-matches "$own/scene.txt"
expect_error 'is for --from-matches' pair "$own/a.pgm" "$own/b.pgm" --task absolute_pose --calibration "$own/K.txt"
# Images that share nothing.
run_expecting 0 pair "$own/a.pgm" "$own/other.pgm" --task homography --guidance none --picture ""
grep -q 'may share nothing' "$own/out" "$own/err" || { cat "$own/out" "$own/err" >&2; fail "chance was taken for a model"; }

# Mistakes: one line each, and what is there stays.
cp "$own/network.png" "$own/kept.png"
head -c 200 "$own/a.pgm" >"$own/cut.pgm"
expect_error 'cut\.pgm' pair "$own/a.pgm" "$own/cut.pgm" --picture "$own/kept.png"
expect_error 'none\.jpg: no such file' pair "$own/a.pgm" "$own/none.jpg" --picture "$own/kept.png"
cmp -s "$own/network.png" "$own/kept.png" || fail "an error wrote over a picture"
# No output is an input.
cp "$own/a.pgm" "$own/first.pgm"
ln -s first.pgm "$own/link.pgm"
expect_error 'first\.pgm. would be written over an input' pair "$own/first.pgm" "$own/b.pgm" --picture "$own/first.pgm"
expect_error 'link\.pgm. would be written over an input' pair "$own/first.pgm" "$own/b.pgm" --picture "" --json "$own/link.pgm"
expect_error 'K\.txt. would be written over' pair "$own/a.pgm" "$own/b.pgm" --calibration "$own/K.txt" --matches "$own/./K.txt" \
  --picture ""
expect_error 'are one file' pair "$own/a.pgm" "$own/b.pgm" --picture "" --json "$own/x" --matches "$own/./x"
cmp -s "$own/a.pgm" "$own/first.pgm" || fail "a photograph was written over"
expect_error 'needs --calibration' pair "$own/a.pgm" "$own/b.pgm" --task essential
expect_error 'takes no --calibration' pair "$own/a.pgm" "$own/b.pgm" --task shared_focal --focal 300 --center 100,75
expect_error '--focal: expected a number above 0' pair "$own/a.pgm" "$own/b.pgm" --focal 0 --center 100,75
expect_error '--seed: expected a number from 0 on' pair "$own/a.pgm" "$own/b.pgm" --seed -1
expect_error 'a focal length of 15 pixels would see' pair "$own/a.pgm" "$own/b.pgm" --focal 15
expect_error "did you mean '--focal'" pair "$own/a.pgm" "$own/b.pgm" --focl 300
expect_error 'guidance' pair "$own/a.pgm" "$own/b.pgm" --guidance shiped
expect_error 'min_iterations' pair "$own/a.pgm" "$own/b.pgm" --task homography --min-iterations 20 --max-iterations 10
expect_error 'images' pair "$own/a.pgm"
expect_error 'task' pair "$own/a.pgm" "$own/b.pgm" --task line
expect_error 'nowhere' pair "$own/a.pgm" "$own/b.pgm" --task homography --models "$own/nowhere"
expect_error 'K2\.txt' pair "$own/a.pgm" "$own/b.pgm" --calibration "$own/K2.txt"
expect_error 'no/picture' pair "$own/a.pgm" "$own/b.pgm" --guidance none --picture "$own/no/picture.png"
