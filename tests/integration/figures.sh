# The figures in the documents are those of the pages of results; one that is changed by hand is found, and filled again. Pages are of this
# history, as they were written, and have the rows of their configurations.
. "$(dirname "$0")/common.sh"
python=$(report_python) || { echo "skipped: there is no python3 with the modules of scripts/report"; exit 4; }
docs() { "$python" "$source/scripts/report/docs.py" "$@"; }
run_expecting 0 docs --check --check-pages --eval "$build/bin/diffsac_eval" README.md docs/*.md docs/results/claims.md
# The layout's table has every file that is read.
for file in $(grep -ohE '"[A-Za-z0-9_]+\.h5"' lib/lab/files/{correspondence_files,thumbnails}*.cpp | tr -d '"'); do
  grep -q "^| .*\`$file\`.* |" data_tools/README.md || fail "data_tools/README.md: the table of files has no $file"
done
# Texts alone: Doxygen would find pictures twice.
mkdir -p "$own/here/docs/results"
cp README.md "$own/here"
cp docs/*.md docs/figures.yaml "$own/here/docs"
cp docs/results/*.{md,json} "$own/here/docs/results"
cd "$own/here"
line=$(grep -n -m 1 'ours (`learned_prosac`)' README.md | cut -d: -f1)
sed -i "${line}s/\.[0-9]/.0/" README.md
run_expecting 1 docs --check README.md docs/*.md docs/results/claims.md
grep -q "^README.md:$line: a figure is not what its page has" "$own/out" || fail "the changed figure was not named"
run_expecting 0 docs README.md docs/*.md docs/results/claims.md
cmp README.md "$source/README.md" || fail "the filled document is another one"
# A page is as it was written, and its data are its own.
sed -i '/^| RANSAC 20 /s/0\.[0-9]/0.0/' docs/results/plane.md
run_expecting 1 docs --check --check-pages README.md docs/*.md docs/results/claims.md
grep -q "results/plane.md: was changed after it was written" "$own/out" || fail "the changed page was not named"
grep -q "results/plane.md: its table .* is not that of plane.json" "$own/out" || fail "a page and its data differ, which was not named"
echo "<!-- figure: nothing -->1<!-- / -->" >wrong.md
run_expecting 2 docs wrong.md
grep -q "wrong.md: docs/figures.yaml.*figures.nothing" "$own/err" || fail "a mark without a definition was not named"
