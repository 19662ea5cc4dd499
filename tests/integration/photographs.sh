# diffsac_pair on a folder of photographs: every pair, poses, page, estimates, COLMAP's database; interruption; mistakes.
. "$(dirname "$0")/common.sh"
pair() { "$build/bin/diffsac_pair" "$@"; }
photos="$own/photos"
mkdir "$photos"
for i in 0 1 2; do gray_blobs 200 150 140 3 $((10 * i)) >"$photos/v-$i.pgm"; done

# From another folder, with the default output.
(cd "$own" && run_expecting 0 pair photos --task homography --threads 1)
out="$own/pairs"
expect_file "$out"/{poses.csv,report.html,pairs.json,database.db} "$out/matches/photos/matches.h5"
grep -q 'photos: 3 pairs: 3 are sure' "$own/out" || { cat "$own/out" >&2; fail "no summary"; }
grep -q '3 images belong together: v-0.pgm, v-1.pgm, v-2.pgm' "$own/out" || fail "does not say which images belong together"
tail -1 "$own/out" | grep -q "colmap mapper --database_path pairs/database.db --image_path $photos" || fail "no last line"
[[ ! -e "$out/.keypoints" ]] || fail "keypoints are left behind"
grep -q 'Cameras and verdicts' "$out/report.html" || fail "no verdicts in the report"
# A shell takes the mapper's line as it is printed.
mkdir "$own/of ours"
cp "$photos"/v-[01].pgm "$own/of ours"
run_expecting 0 pair "$own/of ours" --output "$own/my pairs" --task homography
(line=$(tail -1 "$own/out"); eval "set -- ${line#*&& }"; [[ $4 == "$own/my pairs/database.db" && $6 == "$own/of ours" ]]) ||
  { cat "$own/out" >&2; fail "the mapper's line is not for a shell"; }
# Every pair is what the two images alone give.
run_expecting 0 pair "$photos/v-0.pgm" "$photos/v-2.pgm" --task homography --threads 1 --picture "" --json "$own/two.json"
python3 - "$out/poses.csv" "$own/two.json" <<'END' || fail "a pair of the folder is not what two images give"
import csv, json, sys
row = {(r["image1"], r["image2"]): r for r in csv.DictReader(open(sys.argv[1]))}[("v-0.pgm", "v-2.pgm")]
pair = json.load(open(sys.argv[2]))
assert row["status"] == "ok" and row["may_be_chance"] == "0", row
assert int(row["inliers"]) == len(pair["inliers"]) and int(row["matches"]) == pair["matches"], row
assert row["method"] == pair["method"] and pair["seed"] == 0 and pair["image2"].endswith("v-2.pgm"), pair
for a, b in zip(pair["model"], (row[f"m{i}{j}"] for i in "123" for j in "123")):
    assert abs(a - float(b)) <= 1e-8 * max(1, abs(a)), (a, b)
END
# Results stay unless that is said; a list, a K for each image, another folder.
expect_error 'holds results already .*--overwrite' pair "$photos" --output "$out" --task homography
printf 'v-0.pgm v-1.pgm\nv-2.pgm v-1.pgm\n' >"$photos/pairs.txt"
run_expecting 0 pair --list "$photos/pairs.txt" --output "$out" --overwrite --task homography --threads 1
(($(wc -l <"$out/poses.csv") == 3)) || fail "not the pairs of the list"
printf '300 0 100\n0 300 75\n0 0 1\n' >"$own/K.txt"
K="$own/K.txt"
run_expecting 0 pair "$photos/*.pgm" --calibration "$K,$K,$K" --output "$own/each" --guidance none --threads 1
python3 - "$own/each/poses.csv" <<'END' || fail "no poses"
import csv, sys
for row in csv.DictReader(open(sys.argv[1])):
    assert abs(sum(float(row[q]) ** 2 for q in ("qw", "qx", "qy", "qz")) - 1) < 1e-6, row
    assert abs(sum(float(row[t]) ** 2 for t in ("tx", "ty", "tz")) - 1) < 1e-6 and row["focal1_px"] == "300", row
