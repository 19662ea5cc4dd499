# Factors, their effects and strata, on generated lines: whole, in shards, and on one page.
. "$(dirname "$0")/common.sh"
cat >"$own/scoreboard_line.yaml" <<'YAML'
name: scoreboard_line
problems: 40
data: {type: synthetic_line, split: test, num_points: 60, outlier_ratio: [0.2, 0.9]}
methods:
  msac: {type: ransac, consensus: {score: msac}, sweep: {max_iterations: [20, 200]}}
  count: {type: ransac, consensus: {score: inlier_count, score_threshold_factor: 1}, sweep: {max_iterations: [20, 200]}}
  oracle: {type: oracle}
report:
  title: lines by score and draws
  compare: {msac_200: count_20}
  strata: [{by: inlier_share, bins: [0.3, 0.5]}, {by: points, bins: [100], rows: [msac_200]}]
  factors: {score: [msac, count], draws: ["20", "200"]}
YAML
table=(--config "$own/scoreboard_line.yaml" --threads 1)
run_expecting 0 evaluate "${table[@]}" --output "$own/runs/scoreboard_line"
run="$own/runs/scoreboard_line"
report_python >/dev/null || { echo "skipped: there is no python3 with the modules of scripts/report"; exit 4; }
run_expecting 0 report "" "$run"
expect_file "$run"/{effects,strata_inlier_share,strata_points}.png "$run"/{table.md,report.html}
rows=$(cut -d, -f5 "$run/problems.csv" | sort -u | paste -sd,)
[[ "$rows" == "count_20,count_200,method,msac_20,msac_200,oracle" ]] || fail "the rows are $rows"

# Each stratum's problems are those of problems.csv, and together they are all.
python3 - "$run" <<'PYTHON' || fail "strata and problems differ"
import csv, sys
problems = [p for p in csv.DictReader(open(sys.argv[1] + "/problems.csv")) if p["method"] == "msac_20"]
shares = [float(p["inlier_share"]) for p in problems]
counts = {r["scene"]: int(r["value"]) for r in csv.DictReader(open(sys.argv[1] + "/results.csv"))
          if r["metric"] == "problems" and r["method"] == "msac_20" and r["scene"].startswith("inlier_share")}
expected = {"inlier_share below 0.3": sum(s < 0.3 for s in shares),
            "inlier_share 0.3-0.5": sum(0.3 <= s < 0.5 for s in shares),
            "inlier_share from 0.5": sum(s >= 0.5 for s in shares)}
assert counts == expected and sum(counts.values()) == 40, (counts, expected)
PYTHON
grep -q "^draws: 200," "$run/table.csv" || fail "table.csv has no effects"
grep -q 'by share of true inliers (problems)' "$run/report.html" || fail "report.html has no strata"

# Shards joined, and the resolved configuration run again, are the same.
for i in 1 2; do run_expecting 0 evaluate "${table[@]}" --shard "$i/2" --output "$own/shard$i"; done
run_expecting 0 report merge.py "$own"/shard{1,2} --output "$own/merged"
run_expecting 0 evaluate --config "$run/config.yaml" --output "$own/again"
for other in merged again; do
  run_expecting 0 report "" "$own/$other"
  diff <(grep -vE ',ms(_|,)' "$run/results.csv") <(grep -vE ',ms(_|,)' "$own/$other/results.csv") || fail "$other differs"
done

# One page of several tables; those that are not there are named.
run_expecting 0 report effects.py "$run" "$own/runs/scoreboard_plane" --page "$own/docs/what_decides.md"
grep -q '^Not made: scoreboard_plane' "$own/docs/what_decides.md" || fail "a table that is not made is not named"
grep -q '^| draws: 200 ' "$own/docs/what_decides.md" || fail "the page has no effects"
expect_file "$own/docs/what_decides_scoreboard_line_effects.png"
run_expecting 2 report effects.py "$own/nowhere"
grep -q 'none of these folders' "$own/err" || fail "a folder without a run is no error"
