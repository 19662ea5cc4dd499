#!/usr/bin/env python3
"""The official networks of NG-RANSAC (github.com/vislearn/ngransac, BSD-3, models/*.net) as weights that `diffsac_train --import`
reads (docs/ng_ransac.md). Not part of the build: needs torch and numpy of Python.

  scripts/peers/import_ng_ransac.py --task essential weights_e2e_E_rs_r1.00_.net OUT.safetensors
  scripts/peers/import_ng_ransac.py --task essential --random 8,2 OUT.safetensors    # weights of width 8, 2 blocks: the test's example

Their network and ours (lib/lab/torch/ng_ransac.h) differ in three things that are linear and are multiplied out here: their
batch normalisation uses stored moments, the matching ratio goes in as it is, and coordinates of a fundamental matrix are in
units of the longer side, ours of 1.2 longer sides.
"""
import argparse
import json
import os
import struct
import sys

import numpy as np
import torch
import torch.nn.functional as F

INPUTS = 5
EPSILON = 1e-5                       # of instance and batch normalisation
RATIO_MEAN, RATIO_SPREAD = 0.7, 0.25  # lib/diffsac/problem/point_features.cpp
USUAL_FOCAL = 1.2                     # lib/diffsac/problem/coordinates.cpp
NORM = ("weight", "bias", "running_mean", "running_var")


def fail(message):
    sys.exit(f"import_ng_ransac.py: {message}")


def expected_shapes(width, blocks):
    """Of the official program's state: 1x1 convolutions `s0`, `s2` and batch normalisations `s1`, `s3` of each block."""
    shapes = {"p_in.weight": (width, INPUTS, 1, 1), "p_in.bias": (width,), "p_out.weight": (1, width, 1, 1), "p_out.bias": (1,)}
    for block in range(blocks):
        for layer in (0, 2):
            shapes[f"{block}s{layer}.weight"] = (width, width, 1, 1)
            shapes[f"{block}s{layer}.bias"] = (width,)
            for name in NORM:
                shapes[f"{block}s{layer + 1}.{name}"] = (width,)
    return shapes


def read_state(path):
    try:
        state = torch.load(path, map_location="cpu", weights_only=True)
    except Exception as error:  # torch has one kind of exception for each way to be no weights
        fail(f"{path}: not a file of weights: {str(error).splitlines()[0]}")
    if not isinstance(state, dict) or "p_in.weight" not in state:
        fail(f"{path}: not a network of NG-RANSAC (it has no p_in.weight)")
    state = {name: value for name, value in state.items() if not name.endswith("num_batches_tracked")}
    blocks = sum(name.endswith("s0.weight") for name in state)
    shapes = expected_shapes(state["p_in.weight"].shape[0], blocks)
    if set(state) != set(shapes):
        fail(f"{path}: other weights than a network of {blocks} blocks has: {sorted(set(state) ^ set(shapes))[0]}")
    for name, shape in shapes.items():
        if tuple(state[name].shape) != shape or state[name].dtype != torch.float32:
            fail(f"{path}: {name} is {tuple(state[name].shape)}, {state[name].dtype}; expected {shape}, torch.float32")
    return state


def random_state(width, blocks):
    generator = torch.Generator().manual_seed(1)
    state = {}
    for name, shape in expected_shapes(width, blocks).items():
        scale = 1.0 / np.sqrt(shape[1]) if len(shape) == 4 else 0.5
        state[name] = scale * torch.randn(shape, generator=generator)
        if name.endswith("running_var"):
            state[name] = 0.5 + state[name].abs()
    return state


