#!/usr/bin/env bash
# Installs the Python module by pip into a fresh environment and tests it there, its digits against those of a C++ program that
# links the same library. Exits with 4, saying why, where there is no Python, or no package index to build with.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

usage() {
  cat <<'END'
usage: scripts/test_python.sh [--python PROGRAM] [--keep DIR]
  --python PROGRAM   the Python to test with, 3.10 or later (python3)
  --keep DIR         work in DIR and leave it there (a temporary folder that is removed)
END
}

skip() { echo "test_python: skipped: $*"; exit 4; }

python=python3 work=""
while (($#)); do
  case "$1" in
    --python) python=$2; shift 2 ;;
    --keep) work=$2; shift 2 ;;
    -h|--help) usage; exit 0 ;;
    *) usage >&2; exit 1 ;;
  esac
done
if [[ -z "$work" ]]; then
  work=$(mktemp -d)
  trap 'rm -rf "$work"' EXIT
fi

command -v "$python" >/dev/null || skip "there is no $python"
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 10))' || skip "$("$python" --version) is older than 3.10"
rm -rf "$work/venv"
"$python" -m venv "$work/venv" || skip "$python makes no environments"
"$work/venv/bin/pip" install --quiet numpy mypy || skip "pip cannot fetch numpy"
# What the examples read; without them their tests are skipped.
"$work/venv/bin/pip" install --quiet h5py opencv-python-headless || true

# The name by which CMake calls the compiler: with another one the compiler's cache would know none of the files.
export CXX=${CXX:-c++}
"$work/venv/bin/pip" install .
cmake --install build/python --component library --prefix "$work/prefix" >/dev/null
cmake -S tests/integration/consumer -B "$work/cpp" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$work/prefix" >/dev/null
cmake --build "$work/cpp" --target estimates
DIFFSAC_CPP_ESTIMATES="$work/cpp/estimates" "$work/venv/bin/python" -m unittest discover -s tests/python -v
"$work/venv/bin/mypy" --strict --allow-any-generics -p diffsac
