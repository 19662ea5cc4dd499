# diffsac_register --from-matches: matches of two clouds in files, without the clouds; a registration table's picture of both.
source "$(dirname "$0")/common.sh"
python=$(report_python) || { echo "skipped: there is no python3 with the modules of scripts/report"; exit 4; }
register() { "$build/bin/diffsac_register" "$@"; }
"$python" - "$own" <<'END'
import sys, h5py, numpy as np
rng = np.random.default_rng(1)
R, t = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]]), np.array([3, -2, 1.0])
first = rng.uniform(-5, 5, (400, 3))
second = first @ R.T + t + rng.normal(0, 0.01, (400, 3))
second[150:] = rng.uniform(-8, 8, (250, 3))
rows = np.hstack([first, second])
def save(name, values, **style): np.savetxt(f"{sys.argv[1]}/{name}", values, **style)
save("m.txt", rows, fmt="%.17g")
save("m.csv", np.roll(rows, 3, axis=1), delimiter=",", fmt="%.17g", header="x2,y2,z2,x1,y1,z1", comments="")
np.save(f"{sys.argv[1]}/m.npy", rows)
np.save(f"{sys.argv[1]}/five.npy", rows[:, :5])
def group(name, *pairs):
    with h5py.File(f"{sys.argv[1]}/{name}", "w") as file:
        for pair in pairs:
            file[pair + "/points"], file[pair + "/limits"] = rows, np.array([0.05, 5, 0.6])
            file[pair + "/motion"] = np.column_stack([R, t])
group("m.h5", "pair")
group("two.h5", "pair", "another")
scaled = rows.copy()
scaled[:, 3:] *= 2.5
save("scaled.txt", scaled)
moving = rows.copy()
moving[200:300, 3:] = moving[200:300, :3] @ R
save("moving.txt", moving)
save("one.txt", rows[:1])
save("three.txt", rows[:3])
save("line.txt", np.outer(np.arange(50), np.ones(6)))
save("place.txt", np.ones((50, 6)))
save("nan.txt", np.full((9, 6), np.nan))
save("five.txt", rows[:, :5])
END
cd "$own"
mkdir -p scene && cp m.h5 scene/cloud_matches.h5

# The same matches in each format give the same digits.
for file in m.txt m.csv m.npy m.h5; do
  run_expecting 0 register --from-matches $file --json $file.json
  grep -q '^rigid motion: 15[0-9] inliers' out && grep -q 'standard deviations' out || { cat out >&2; fail "$file: the text lacks something"; }
  cmp <(sed 1,2d m.txt.json) <(sed 1,2d $file.json) || fail "$file: other digits"
done
OMP_NUM_THREADS=1 run_expecting 0 register --from-matches m.txt --json again.json
cmp m.txt.json again.json || fail "other digits with one thread"
python3 - <<'END' || { cat m.txt.json >&2; fail "another motion"; }
import json, math
found = json.load(open("m.txt.json"))
assert math.dist(found["translation"], (3, -2, 1)) < .01 and abs(found["rotation"][1][0] - 1) < 1e-3
assert not found["may_be_chance"] and len(found["covariance"]) == 6 and len(found["inlier_rows"]) == found["inliers"]
END
run_expecting 0 register --from-matches scaled.txt --task similarity
grep -q '^  s = 2.[45]' out || { cat out >&2; fail "no scale"; }
run_expecting 0 register --from-matches moving.txt --several --json several.json
grep -q '^rigid motion 2: 10[0-9] matches' out || { cat out >&2; fail "not two motions"; }

# Nothing to find.
for file in one line place nan; do
  run_expecting 1 register --from-matches $file.txt
  grep -q '^no motion: ' out || fail "no status of $file"
done
status=0
register --from-matches three.txt >out 2>err || status=$?
((status == 1)) || grep -q 'share nothing' err || fail "sure of three matches"

# Mistakes: one line each.
: >empty.txt
echo '1 2 3 four 5 6' >word.txt
echo text >broken.h5
expect_error 'empty\.txt: no matches' register --from-matches empty.txt
expect_error 'five\.txt:1: expected 6 to 8 columns, found 5' register --from-matches five.txt
expect_error "word\.txt:1: expected a number, found 'four'" register --from-matches word.txt
expect_error 'five\.npy: expected N x 6 or 7 numbers' register --from-matches five.npy
expect_error 'broken\.h5: no HDF5 file' register --from-matches broken.h5
expect_error 'two\.h5: expected one group with points, found 2' register --from-matches two.h5
for kind in txt npy h5; do expect_error "none\.$kind" register --from-matches none.$kind; done
expect_error 'm\.txt' register --from-matches m.txt --json m.txt
expect_error 'is for clouds' register --from-matches m.txt --voxel 1
expect_error 'several is for --task rigid' register --from-matches m.txt --several --task similarity
[[ -x "$build/bin/diffsac_eval" ]] || exit 0

# A table of them: a picture of both clouds.
cd "$source"
run_expecting 0 evaluate --config configs/tables/registration_outdoors.yaml --set "data.paths=[$own]" --methods recommended \
  --seed 1 --set 'seeds=[]' --output "$own/run"
run_expecting 0 report "" "$own/run"
expect_file "$own/run"/{fits.png,report.html,estimates.h5}
