"""Prints what a checkpoint holds, read by Python's `safetensors` where it is installed, and by the format's definition
alone (json and struct) everywhere; both must agree.

  read_safetensors.py FILE     prints a line `PART tensors values sum` for each part, and one for method, task, iteration
"""
import itertools
import json
import math
import struct
import sys

SIZES = {"F32": ("f", 4), "I64": ("q", 8)}


def read(path):
    with open(path, "rb") as file:
        content = file.read()
    length, = struct.unpack("<Q", content[:8])
    header, data = json.loads(content[8:8 + length]), content[8 + length:]
    metadata, tensors = header.pop("__metadata__"), {}
    for name, tensor in header.items():
        code, size = SIZES[tensor["dtype"]]
        begin, end = tensor["data_offsets"]
        count = math.prod(tensor["shape"])
        assert end - begin == size * count and begin % size == 0 and end <= len(data), name
        tensors[name] = struct.unpack(f"<{count}{code}", data[begin:end])
    assert sum(end - begin for begin, end in (t["data_offsets"] for t in header.values())) == len(data)
    return metadata, tensors


def check_with_library(path, metadata, tensors):
    try:
        from safetensors.numpy import safe_open
    except ImportError:
        return "plain Python alone"
    with safe_open(path, framework="numpy") as file:
        assert file.metadata() == metadata and set(file.keys()) == set(tensors)
        for name, values in tensors.items():
            assert tuple(file.get_tensor(name).reshape(-1).tolist()) == values, name
    return "safetensors agrees"


def main(path):
    metadata, tensors = read(path)
    for part in sorted({name.split(".")[0] for name in tensors}):
        mine = [values for name, values in tensors.items() if name.startswith(part + ".")]
        print(part, len(mine), sum(map(len, mine)), "finite" if all(map(math.isfinite, itertools.chain(*mine))) else "not finite")
    print(metadata["method"], metadata["task"], metadata["iteration"])
    print("steps", *sorted({values[0] for name, values in tensors.items() if name.startswith("optimizer.step.")}))
    print("read by:", check_with_library(path, metadata, tensors))


main(sys.argv[1])
