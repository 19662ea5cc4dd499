# The scripts answer mistakes with one clear line and find LibTorch again without asking a server.
. "$(dirname "$0")/common.sh"
run_expecting 1 scripts/setup.sh --prefix "$own"
grep -q "no LibTorch" "$own/err" || fail "a folder without LibTorch is taken"
run_expecting 1 scripts/setup.sh --wrong
run_expecting 1 scripts/reproduce.sh no_such_table
grep -q "no table 'no_such_table'" "$own/err" || fail "an unknown table is not named"
grep -q "tables:.*line" "$own/err" || fail "the valid tables are not listed"
# From images: what is wrong is said before anything is built.
for name in kitti pairs data; do
  run_expecting 1 scripts/reproduce.sh "$name"
  grep -q "reproduce: $name needs --data DIR" "$own/err" || fail "a missing --data is not named"
done
run_expecting 1 scripts/reproduce.sh kitti --data "$own/nowhere"
grep -q "there is no folder $own/nowhere" "$own/err" || fail "a missing folder is not named"
run_expecting 1 scripts/reproduce.sh pairs --data
grep -q -- "--data needs a folder" "$own/err" || fail "--data without a folder is taken"
run_expecting 1 scripts/reproduce.sh pairs --data "$own" --output "$own/x"
grep -q -- "--output" "$own/err" || fail "--output is taken with several tables"
run_expecting 1 scripts/reproduce.sh line --quick --page
grep -q -- "--page is of whole tables" "$own/err" || fail "--page is taken with a part of a table"
run_expecting 1 scripts/reproduce.sh line --no-such-option
grep -q "no option '--no-such-option'" "$own/err" || fail "an unknown option is not named before the build"
