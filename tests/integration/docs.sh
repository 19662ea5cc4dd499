# The documentation becomes a site without a warning. Skips, saying so, where there is no Doxygen.
. "$(dirname "$0")/common.sh"
command -v doxygen >/dev/null || { echo "skipped: there is no doxygen here"; exit 4; }
run_expecting 0 scripts/docs.sh "$own/site"
expect_file "$own/site/index.html" "$own/site/namespacediffsac.html"
grep -q "EstimateEssential" "$own/site/namespacediffsac.html" || fail "a function of the header is missing"
