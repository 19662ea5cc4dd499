# --help of each program has defaults, examples and the documentation, and wrong options are answered in few words.
. "$(dirname "$0")/common.sh"
helps() {
  run_expecting 0 "$@" --help
  for text in 'Examples:' 'Documentation:' 'Exit status: 0 done; 2 bad input.* 130 '; do
    grep -q "$text" "$own/out" || { cat "$own/out"; fail "no '$text' in: $* --help"; }
  done
  # What it points at is there.
  for file in $(grep -oE '(docs|configs|data_tools)/[A-Za-z_/]+\.(md|yaml)' "$own/out" | sort -u); do
    [[ -e "$source/$file" ]] || fail "$* --help names $file, which is not there"
  done
  ! grep -qE '[0-9]{30}' "$own/out" || fail "$* --help prints a number of many digits"
}
helps evaluate
grep -qE -- '--device TEXT(=cpu| \[cpu\])' "$own/out" || { cat "$own/out"; fail "a default is not named"; }
helps train
grep -qE -- '--group-timeout FLOAT(=| \[)' "$own/out" || fail "a default is not named"
helps prepare
for command in pairs segments sets tutorial modelnet warp inspect; do helps prepare "$command"; done
helps prepare warp
grep -qE -- '--max-image-size INT(=1024| \[1024\])' "$own/out" || { cat "$own/out"; fail "a default is not named"; }

# refused PATTERN PROGRAM ARGUMENTS...: as expect_error, in one short line.
refused() {
  expect_error "$@"
  (($(wc -c <"$own/err") < 300)) || { cat "$own/err"; fail "a long answer: $*"; }
}
refused '--limit: expected a number above 0, found .0' evaluate --config configs/tables/line.yaml --limit 0
refused '--threads: expected a number from 0 to 1024' evaluate --config configs/tables/line.yaml --threads 4000
refused '--seed: expected a number from 0 on' train --config configs/line.yaml --seed -3
refused '--group-timeout: expected a number above 0' train --config configs/line.yaml --group-timeout -1
refused '--greatest-tilt: expected a number from 0 to 89' prepare warp --input . --output "$own/none" --greatest-tilt 90
expect_error "no method is named 'ransack'; did you mean .* has .*theil_sen, .*ransac_20" \
  evaluate --config configs/tables/line.yaml --methods ransack --output "$own/none"
[[ ! -e "$own/none" ]] || fail "a refused call made a folder"
