# diffsac_eval on a trained checkpoint writes what it promises; threads change nothing but the times.
. "$(dirname "$0")/common.sh"
run_expecting 0 evaluate --version
grep -q diffsac "$own/out" || fail "--version names no program"
run_expecting 0 evaluate --help
grep -q -- --checkpoint "$own/out" || fail "--help does not name --checkpoint"

table=(--config configs/tables/line.yaml --checkpoint "$tiny_model" --methods diffsac,ransac_20,oracle --limit 6 --device cpu)
run_expecting 0 evaluate "${table[@]}" --threads 1 --output "$own/one"
run_expecting 0 evaluate "${table[@]}" --threads 2 --output "$own/two"
expect_file "$own"/one/{config.yaml,results.json,results.csv,problems.csv,table.md,table.tex}
ls "$own"/one/*.png >/dev/null || fail "no picture"
head -n 1 "$own/one/results.csv" | grep -qx 'experiment,dataset,scene,condition,method,metric,value' || fail "results.csv's header"
# Six problems, three methods, nine conditions, a header.
lines=$(wc -l <"$own/one/problems.csv")
((lines == 6 * 3 * 9 + 1)) || fail "problems.csv has $lines lines"
diff <(grep -v ',ms_' "$own/one/results.csv") <(grep -v ',ms_' "$own/two/results.csv") || fail "threads change results"

# Shards, joined, are the whole.
for i in 1 2 3; do run_expecting 0 evaluate "${table[@]}" --threads 1 --shard "$i/3" --output "$own/shard$i"; done
run_expecting 0 evaluate --merge "$own"/shard{2,3,1} --output "$own/merged"
expect_file "$own"/merged/{config.yaml,results.json,results.csv,problems.csv,table.md,table.tex}
diff <(grep -v ',ms_' "$own/one/results.csv") <(grep -v ',ms_' "$own/merged/results.csv") || fail "shards change results"
diff <(cd "$own/one" && ls) <(cd "$own/merged" && ls) || fail "a merged folder has other files"
expect_error 'shard 2/3 is missing' evaluate --merge "$own"/shard{1,3} --output "$own/other"
expect_error 'both shard 1/3' evaluate --merge "$own"/shard{1,1,2,3} --output "$own/other"
expect_error 'excludes' evaluate "${table[@]}" --merge "$own"/shard{1,2,3}
expect_error '1 <= i <= n' evaluate "${table[@]}" --shard 4/3 --output "$own/other"
expect_error 'config' evaluate --limit 3