def log_weights(state, inputs):
    """What their network says, as the paper describes it: log of the sampling probabilities of N matches, inputs [N, 5]."""
    def convolve(name, x):
        return F.conv2d(x, state[name + ".weight"], state[name + ".bias"])

    def normalize(name, x):
        norm = {key: state[f"{name}.{key}"] for key in NORM}
        return F.batch_norm(F.instance_norm(x, eps=EPSILON), norm["running_mean"], norm["running_var"], norm["weight"],
                            norm["bias"], eps=EPSILON)

    x = F.relu(convolve("p_in", inputs.T[None, :, :, None]))
    for block in range(sum(name.endswith("s0.weight") for name in state)):
        hidden = F.relu(normalize(f"{block}s1", convolve(f"{block}s0", x)))
        x = x + F.relu(normalize(f"{block}s3", convolve(f"{block}s2", hidden)))
    return F.log_softmax(F.logsigmoid(convolve("p_out", x)).reshape(-1), dim=0)


def input_scales(task):
    """Theirs = scale * ours + shift, for each of the five inputs."""
    coordinates = USUAL_FOCAL if task == "fundamental" else 1.0
    return np.array([coordinates] * 4 + [RATIO_SPREAD]), np.array([0.0] * 4 + [RATIO_MEAN])


def converted(state, task):
    """Our parameters by name."""
    state = {name: value.double().numpy() for name, value in state.items()}
    scale, shift = input_scales(task)
    first = state["p_in.weight"].reshape(-1, INPUTS)
    ours = {"input.weight": first * scale, "input.bias": state["p_in.bias"] + first @ shift,
            "output.weight": state["p_out.weight"].reshape(1, -1), "output.bias": state["p_out.bias"]}
    for block in range(sum(name.endswith("s0.weight") for name in state)):
        for layer, name in ((0, "first"), (2, "second")):
            weight = state[f"{block}s{layer}.weight"]
            ours[f"block{block}.{name}.weight"] = weight.reshape(weight.shape[:2])
            ours[f"block{block}.{name}.bias"] = state[f"{block}s{layer}.bias"]
            gamma, beta, mean, variance = (state[f"{block}s{layer + 1}.{key}"] for key in NORM)
            gain = gamma / np.sqrt(variance + EPSILON)
            ours[f"block{block}.{name}_norm.gain"] = gain
            ours[f"block{block}.{name}_norm.shift"] = beta - gain * mean
    return ours


def example(state, task, matches=60):
    """Random features as ours are, and what their network says of them."""
    features = torch.randn((matches, INPUTS), generator=torch.Generator().manual_seed(2))
    scale, shift = (torch.tensor(values) for values in input_scales(task))
    with torch.no_grad():
        return features.numpy(), log_weights(state, (features.double() * scale + shift).float()).numpy()


def write_safetensors(path, tensors, metadata):
    """The length of a JSON header, the header, then the values of each tensor: 32-bit floats, row-major."""
    header, data = {"__metadata__": metadata}, b""
    for name, value in sorted(tensors.items()):
        begin = len(data)
        data += np.ascontiguousarray(value, dtype="<f4").tobytes()
        header[name] = {"dtype": "F32", "shape": list(value.shape), "data_offsets": [begin, len(data)]}
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    with open(path + ".part", "wb") as file:
        file.write(struct.pack("<Q", len(text)) + text + data)
    os.replace(path + ".part", path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("weights", nargs="?", help="models/weights_....net of the official repository")
    parser.add_argument("output", help="a safetensors file")
    parser.add_argument("--task", required=True, choices=["essential", "fundamental"], help="what the network was trained for")
    parser.add_argument("--random", metavar="WIDTH,BLOCKS", help="random weights instead of a file's")
    arguments = parser.parse_args()
    if (arguments.weights is None) == (arguments.random is None):
        fail("expected a file of weights, or --random")
    state = random_state(*map(int, arguments.random.split(","))) if arguments.random else read_state(arguments.weights)
    features, expected = example(state, arguments.task)
    weights = converted(state, arguments.task)
    tensors = {f"network.{name}": value for name, value in weights.items()}
    tensors |= {"example.features": features, "example.log_weights": expected}
    source = os.path.basename(arguments.weights or "random")
    write_safetensors(arguments.output, tensors, {"method": "ng_ransac", "task": arguments.task, "source": source})
    print(f"{arguments.output}: {len(weights)} weights")


if __name__ == "__main__":
    main()
