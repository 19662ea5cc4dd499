# data_tools/convert.py on small files in each format, and its mistakes.
. "$(dirname "$0")/common.sh"
for python in python3 /usr/bin/python3; do
  if "$python" -c 'import h5py, numpy, PIL, scipy' 2>/dev/null; then exec "$python" tests/integration/convert_test.py "$own"; fi
done
echo "skipped: there is no python3 with h5py, numpy, PIL and scipy"
exit 4
