# python.sh BUILD SOURCE TEST: runs a test of scripts/ by the first python3 that has what they need; without one it is skipped.
build=$1 source=$2 test=$3
for python in python3 /usr/bin/python3; do
  if "$python" -B "$source/scripts/report/check_modules.py" 2>/dev/null; then
    exec "$python" -B "$source/tests/scripts/$test" "$build" "$source"
  fi
done
echo "skipped: no python3 with the modules of scripts/report/check_modules.py"
exit 4
