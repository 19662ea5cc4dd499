# diffsac_vanish: photographs in, vanishing points, focal length, horizon and pictures out; mistakes.
. "$(dirname "$0")/common.sh"
vanish() { "$build/bin/diffsac_vanish" "$@"; }

room 640 480 520 35 8 >"$own/room.pgm"
room 480 360 390 -50 -12 >"$own/other.pgm"
printf '520 0 319.5\n0 520 239.5\n0 0 1\n' >"$own/K.txt"

# Without a calibration: the focal length and the horizon are found.
run_expecting 0 vanish "$own/room.pgm" --picture "$own/room.png" --json "$own/room.json" --estimates "$own/room.h5" \
  --segments "$own/room.txt"
cp "$own/out" "$own/text"
grep -q '^room: 640 x 480 pixels, [0-9]* segments' "$own/text" || { cat "$own/text" >&2; fail "no count of segments"; }
grep -q '^3 vanishing points, the surest first' "$own/text" || { cat "$own/text" >&2; fail "not three"; }
grep -q '^focal length: 5[0-9]* px (standard deviation [0-9]* %), since 1, 2 and 3 are orthogonal' "$own/text" ||
  { cat "$own/text" >&2; fail "no focal length"; }
expect_file "$own/room.png" "$own/room.h5" "$own/room.txt"
python3 - "$own/room.json" "$own/room.txt" <<'END' || fail "the JSON does not say the room's camera"
import json, math, sys
image, = json.load(open(sys.argv[1]))["images"]
assert image["status"] == "ok" and image["size"] == [640, 480] and image["K_from"] == "vanishing_points", image
assert abs(image["focal"]["px"] / 520 - 1) < 0.03, image["focal"]
assert image["focal"]["orthogonal"] == [1, 2, 3], image["focal"]
horizon = image["horizon"]
a, b, c = horizon["line"]
row = -(a * 319.5 + c) / b
assert abs(row - (239.5 + 520 * math.tan(math.radians(8)))) < 6, row
assert abs(horizon["tilt_deg"]) < 0.7 and abs(horizon["pitch_deg"] - 8) < 1, horizon
assert len(image["assignment"]) == image["segments"] == sum(1 for _ in open(sys.argv[2]))
labels = [int(line.split()[4]) for line in open(sys.argv[2])]
assert labels == image["assignment"]
assert [point["segments"] for point in image["vanishing_points"]] == [labels.count(k) for k in (1, 2, 3)]
END
# With one, from any folder, and without the network.
mkdir "$own/empty"
(
  cd "$own/empty"
  run_expecting 0 vanish ../room.pgm --calibration ../K.txt
  grep -q '^focal length: 520 px, as given' "$own/out" || { cat "$own/out" >&2; fail "K was not used"; }
  expect_file diffsac_pictures/vanishing_points.png
  run_expecting 0 vanish ../room.pgm --focal 520 --no-network --picture ""
  grep -q 'sure' "$own/out" && fail "a network was asked"
  grep -q '^horizon: row 31[0-9]' "$own/out" || { cat "$own/out" >&2; fail "another horizon"; }
)
# The segments of a file are data as those of diffsac_prepare.
mkdir "$own/scene"
cp "$own/room.h5" "$own/scene/segments.h5"
if [[ -x "$build/bin/diffsac_eval" ]]; then
  printf '%s\n' 'name: own' 'task: vanishing_point' "data: {type: vanishing_points, paths: ['$own/scene']}" \
    'methods: {found: {type: ransac, preset: several, sampling: {sampler: weighted}}}' >"$own/own.yaml"
  run_expecting 0 evaluate --config "$own/own.yaml" --output "$own/run" --threads 1
fi
# Several images: a picture each, one file of everything. One that is no image is named, the others are done.
run_expecting 0 vanish "$own/room.pgm" "$own/other.pgm" --picture "$own/all.png" --json "$own/all.json" --estimates "$own/all.h5"
expect_file "$own/all_room.png" "$own/all_other.png" "$own/all.h5"
echo "no image" >"$own/text.jpg"
run_expecting 0 vanish "$own/text.jpg" "$own/other.pgm" --picture "$own/rest.png" --json "$own/rest.json"
grep -q 'left out: .*text\.jpg: not an image' "$own/err" || { cat "$own/err" >&2; fail "the broken image is not named"; }
expect_file "$own/rest_other.png"
python3 - "$own/all.json" "$own/rest.json" <<'END' || fail "the JSON has other images"
import json, sys
names = [[image["image"] for image in json.load(open(path))["images"]] for path in sys.argv[1:]]
assert names == [["room", "other"], ["other"]], names
END

# Nothing to find: a status, and exit status 1.
awk 'BEGIN { print "P2\n64 48 255"; for (i = 0; i < 64 * 48; ++i) print 255 }' >"$own/white.pgm"
run_expecting 1 vanish "$own/white.pgm" --picture "$own/white.png" --json "$own/white.json"
grep -q '^no vanishing points: too_few_points' "$own/out" || { cat "$own/out" >&2; fail "no status"; }
grep -q '"status": "too_few_points"' "$own/white.json" || fail "no status in the JSON"
expect_file "$own/white.png"
# Parallel lines: one vanishing point at infinity, or none; never a focal length.
awk 'BEGIN { print "P2\n320 240 255"; for (y = 0; y < 240; ++y) for (x = 0; x < 320; ++x) print int(x / 16) % 2 ? 60 : 200 }' >"$own/stripes.pgm"
status=0
vanish "$own/stripes.pgm" --picture "" >"$own/out" 2>"$own/err" || status=$?
case $status in
  0) grep -q 'at infinity along (0.00, 1.00)' "$own/out" && grep -q 'focal length: not determined' "$own/out" || { cat "$own/out" >&2; fail "not parallel"; } ;;
  1) grep -q '^no vanishing points: no_model' "$own/out" || { cat "$own/out" >&2; fail "another status"; } ;;
  *) cat "$own/err" >&2; fail "exit status $status" ;;
esac

# Mistakes: one line each, and what is there stays.
cp "$own/room.png" "$own/kept.png"
expect_error 'none\.jpg: no such file' vanish "$own/none.jpg" --picture "$own/kept.png"
cmp -s "$own/room.png" "$own/kept.png" || fail "an error wrote over a picture"
head -c 200 "$own/room.pgm" >"$own/cut.pgm"
expect_error 'cut\.pgm' vanish "$own/cut.pgm" --picture ""
expect_error 'excludes --focal' vanish "$own/room.pgm" --calibration "$own/K.txt" --focal 520
expect_error 'K2\.txt' vanish "$own/room.pgm" --calibration "$own/K2.txt"
expect_error 'positive --focal' vanish "$own/room.pgm" --center 100,100
expect_error 'focal' vanish "$own/room.pgm" --focal -3
expect_error 'least-value' vanish "$own/room.pgm" --least-value 2
expect_error 'room\.xyz: expected a name that ends in' vanish "$own/room.pgm" --picture "$own/room.xyz"
expect_error 'no/picture' vanish "$own/room.pgm" --picture "$own/no/picture.png"
expect_error 'two images are named room' vanish "$own/room.pgm" "$own/empty/../room.pgm"
expect_error 'images' vanish
