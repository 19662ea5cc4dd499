"""Fails where a module that these scripts and data_tools/convert.py need is missing; imports none, so that it is quick."""
import importlib.util
import sys

MODULES = ("matplotlib", "jinja2", "pandas", "h5py", "yaml", "scipy", "PIL")

if __name__ == "__main__":
    missing = [name for name in MODULES if importlib.util.find_spec(name) is None]
    sys.exit("python3 has no module " + ", ".join(missing) if missing else 0)
