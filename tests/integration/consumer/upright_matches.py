"""Writes the matches of a pair as unit rays of frames whose y axis is down, for upright.cpp.

Usage: upright_matches.py FOLDER [KEY]. FOLDER holds matches.h5, K1_K2.h5, R.h5 and T.h5 (as diffsac_prepare writes them);
KEY is the pair, by default the one with the most matches. The first line is the focal length, then the true turn about y
and t. Down comes from the true rotations (of the first camera, if it was held upright), as an inertial sensor would give it.
"""
import sys

import h5py
import numpy as np


def upright(down):
    """Returns the smallest rotation that turns a direction to the y axis."""
    y = np.array([0.0, 1.0, 0.0])
    axis, cosine = np.cross(down, y), down @ y
    skew = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + skew + skew @ skew / (1 + cosine)


folder = sys.argv[1]
files = {name: h5py.File(f"{folder}/{name}.h5") for name in ("matches", "K1_K2", "R", "T")}
key = sys.argv[2] if len(sys.argv) > 2 else max(files["matches"], key=lambda k: len(files["matches"][k]))
first, second = key.split("-")
K1, K2 = files["K1_K2"][key][()].reshape(2, 3, 3)
R1, R2 = (files["R"][image][()] for image in (first, second))
T1, T2 = (files["T"][image][()].ravel() for image in (first, second))
down = R1.T @ [0.0, 1.0, 0.0]
A1, A2 = upright(R1 @ down), upright(R2 @ down)
R, t = A2 @ R2 @ R1.T @ A1.T, A2 @ (T2 - R2 @ R1.T @ T1)
points = files["matches"][key][()].astype(float)
rays = []
for K, A, x in ((K1, A1, points[:, :2]), (K2, A2, points[:, 2:])):
    d = np.c_[x, np.ones(len(x))] @ np.linalg.inv(K).T @ A.T
    rays.append(d / np.linalg.norm(d, axis=1, keepdims=True))
print(np.sqrt(K1[0, 0] * K2[0, 0]), np.arctan2(R[0, 2], R[0, 0]), *t)
np.savetxt(sys.stdout, np.hstack(rays), "%.9g")
