# The scripts answer mistakes with one clear line and find LibTorch again without asking a server.
. "$(dirname "$0")/common.sh"
run_expecting 1 scripts/setup.sh --prefix "$own"
grep -q "no LibTorch" "$own/err" || fail "a folder without LibTorch is taken"
run_expecting 1 scripts/setup.sh --wrong
run_expecting 1 scripts/reproduce.sh no_such_table
grep -q "no table 'no_such_table'" "$own/err" || fail "an unknown table is not named"
grep -q "tables:.*line" "$own/err" || fail "the valid tables are not listed"
