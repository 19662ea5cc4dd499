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
# Where each table's data is found in a folder, and that tables without theirs are left out.
(
  data="$own/it's data"
  mkdir -p "$data/modelnet_off" "$data/tutorial"
  . scripts/data_sets.sh
  located_as() {
    located=()
    locate "$1" || fail "$1 is left out"
    [[ "${located[*]}" == "$2" ]] || fail "$1 is located by '${located[*]}', not '$2'"
  }
  located_as line ""
  located_as modelnet_fundamental "--set data.paths=['$own/it''s data/modelnet_off']"
  located_as essential_tutorial "--set data.root='$own/it''s data/tutorial'"
  mkdir "$data/ModelNet40"
  located_as modelnet_fundamental "--set data.paths=['$own/it''s data/ModelNet40'] --set data.subset=test"
  for table in scans learned_essential learned_homography kitti_homography ablation; do
    if locate "$table"; then fail "$table is not left out"; fi
  done
  scenes=(runs/pairs/test/castle-P19 runs/pairs/test/kitti_01_step_01)
  located_as ablation "--set data.paths=[runs/pairs/test/castle-P19,runs/pairs/test/kitti_01_step_01]"
  located_as kitti_homography "--set data.paths=[runs/pairs/test/kitti_01_step_01]"
) || exit 1
