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
