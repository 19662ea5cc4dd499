#!/usr/bin/env bash
# Makes .deps/peers, a Python environment of the pinned estimators of requirements.txt. It is made again where they have changed.
#
#   scripts/peers/environment.sh [PYTHON]    Python 3.11, for which all of them have wheels (python3.11)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
requirements=scripts/peers/requirements.txt target=.deps/peers
if cmp -s "$requirements" "$target/requirements.txt"; then exit; fi
python=${1:-python3.11}
[[ "$("$python" --version 2>&1)" == "Python 3.11."* ]] || { echo "environment: '$python' is no Python 3.11" >&2; exit 2; }
rm -rf "$target"
mkdir -p .deps
"$python" -m venv "$target"
"$target/bin/pip" install --quiet --no-input --disable-pip-version-check --only-binary=:all: --requirement "$requirements"
cp "$requirements" "$target/requirements.txt"     # last: without it nothing counts as made