END

# Without a calibration all pairs of a camera say its focal length together, and the file says where it comes from.
run_expecting 0 pair "$photos" --output "$own/unknown" --threads 1
python3 - "$own/unknown/poses.csv" <<'END' || fail "no focal lengths"
import csv, sys
for row in csv.DictReader(open(sys.argv[1])):
    for image in "12":
        assert float(row[f"focal{image}_px"]) > 0 and row[f"focal{image}_source"] in ("matches", "pairs", "prior"), row
END

# One K for an image that was turned: a warning.
gray_blobs 150 200 140 3 0 >"$own/turned.pgm"
run_expecting 0 pair "$photos/v-0.pgm" "$photos/v-1.pgm" --calibration "$K" --guidance none --picture ""
! grep -q 'one calibration' "$own/err" || fail "a warning of images of one size"
run_expecting 0 pair "$photos/v-0.pgm" "$own/turned.pgm" --calibration "$K" --guidance none --picture ""
grep -q 'one calibration for images of 200x150 and 150x200' "$own/err" || { cat "$own/err" >&2; fail "no warning of sizes"; }

# An image that is none is left out by its name.
echo text >"$photos/broken.jpg"
run_expecting 0 pair "$photos" --output "$own/broken" --task homography --threads 1
grep -q 'left out: .*broken\.jpg: not an image' "$own/err" || { cat "$own/err" >&2; fail "the broken image is not named"; }
rm "$photos/broken.jpg"

# Interrupted: what was done is kept, and keypoints are there for the next run.
mkdir "$own/many"
for i in $(seq 100 159); do cp "$photos/v-$((i % 3)).pgm" "$own/many/v-$i.pgm"; done
"$build/bin/diffsac_pair" "$own/many" --output "$own/slow" --task homography --threads 1 >"$own/out" 2>"$own/err" &
process=$!
for _ in $(seq 600); do
  (($(find "$own/slow/.keypoints" -name '*.bin' 2>/dev/null | wc -l) == 60)) && break
  sleep 0.1
done
sleep 1
kill -INT "$process"
status=0
wait "$process" || status=$?
((status == 130)) || { cat "$own/err" >&2; fail "exit status $status instead of 130"; }
grep -q 'interrupted: .*the same command goes on' "$own/err" || { cat "$own/err" >&2; fail "nothing is said of it"; }
expect_file "$own/slow/.keypoints/v_100.bin"
printf 'v-100.pgm v-101.pgm\nv-102.pgm v-101.pgm\n' >"$own/many/few.txt"
run_expecting 0 pair "$own/many" --list "$own/many/few.txt" --output "$own/slow" --task homography --threads 1
grep -q 'keypoints: [0-2] of 3 images are left' "$own/err" || { cat "$own/err" >&2; fail "does not say what is left"; }
(($(wc -l <"$own/slow/poses.csv") == 3)) || fail "not the two pairs"
[[ ! -e "$own/slow/.keypoints" ]] || fail "keypoints are left behind"

# Mistakes.
expect_error 'none: no such file or folder' pair "$own/none" --output "$own/x"
expect_error 'expected two images' pair "$photos/v-0.pgm"
expect_error 'json is for two images' pair "$photos" --json "$own/x.json"
expect_error 'output is for folders' pair "$photos/v-0.pgm" "$photos/v-1.pgm" --output "$own/x"
expect_error 'one for each of the 3 images, found 2' pair "$photos" --calibration "$K,$K" --output "$own/x"
echo a.jpg b.jpg >"$own/list.txt"
expect_error 'list\.txt:1: there is no image a\.jpg' \
  pair "$photos" --list "$own/list.txt" --output "$own/x"
expect_error 'cameras\.txt' pair "$photos" --cameras "$own/cameras.txt" --output "$own/x"
[[ ! -e "$own/x" ]] || fail "a mistake left a folder"
# The second image is looked for before the first one's keypoints.
expect_error 'gone\.jpg: no such file' pair "$photos/v-0.pgm" "$own/gone.jpg"
