"""What the folders of runs hold, of the standard library alone.

run_files.py whole DIR...   every file that bears a final name can be read as whole; hidden ones are temporary
run_files.py same A B       the same files with the same content, times and dates aside, and nothing temporary
"""
import csv
import json
import os
import struct
import sys
import zlib


def check_png(data):
    assert data[:8] == b"\x89PNG\r\n\x1a\n", "no PNG"
    at, kind = 8, b""
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 4:at + 8 + length]
        assert len(body) == length + 4 and struct.unpack_from(">I", data, at + 8 + length)[0] == zlib.crc32(body), "a broken part"
        at += 12 + length
    assert kind == b"IEND" and at == len(data), "no end"


def check_hdf5(data):
    assert data[:8] == b"\x89HDF\r\n\x1a\n", "no HDF5"
    end = struct.unpack_from("<Q", data, 40 if data[8] < 2 else 28)[0]
    assert end == len(data), f"{len(data)} bytes of {end}"


def check_safetensors(data):
    length = struct.unpack_from("<Q", data)[0]
    header = json.loads(data[8:8 + length])
    end = max(tensor["data_offsets"][1] for name, tensor in header.items() if name != "__metadata__")
    assert 8 + length + end == len(data), f"{len(data)} bytes of {8 + length + end}"


def check_csv(data):
    assert data.endswith(b"\n"), "no end of the last line"


def check_table(data):
    check_csv(data)
    rows = list(csv.reader(data.decode().splitlines()))
    assert all(len(row) == len(rows[0]) for row in rows), "a line of another length"


def check_html(data):
    assert data.startswith(b"<!") and data.rstrip().endswith(b"</html>"), "no end"


def check_text(data):
    assert data.endswith(b"\n"), "no end of the last line"


def check_file(path):
    with open(path, "rb") as file:
        data = file.read()
    name, extension = os.path.split(path)[1], os.path.splitext(path)[1]
    if name == "log.txt" or extension == ".bin":
        return  # Logs grow line by line; a cache says its length, and what does not fit is made again.
    checks = {".png": check_png, ".h5": check_hdf5, ".safetensors": check_safetensors, ".html": check_html,
              ".json": json.loads, ".csv": check_csv if name == "table.csv" else check_table}
    try:
        checks.get(extension, check_text)(data)
    except Exception as error:
        sys.exit(f"{path} is no whole file: {error}")


def files_in(folder, hidden):
    found = []
    for root, folders, names in os.walk(folder):
        names += [name for name in folders if name.startswith(".")]
        if not hidden:
            names = [name for name in names if not name.startswith(".")]
            folders[:] = [name for name in folders if not name.startswith(".")]
        found += [os.path.relpath(os.path.join(root, name), folder) for name in names]
    return sorted(found)


def without_times(path):
    """The content, less what a clock decides."""
    name, extension = os.path.split(path)[1], os.path.splitext(path)[1]
    if name in ("log.txt", "report.html") or os.path.splitext(name)[0] in ("table", "time"):
        return None
    with open(path, "rb") as file:
        data = file.read()
    if extension == ".csv":
        rows = list(csv.reader(data.decode().splitlines()))
        kept = [i for i, column in enumerate(rows[0]) if not column.startswith("ms_") and column != "data_wait_share"]
        return [[row[i] for i in kept] for row in rows if not any(value.startswith("ms_") for value in row)]
    if extension == ".json":
        measured = ("seconds", "peak_memory_mib", "run", "tables", "strata", "effects")
        return json.loads(data, object_pairs_hook=lambda items: {
            k: v for k, v in items if not k.startswith("ms_") and k not in measured})
    return [line for line in data.split(b"\n") if not line.startswith(b"# date:")]


def compare(first, second):
    names = files_in(first, True)
    other = files_in(second, True)
    if names != other:
        sys.exit(f"{second} has other files than {first}: {sorted(set(names) ^ set(other))}")
    for name in names:
        if without_times(os.path.join(first, name)) != without_times(os.path.join(second, name)):
            sys.exit(f"{name} of {second} differs from that of {first}")


if sys.argv[1] == "same":
    compare(sys.argv[2], sys.argv[3])
for place in sys.argv[2:]:
    for found in files_in(place, False):
        check_file(os.path.join(place, found))
