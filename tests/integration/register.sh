# diffsac_register: clouds in, motions and a pose graph out; mistakes.
source "$(dirname "$0")/common.sh"
register() { "$build/bin/diffsac_register" "$@" --voxel 0.08; }

# Three scans of boxes around the scanner, each in a frame of its own, and one of other boxes.
python3 - "$own" <<'END'
import json, os, random, math, sys
own = sys.argv[1]
def turn(axis, degrees):
    n = math.sqrt(sum(a * a for a in axis)); x, y, z = (a / n for a in axis); c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees)); d = 1 - c
    return [[c + x * x * d, x * y * d - z * s, x * z * d + y * s], [y * x * d + z * s, c + y * y * d, y * z * d - x * s], [z * x * d - y * s, z * y * d + x * s, c + z * z * d]]
def apply(R, t, p): return [sum(R[i][k] * p[k] for k in range(3)) + t[i] for i in range(3)]
def room(seed, draws, scanner, low, high):
    boxes, places = random.Random(seed), random.Random(draws)
    for _ in range(20):
        centre = [boxes.gauss(0, 1) for _ in range(3)]
        far = boxes.uniform(2, 3) / math.hypot(*centre)
        centre = [c * far for c in centre]
        half = [boxes.uniform(.2, .6) for _ in range(3)]
        R = turn((.2, .1, 1), boxes.uniform(0, 90))
        for _ in range(2000):
            p = [places.uniform(-1, 1) for _ in range(3)]
            k = places.randrange(3)
            p[k] = math.copysign(1, p[k])
            q = apply(R, centre, [a * b for a, b in zip(p, half)])
            seen = sum(p[k] * R[i][k] * (scanner[i] - q[i]) for i in range(3)) > 0
            if seen and low < q[0] < high: yield [a - b for a, b in zip(q, scanner)]
def write(name, points, header=True):
    with open(f"{own}/{name}", "w") as file:
        points = list(points)
        if header: file.write(f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty double x\nproperty double y\nproperty double z\nend_header\n")
        for p in points: file.write(" ".join(map(repr, p)) + "\n")
R1, R2, zero = turn((1, 2, 3), 40), turn((0, -1, 1), 100), [0, 0, 0]
s0, s1, s2 = [.3, .1, 0], [-.3, 0, .1], [0, .3, 0]
os.mkdir(f"{own}/scans")
write("scans/a.ply", room(1, 1, s0, -9, 1.5))
write("scans/b.ply", (apply(R1, zero, p) for p in room(1, 2, s1, -1.5, 9)))
write("scans/c.ply", (apply(R2, zero, p) for p in room(1, 3, s2, -2.5, 2)))
write("scans/other.ply", room(9, 1, s0, -9, 9))
json.dump({"R": R1, "t": apply(R1, zero, [p - q for p, q in zip(s0, s1)])}, open(f"{own}/truth.json", "w"))
uniform = random.Random(3)
write("two.ply", [[0., 0., 0.], [1., 0., 0.]])
write("line.ply", [[float(i), 0., 0.] for i in range(200)])
write("plane.ply", [[uniform.uniform(-1, 1), uniform.uniform(-1, 1), 0.] for _ in range(2000)])
def sphere():
    for _ in range(2000):
        p = [uniform.gauss(0, 1) for _ in range(3)]
        yield [a / math.hypot(*p) for a in p]
write("sphere1.ply", sphere()); write("sphere2.ply", sphere())
write("none.ply", [])
END
a=$own/scans/a.ply b=$own/scans/b.ply

cd "$own"
run_expecting 0 register "$a" "$b" --json ab.json --output ab.ply
grep -q '^rigid motion: ' out && grep -q 'standard deviations' out && grep -q '^overlap: ' out || { cat out >&2; fail "the text lacks something"; }
! grep -q 'warning' err || fail "may be chance"
expect_file ab.ply
python3 - <<'END' || { cat ab.json >&2; fail "another motion"; }
import json, math
found, truth = json.load(open("ab.json")), json.load(open("truth.json"))
trace = sum(found["rotation"][i][k] * truth["R"][i][k] for i in range(3) for k in range(3))
assert math.degrees(math.acos(min(1, (trace - 1) / 2))) < 1, trace
assert math.dist(found["translation"], truth["t"]) < .05
assert found["status"] == "ok" and not found["may_be_chance"] and .3 < found["overlap"][0] < .95
assert len(found["covariance"]) == 6
END
# The moved cloud lies where the second one is; it is a cloud itself.
run_expecting 0 register ab.ply "$b" --json moved.json --output ""
python3 -c 'import json; m = json.load(open("moved.json")); assert max(map(abs, m["translation"])) < .05, m["translation"]' || fail "not moved"
# The same digits again, with one thread.
OMP_NUM_THREADS=1 run_expecting 0 register "$a" "$b" --json again.json --output ""
cmp ab.json again.json || fail "other digits"

# A folder: a table of all pairs, a graph of those that are right.
run_expecting 0 register scans --output graph
(($(wc -l <graph/registrations.csv) == 7)) || fail "not all pairs"
(($(grep -c '^VERTEX_SE3:QUAT' graph/pose_graph.g2o) == 4)) || fail "not all scans"
(($(grep -c '^EDGE_SE3:QUAT' graph/pose_graph.g2o) == 3)) || { cat out graph/registrations.csv >&2; fail "not the three edges"; }
(($(grep -c '^FIX' graph/pose_graph.g2o) == 2)) || fail "not two groups"
expect_error 'pose_graph.g2o: is there already' register scans --output graph
run_expecting 0 register scans --output graph --overwrite

# Nothing to find, or nothing that can be relied upon.
for cloud in two line; do
  run_expecting 1 register $cloud.ply "$b" --output none.out.ply
  grep -q '^no motion: ' out || fail "no status of $cloud"
  [[ ! -e none.out.ply ]] || fail "a cloud of no motion"
done
# What turns into itself: a second motion, chance, or none.
for pair in "plane.ply plane.ply" "sphere1.ply sphere2.ply" "$own/scans/other.ply $b"; do
  status=0
  register $pair --output "" >out 2>err || status=$?
  ((status == 1)) || { ((status == 0)) && [[ $pair == plane* ]]; } || grep -q 'share nothing\|symmetric\|slide' err || { cat out err >&2; fail "sure of $pair"; }
done

# Mistakes: one line each, and what is there stays.
expect_error 'no\.ply: no such file' register no.ply "$b"
expect_error 'none\.ply: no points' register none.ply "$b"
: >empty.ply
expect_error 'empty\.ply: no points' register empty.ply "$b"
head -c 20000 "$a" >cut.ply
expect_error 'cut\.ply: no points' register cut.ply "$b"
echo text >text.txt
expect_error 'text\.txt: expected a name' register text.txt "$b"
expect_error 'a\.ply' register "$a" "$b" --output "$a"
expect_error 'xyzw: expected a name' register "$a" "$b" --output out.xyzw
expect_error 'no/ab\.ply' register "$a" "$b" --output no/ab.ply
for voxel in 0 1e-12; do
  run_expecting 2 "$build/bin/diffsac_register" "$a" "$b" --voxel $voxel
  grep -q 'above 0\|too small' err || fail "a voxel of $voxel"
done
run_expecting 0 "$build/bin/diffsac_register" "$a" "$b" --output ""
expect_error 'two clouds or more' register graph --output other
expect_error 'no such folder' register nowhere
expect_error 'scans' register
[[ ! -e aligned.ply ]] || fail "a mistake wrote a cloud"
