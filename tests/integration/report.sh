# report.html as a person uses it: opened, sorted, a pair's picture, in a browser without a screen. Without chromium only
# the file itself is looked at.
. "$(dirname "$0")/common.sh"
cat >"$own/pairs.yaml" <<'YAML'
name: pairs
report: {title: Pairs <script>alert("nasty")</script>}
task: fundamental
problems: 12
data: {type: synthetic_two_view, task: fundamental, num_points: 60}
methods:
  exact: {type: lo_ransac, label: LO-RANSAC, max_iterations: 300}
  one: {type: ransac, label: one set, max_iterations: 1}
YAML
report_python >/dev/null || { echo "skipped: there is no python3 with the modules of scripts/report"; exit 4; }
run_expecting 0 evaluate --config "$own/pairs.yaml" --threads 1 --output "$own/run"
run_expecting 0 report "" "$own/run"
expect_file "$own/run/report.html"
! grep -qE 'https?:|src="|<script>alert' "$own/run/report.html" || fail "the report asks for something or runs a name"

# Shards joined have it as well.
for i in 1 2; do run_expecting 0 evaluate --config "$own/pairs.yaml" --threads 1 --shard "$i/2" --output "$own/shard$i"; done
run_expecting 0 report merge.py "$own"/shard{1,2} --output "$own/merged"
run_expecting 0 report "" "$own/merged"
page="$own/merged/report.html"
expect_file "$page"
grep -q 'id="masks-11"' "$page" || fail "a joined report has not all pictures"

if ! chromium=$(command -v chromium || command -v chromium-browser || command -v google-chrome); then
  echo "skipped: no chromium to open the report in"
  exit 4
fi
# browse FRAGMENT ARGUMENTS...
browse() {
  local address="file://${page// /%20}$1"
  shift
  HOME="$own" timeout 100 "$chromium" --headless --no-sandbox --disable-gpu --hide-scrollbars --window-size=1200,2400 \
    --virtual-time-budget=5000 --enable-logging=stderr "$@" "$address" 2>"$own/browser"
  ! grep -E 'CONSOLE.*(Uncaught|Refused)' "$own/browser" || fail "the report's script fails"
}
browse '' --dump-dom >"$own/opened.html"
rows() { grep -o '<tr class="[^"]*opens[^"]*"' "$1" | wc -l; }
(($(rows "$own/opened.html") == 12)) || fail "$(rows "$own/opened.html") pairs are listed, not the 12 of the first method"
grep -q '1–12 of 12' "$own/opened.html" || fail "the list does not say how long it is"
browse '#method=0&sort=1.2.asc' --dump-dom >"$own/sorted.html"
(($(rows "$own/sorted.html") == 24)) || fail "the choice of all methods does not list all lines"
order() { sed -n '/<tbody>/,/<\/tbody>/p;/<\/table>/q' "$1" | grep -o '<th scope="row">[^<]*' | sed 's/.*>//' | paste -sd,; }
[[ "$(order "$own/sorted.html")" == "one set,LO-RANSAC" ]] || fail "sorted by accuracy: $(order "$own/sorted.html")"
grep -q 'aria-sort="ascending"' "$own/sorted.html" || fail "no sign of the column that is sorted by"

# The third pair: its title is that of the third line, and its picture is painted.
browse '#method=2&pair=3&scroll=no' --dump-dom >"$own/pair.html"
third=$(sed 's/<tr /\n<tr /g' "$own/pair.html" | grep -E '^<tr class="[^"]*opens' | sed -n 's/.*<a href="#pair=3">\([^<]*\)<.*/\1/p')
shown=$(grep -o '<h3 id="pair-title">[^<]*' "$own/pair.html" | sed 's/.*>//')
[[ -n "$third" && "$shown" == "$third"* ]] || fail "pair 3 is '$third', the picture that of '$shown'"
grep -q 'data-opened-ms=' "$own/pair.html" || fail "the picture was not painted"
grep -qE 'aria-label="matches of [^"]*: [0-9]+ right, [0-9]+ wrong, [0-9]+ missed"' "$own/pair.html" || fail "no counts of the picture"
browse '#method=1&pair=2&scroll=no' --dump-dom >"$own/model.html"
grep -q '<pre id="pair-model">F = ' "$own/model.html" || fail "no model beside the picture"
grep -q 'id="pair-model" hidden' "$own/opened.html" || fail "a model without a pair"
(($(grep -o '<summary>What the columns mean</summary>' "$own/pair.html" | wc -l) == 2)) || fail "columns are not explained below tables and list"
browse '#method=1&pair=1&scroll=no' --screenshot="$own/pair.png"
expect_file "$own/pair.png"
