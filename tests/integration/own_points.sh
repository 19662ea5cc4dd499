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
expect_error "empty.csv: no points" evaluate --config "$own/points.yaml" --set "data.paths=[$own/points/empty.csv]" --output "$own/none"
mkdir "$own/same"
cp "$own/points/good.csv" "$own/same/problems.csv"
expect_error 'would be written over an input' evaluate --config "$own/points.yaml" --set "data.paths=[$own/same/problems.csv]" --output "$own/same"
# Of a folder it is named and left out.
run_expecting 0 evaluate --config "$own/points.yaml" --threads 1 --device cpu --output "$own/run"
for method in ransac diffsac; do
  for expected in good:ok nan:ok single:too_few_points equal:degenerate; do
    grep "${expected%:*}" "$own/run/problems.csv" | grep ",$method," | grep -q ",${expected#*:}," ||
      { cat "$own/run/problems.csv" >&2; fail "$method on ${expected%:*} is not ${expected#*:}"; }
  done
done
(($(grep -c 'left out: .*empty.csv: no points' "$own/err") == 1)) || { cat "$own/err"; fail "the file that is left out is not told once"; }
rm "$own/points/empty.csv"
grep -q 'nan.csv: 1 of 10 points are not finite and are left out' "$own/err" || fail "the points left out are not told"

# What was found is printed at the end and goes out with the points: the line y = x / 2 + 1, of which two points are not.
grep -q 'lines found: n · x + d = 0' "$own/out" || { cat "$own/out"; fail "the models are not printed"; }
tail -n 1 "$own/out" | grep -q "^results are in $own/run; for a report: python3 .*report $own/run$" || fail "the last line does not say where results are"
run_expecting 0 report "" "$own/run"
[[ "$(head -n 1 "$own/run/labels/good.csv")" == x,y,ransac,diffsac ]] || fail "labels/good.csv has another header"
(($(tail -n +2 "$own/run/labels/good.csv" | wc -l) == 32)) || fail "labels/good.csv has other rows than the input"
[[ "$(tail -n 2 "$own/run/labels/good.csv" | tr '\n' ' ')" == "1,9,0,0 9,1,0,0 " ]] || fail "the outliers are not labelled"
grep -q '^nan,3,0,0,0$' "$own/run/labels/nan.csv" || fail "a point that is left out has no label"
grep ',good.csv,' "$own/run/problems.csv" | grep -qE ',-?0\.447213[0-9]* -?0\.894427[0-9]* -?0\.894427[0-9]*,' || fail "the line is not in problems.csv"
grep -q 'normal x' "$own/run/report.html" || fail "the line is not in the report"

# A plane of a cloud comes back as a coloured cloud, from another folder than the file's.
awk 'BEGIN { srand(1); print "ply\nformat ascii 1.0\nelement vertex 400\nproperty float x\nproperty float y\nproperty float z\nend_header"
  for (i = 0; i < 400; ++i) print 4 * rand(), 4 * rand(), (i % 4 ? 2 + 0.01 * rand() : 5 * rand()) }' >"$own/scan.ply"
cat >"$own/scan.yaml" <<END
name: scan
task: plane
data: {type: point_sets, task: plane, paths: [scan.ply], inlier_threshold: 0.02, max_points: 100, unit: m}
methods:
  - {name: ransac, type: ransac, max_iterations: 300}
END
(cd / && run_expecting 0 evaluate --config "$own/scan.yaml" --threads 1 --output "$own/scan_run")
grep -q 'd and noise in m' "$own/out" || fail "the unit is not told"
run_expecting 0 report "" "$own/scan_run"
header=$(head -c 600 "$own/scan_run/labels/scan.ply" | tr -d '\0')
grep -q 'element vertex 400' <<<"$header" || fail "the cloud has other points than the input"
grep -q 'property int label_ransac' <<<"$header" || fail "the cloud has no labels"
expect_error 'inlier_threshold' evaluate --config "$own/scan.yaml" --set data.inlier_threshold=-1 --output "$own/none"
expect_error 'the configuration has ransac|The configuration has ransac' evaluate --config "$own/scan.yaml" --methods ransca --output "$own/none"
