"""inference_weights.py IN OUT: a network's file without what only training needs, half its size.

Inference takes the weights' moving average, the tensors `average.*` (lib/diffsac/network/checkpoint_info.h).
"""

import json
import struct
import sys

PREFIX = "average."


def main(source: str, target: str) -> None:
    with open(source, "rb") as file:
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
        sys.exit(f"{source}: no tensors {PREFIX}*")
    text = json.dumps(kept).encode()
    text += b" " * (-len(text) % 8)  # The data begin at a multiple of 8 bytes.
    with open(target, "wb") as file:
        file.write(struct.pack("<Q", len(text)) + text + b"".join(parts))


if __name__ == "__main__":
    main(*sys.argv[1:])
