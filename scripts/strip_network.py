"""strip_network.py FILE...: takes out of checkpoints what only a training that goes on needs, in place; half of their size or more.

Inference and `train.start_from` take the weights' moving average, the tensors `average.*` (lib/diffsac/network/engine/checkpoint_info.h).
"""

import json
import os
import struct
import sys

PREFIX = "average."


def strip(path: str) -> None:
    with open(path, "rb") as file:
        header = json.loads(file.read(struct.unpack("<Q", file.read(8))[0]))
        data = file.read()
    kept = {"__metadata__": header["__metadata__"]}
    parts, end = [], 0
    for name, tensor in header.items():
        if name.startswith(PREFIX):
            parts.append(data[slice(*tensor["data_offsets"])])
            kept[name] = {**tensor, "data_offsets": [end, end + len(parts[-1])]}
            end += len(parts[-1])
    if not parts:
        sys.exit(f"{path}: no tensors {PREFIX}*")
    text = json.dumps(kept).encode()
    text += b" " * (-len(text) % 8)  # The data begin at a multiple of 8 bytes.
    with open(path + ".part", "wb") as file:
        file.write(struct.pack("<Q", len(text)) + text + b"".join(parts))
    os.replace(path + ".part", path)


if __name__ == "__main__":
    for path in sys.argv[1:] or sys.exit(__doc__):
        strip(path)
