# diffsac_eval on a trained checkpoint writes what it promises; threads change nothing but the times.
. "$(dirname "$0")/common.sh"
run_expecting 0 evaluate --version
grep -q diffsac "$own/out" || fail "--version names no program"
run_expecting 0 evaluate --help
grep -q -- --checkpoint "$own/out" || fail "--help does not name --checkpoint"

table=(--config configs/tables/line.yaml --checkpoint "$tiny_model" --methods diffsac,ransac_20,oracle --limit 6 --device cpu)
run_expecting 0 evaluate "${table[@]}" --threads 1 --output "$own/one"
run_expecting 0 evaluate "${table[@]}" --threads 2 --output "$own/two"
expect_file "$own"/one/{config.yaml,run.json,problems.csv,estimates.h5}
# Six problems, three methods, nine conditions, a header.
lines=$(wc -l <"$own/one/problems.csv")
((lines == 6 * 3 * 9 + 1)) || fail "problems.csv has $lines lines"
same_results "$own/one" "$own/two" "threads change results"

# Shards, joined, are the whole.
for i in 1 2 3; do run_expecting 0 evaluate "${table[@]}" --threads 1 --shard "$i/3" --output "$own/shard$i"; done
if report_python >/dev/null; then
  run_expecting 0 report merge.py "$own"/shard{2,3,1} --output "$own/merged"
  same_results "$own/one" "$own/merged" "shards change results"
  for made in one merged; do
    run_expecting 0 report "" "$own/$made"
    expect_file "$own/$made"/{results.json,results.csv,table.md,table.tex,report.html,curve.png,fits.png}
  done
  head -n 1 "$own/one/results.csv" | grep -qx 'experiment,dataset,scene,condition,method,metric,value' || fail "results.csv's header"
  diff <(grep -v ',ms_' "$own/one/results.csv") <(grep -v ',ms_' "$own/merged/results.csv") || fail "shards change the table"
  diff <(cd "$own/one" && ls) <(cd "$own/merged" && ls) || fail "a merged folder has other files"
  run_expecting 2 report merge.py "$own"/shard{1,3} --output "$own/other"
  grep -q 'merge: shard 2/3 is missing' "$own/err" || fail "a missing shard is not named"
fi
expect_error '1 <= i <= n' evaluate "${table[@]}" --shard 4/3 --output "$own/other"
expect_error 'config' evaluate --limit 3

# Where data is found in a folder, and what is left out, is the program's to say.
data="$own/it's data"
mkdir -p "$data/modelnet_off" "$data/tutorial"
needs() { evaluate --config "configs/tables/$1.yaml" --data "$data" --needs "${@:2}"; }
needs_only() { [[ "$(needs "$1")" == "$2" ]] || fail "$1 needs '$(needs "$1")', not '$2'"; }
needs_only line ""
needs_only modelnet_fundamental "$data/modelnet_off"
needs_only essential_tutorial "$data/tutorial"
needs ablation | grep -qx runs/pairs/test/castle-P19 || fail "the ablation's scenes are not named"
[[ -d runs/ablation_mlp ]] || needs ablation --train-missing | grep -qx runs/pairs/train/fox || fail "its trainings' scenes are not named"
run_expecting 0 evaluate --config configs/tables/scans.yaml --data "$data" --output "$own/scans"
grep -q 'scans: skipped.*pyransac3d_ply' "$own/out" || { cat "$own/out"; fail "what is left out is not named"; }

