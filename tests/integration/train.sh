# diffsac_train writes what it promises; its checkpoint is the other tests' model.
. "$(dirname "$0")/common.sh"
run_expecting 0 train --version
grep -q diffsac "$own/out" || fail "--version names no program"
run_expecting 0 train --help
grep -q -- --resume "$own/out" || fail "--help does not name --resume"
run_expecting 0 train "${tiny[@]}" --set train.iterations=30 --set train.validate_every=15 \
  --set train.checkpoint_every=10 --output "$own/run"
expect_file "$own"/run/{config.yaml,metrics.csv,log.txt} "$own"/run/checkpoints/{last,best}.safetensors
