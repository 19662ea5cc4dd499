# A user's own points: a good file, an empty one, one with NaN, one with too few points, equal points.
. "$(dirname "$0")/common.sh"
mkdir "$own/points"
awk 'BEGIN { for (i = 0; i < 30; ++i) print i / 3 "," i / 6 + 1; print "1,9"; print "9,1" }' >"$own/points/good.csv"
awk 'BEGIN { for (i = 0; i < 9; ++i) print i "," i; print "nan,3" }' >"$own/points/nan.csv"
echo "1,2" >"$own/points/single.csv"
awk 'BEGIN { for (i = 0; i < 9; ++i) print "2,3" }' >"$own/points/equal.csv"
cat >"$own/points.yaml" <<END
name: points
task: line
data: {type: point_sets, task: line, paths: ["$own/points"], inlier_threshold: 0.1}
methods:
  - {name: ransac, type: ransac, max_iterations: 100}
  - {name: diffsac, type: diffsac, checkpoint: "$tiny_model"}
END
: >"$own/points/empty.csv"
expect_error "empty.csv: no points" evaluate --config "$own/points.yaml" --threads 1 --device cpu --output "$own/run"
rm "$own/points/empty.csv"
run_expecting 0 evaluate --config "$own/points.yaml" --threads 1 --device cpu --output "$own/run"
for method in ransac diffsac; do
  for expected in good:ok nan:ok single:too_few_points equal:degenerate; do
    grep "${expected%:*}" "$own/run/problems.csv" | grep ",$method," | grep -q ",${expected#*:}," ||
      { cat "$own/run/problems.csv" >&2; fail "$method on ${expected%:*} is not ${expected#*:}"; }
  done
done
grep -q 'nan.csv: 1 of 10 points are not finite and are left out' "$own/err" || fail "the points left out are not told"
