#!/usr/bin/env bash
# Makes the documentation a site: the reference of diffsac/diffsac.h and of what it includes, and the pages of docs/. Every warning
# is an error. The site is build/docs/index.html.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

output=${1:-build/docs}
command -v doxygen >/dev/null || { echo "docs: needs doxygen (apt-get install doxygen)" >&2; exit 1; }

# headers_of HEADER: it and what it includes of the library, each once.
declare -A seen
headers_of() {
  local header=$1 included
  [[ -z "${seen[$header]:-}" ]] || return 0
  seen[$header]=1
  while read -r included; do headers_of "lib/$included"; done < <(sed -n 's/^#include "\(diffsac\/.*\)"$/\1/p' "$header")
}
headers_of lib/diffsac/diffsac.h

version=$(sed -n 's/.*kVersion\[\] = "\(.*\)".*/\1/p' lib/diffsac/core/version.h)
rm -rf "$output"
mkdir -p "$output"
{
  cat docs/Doxyfile
  echo "PROJECT_NUMBER = $version"
  echo "OUTPUT_DIRECTORY = $output"
  echo "USE_MDFILE_AS_MAINPAGE = $PWD/README.md"
  echo "INPUT = README.md CHANGELOG.md CONTRIBUTING.md docs data_tools/README.md benchmarks/README.md models/README.md ${!seen[*]}"
} | doxygen -
echo "docs: $output/index.html"
