# The figures in the documents are those of the pages of results; one that is changed by hand is found, and filled again.
. "$(dirname "$0")/common.sh"
figures="$build/bin/diffsac_docs"
run_expecting 0 "$figures" --check --check-pages README.md docs/*.md docs/results/claims.md
# Texts alone: Doxygen would find pictures twice.
mkdir -p "$own/here/docs/results"
cp README.md "$own/here"
cp docs/*.md docs/figures.yaml "$own/here/docs"
cp docs/results/*.md "$own/here/docs/results"
cd "$own/here"
line=$(grep -n -m 1 'ours (`learned_prosac`)' README.md | cut -d: -f1)
sed -i "${line}s/\.[0-9]/.0/" README.md
run_expecting 1 "$figures" --check README.md docs/*.md docs/results/claims.md
grep -q "^README.md:.*a figure is not what its page has" "$own/out" || fail "the changed figure was not named"
run_expecting 0 "$figures" README.md docs/*.md docs/results/claims.md
cmp README.md "$source/README.md" || fail "the filled document is another one"
# A page is as it was written.
sed -i '0,/0\.[0-9]/s//0.0/' docs/results/line.md
run_expecting 1 "$figures" --check --check-pages README.md
grep -q "results/line.md: was changed after it was written" "$own/out" || fail "the changed page was not named"
echo "<!-- figure: nothing -->1<!-- / -->" >wrong.md
run_expecting 2 "$figures" wrong.md
grep -q "wrong.md: docs/figures.yaml.*figures.nothing" "$own/err" || fail "a mark without a definition was not named"
