#!/usr/bin/env python3
"""Errors of a COLMAP reconstruction's poses (text model) against known ones: for every pair of registered images the angle
between relative rotations and between directions of the baseline, which need no alignment. Not part of the build.

  scripts/peers/colmap_poses.py MODEL strecha|colmap|nerf|poses FOLDER
"""
import itertools
import json
import math
import os
import statistics
import sys


def transpose(m):
    return [list(row) for row in zip(*m)]


def product(a, b):
    return [[sum(x * y for x, y in zip(row, column)) for column in zip(*b)] for row in a]


def apply(m, v):
    return [sum(x * y for x, y in zip(row, v)) for row in m]


def degrees(cosine):
    return math.degrees(math.acos(max(-1.0, min(1.0, cosine))))


def numbers(path):
    with open(path) as file:
        return [float(word) for word in file.read().split()]


def colmap_images(folder):
    """World-to-camera rotation and camera centre of each image of images.txt, by the file's name."""
    images, rows = {}, [line.split() for line in open(os.path.join(folder, "images.txt")) if not line.startswith("#")]
    for row in rows[::2]:
        w, x, y, z, *t = map(float, row[1:8])
        rotation = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                    [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                    [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
        images[row[9]] = rotation, [-c for c in apply(transpose(rotation), t)]
    return images


def strecha_images(folder):
    images, cameras = {}, os.path.join(folder, "gt_dense_cameras")
    for name in os.listdir(cameras):
        v = numbers(os.path.join(cameras, name))
        images[name.removesuffix(".camera")] = transpose([v[12:15], v[15:18], v[18:21]]), v[21:24]
    return images


def camera_to_world(rows, flip=False):
    axes = [[row[0], -row[1], -row[2]] if flip else list(row[:3]) for row in rows[:3]]
    return transpose(axes), [row[3] for row in rows[:3]]


def nerf_images(folder):
    with open(os.path.join(folder, "transforms.json")) as file:
        frames = json.load(file)["frames"]
    return {os.path.basename(f["file_path"]): camera_to_world(f["transform_matrix"], flip=True) for f in frames}


def posed_images(folder):
    images = {}
    for name in os.listdir(os.path.join(folder, "pose")):
        v = numbers(os.path.join(folder, "pose", name))
        images[name.removesuffix(".txt") + ".jpg"] = camera_to_world([v[0:4], v[4:8], v[8:12]])
    return images


def relative(images, first, second):
    (r1, c1), (r2, c2) = images[first], images[second]
    baseline = apply(r1, [b - a for a, b in zip(c1, c2)])
    length = math.sqrt(sum(x * x for x in baseline))
    return product(r2, transpose(r1)), [x / length for x in baseline]


def main(model, kind, folder):
    read = {"strecha": strecha_images, "colmap": colmap_images, "nerf": nerf_images, "poses": posed_images}[kind]
    found, truth = colmap_images(model), read(folder)
    turns, directions = [], []
    for first, second in itertools.combinations(sorted(set(found) & set(truth)), 2):
        (r, b), (r_true, b_true) = relative(found, first, second), relative(truth, first, second)
        turned = product(r, transpose(r_true))
        turns.append(degrees((turned[0][0] + turned[1][1] + turned[2][2] - 1) / 2))
        directions.append(degrees(sum(x * y for x, y in zip(b, b_true))))
    print(f"{statistics.median(turns):.3f} {statistics.median(directions):.3f}")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
