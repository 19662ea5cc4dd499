"""Checks of the rooms that cmake/budgets.txt lists: their sizes, and which way they include.

    rooms.py sizes SOURCE      no room has more lines of C++ than its budget, and every room has one
    rooms.py includes SOURCE   files include and targets link only their own room and those listed before it
"""
import pathlib
import re
import sys

TREES = ("lib/diffsac", "lib/lab")


def cpp_files(folder, deep=True):
    found = folder.rglob("*") if deep else folder.glob("*")
    return sorted(path for path in found if path.suffix in (".h", ".cpp"))


def lines_of(path):
    return path.read_bytes().count(b"\n")


def budgets(source):
    """{room: lines}, in the order of the file; a total's name holds its rooms, with blanks between."""
    rooms = {}
    for line in (source / "cmake/budgets.txt").read_text().splitlines():
        if line.strip() and not line.startswith("#"):
            room, lines = line.rsplit(None, 1)
            rooms[" ".join(room.split())] = int(lines)
    return rooms


def rooms_of(source):
    trees = [f"{tree}/{path.name}" for tree in TREES for path in sorted((source / tree).iterdir()) if path.is_dir()]
    return trees + ["apps", "data_tools", "tests"]


def check_sizes(source):
    limits = budgets(source)
    faults = [f"cmake/budgets.txt has no budget of {room}" for room in rooms_of(source) if room not in limits]
    for name, limit in limits.items():
        missing = [room for room in name.split() if not (source / room).is_dir()]
        if missing:
            faults.append(f"cmake/budgets.txt: there is no room {' '.join(missing)}")
            continue
        files = [path for room in name.split() for path in cpp_files(source / room)]
        size = sum(map(lines_of, files))
        if size > limit:
            largest = sorted(files, key=lines_of)[:-4:-1]
            faults.append(f"{name} has {size} lines of C++, {size - limit} above its budget; the largest files: " +
                          ", ".join(f"{path.relative_to(source)} ({lines_of(path)})" for path in largest))
    return faults


def check_includes(source):
    order = [room for room in budgets(source) if room.startswith("lib/") and " " not in room and room not in TREES]
    drawn = re.findall(r"^(?:    lib/\w+/ +| {18})([a-z_]+) +\S", (source / "docs/architecture.md").read_text(), re.M)
    faults = []
    if drawn[:len(order)] != [room.split("/")[-1] for room in order]:
        faults.append(f"docs/architecture.md draws the rooms as {drawn[:len(order)]}, cmake/budgets.txt lists {order}")
    targets = {"diffsac_" + room.split("/")[-1]: at for at, room in enumerate(order)}
    for at, room in enumerate(order):
        for path in cpp_files(source / room):
            for number, line in enumerate(path.read_text().splitlines(), 1):
                found = re.match(r'#include "((?:diffsac|lab)/\w+)/', line)
                if found and f"lib/{found[1]}" in order[at + 1:]:
                    faults.append(f"{path.relative_to(source)}:{number}: {line} is of a room after {room}")
        rules = source / room / "CMakeLists.txt"
        linked = re.findall(r"\bdiffsac_\w+", rules.read_text()) if rules.exists() else []
        faults += [f"{rules.relative_to(source)}: {target} is of a room after {room}"
                   for target in linked if targets.get(target, at) > at]
    return faults


if __name__ == "__main__":
    found = {"sizes": check_sizes, "includes": check_includes}[sys.argv[1]](pathlib.Path(sys.argv[2]))
    print("\n".join(found))
    sys.exit(bool(found))
