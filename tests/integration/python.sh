# The Python module, installed by pip into an environment of its own. Skips, saying why, where there is no Python or no package index.
. "$(dirname "$0")/common.sh"
scripts/test_python.sh --keep "$own/work"