# A run that is there already, its page, and how it differs from another.
page=(--config configs/tables/line.yaml --methods ransac_20,ransac_100 --output "$own/page" --update)
run_expecting 0 evaluate "${page[@]}" --limit 3
if report_python >/dev/null; then
  run_expecting 0 report "" "$own/page"
  run_expecting 0 report page.py "$own/page" --page "$own/docs/line.md" --command 'make line'
  expect_file "$own"/docs/{line.md,line.json,line_curve.png}
  grep -q '^Written by `make line`' "$own/docs/line.md" || fail "a page does not say what made it"
  grep -q '^- git revision: ' "$own/docs/line.md" || fail "a page names no revision"
  run_expecting 0 report docs.py --compare "$own"/docs/line.json "$own"/docs/line.json
  sed 's/"0\.9/"0.1/' "$own/docs/line.json" >"$own/docs/other.json"
  run_expecting 1 report docs.py --compare "$own"/docs/line.json "$own"/docs/other.json
  grep -q 'mAA@0.5deg.*: RANSAC 20, 0.1: 0.9' "$own/out" || { cat "$own/out"; fail "the value that differs was not named"; }
  run_expecting 0 evaluate --config configs/tables/line.yaml --methods ransac_20 --limit 3 --output "$own/other"
  run_expecting 0 report compare.py "$own/page" "$own/other" --output "$own/compared"
  expect_file "$own"/compared/{compare.md,compare.csv,report.html}
  grep -q "row 'ransac_100' is in page alone" "$own/compared/compare.md" || fail "a row of one run alone is not named"
  grep -q 'All problems have the same answers' "$own/compared/compare.md" || fail "the same problems differ"
  run_expecting 0 evaluate --config configs/tables/line.yaml --methods ransac_20 --limit 3 --seed 7 --output "$own/drawn"
  run_expecting 2 report compare.py "$own/page" "$own/drawn" --output "$own/compared"
  grep -q 'drawn with another seed' "$own/err" || { cat "$own/err"; fail "why nothing is shared is not said"; }
  run_expecting 2 report page.py "$own/nowhere" --page "$own/docs/x.md"
fi
run_expecting 0 evaluate "${page[@]}" --limit 3
grep -q 'made already' "$own/out" || fail "a run that is there is made again"
run_expecting 0 evaluate "${page[@]}" --limit 2
grep -q 'made already' "$own/out" && fail "another run passes for this one"
expect_error '--update' evaluate "${page[@]}" --shard 1/2

# Networks that rows name and that are not there are trained by the configuration of their name, where the program runs.
mkdir -p "$own/there/configs"
sed 's/^name: .*/name: tiny/' "$3/train/run/config.yaml" >"$own/there/configs/tiny.yaml"
printf '%s\n' 'name: lines' 'problems: 3' 'missing: leave_out' 'data: {type: synthetic_line, split: test}' 'methods:' \
  '  ransac: {type: ransac}' '  tiny: {type: diffsac, label: Tiny, checkpoint: runs/tiny/checkpoints/best.safetensors}' \
  '  nobody: {type: diffsac, label: Nobody, checkpoint: runs/nobody/checkpoints/best.safetensors}' >"$own/there/lines.yaml"
(
  cd "$own/there"
  run_expecting 0 evaluate --config lines.yaml --device cpu
  grep -q 'left out: Tiny (needs runs/tiny' "$own/err" || fail "a row without its network is not named"
  run_expecting 0 evaluate --config lines.yaml --device cpu --threads 1 --train-missing
  expect_file runs/tiny/checkpoints/best.safetensors runs/tiny.log
  grep -q '^Tiny ' "$own/out" || { cat "$own/err"; fail "a row whose network was trained is left out"; }
  grep -q "no training configuration is named 'nobody'" "$own/err" || fail "a network without a training is not named"

  # Killed, it takes its training with it.
  sed 's/^name: .*/name: long/; s/iterations: .*/iterations: 1000000/; s/validate_every: .*/validate_every: 1000000/' \
    configs/tiny.yaml >configs/long.yaml
  sed 's/tiny/long/g' lines.yaml >long_lines.yaml
  "$build/bin/diffsac_eval" --config long_lines.yaml --device cpu --threads 1 --train-missing >"$own/out" 2>"$own/err" &
  evaluation=$!
  for ((i = 0; i < 600; ++i)); do [[ -e runs/long/checkpoints/last.safetensors ]] && break; sleep 0.1; done
  training=$(pgrep -P "$evaluation" || true)
  [[ -n "$training" ]] || { cat "$own/err"; fail "no training started"; }
  expect_error 'runs/long: another process is writing there' train --config configs/long.yaml --output runs/long --resume
  kill -9 "$evaluation"
  for ((i = 0; i < 300; ++i)); do kill -0 "$training" 2>/dev/null || break; sleep 0.1; done
  ! kill -0 "$training" 2>/dev/null || fail "a training goes on without the evaluation that started it"
)
