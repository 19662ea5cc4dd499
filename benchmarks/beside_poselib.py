"""Relative poses and fundamental matrices of synthetic pairs by this library (pip install .) and by PoseLib (pip install poselib): share that is
right (E: within 5 degrees; F: exact matches within a pixel of their lines, in the median), milliseconds a pair in turn on one thread, and the ratio of the two, as
Markdown. It is for seeing a change from one night to the next; on photographs: docs/peers.md.
"""

import argparse
import time

import diffsac
import numpy as np
import poselib

WIDTH, HEIGHT = 1280, 960
K = np.array([[1000.0, 0, WIDTH / 2], [0, 1000, HEIGHT / 2], [0, 0, 1]])
CAMERA = {"model": "PINHOLE", "width": WIDTH, "height": HEIGHT, "params": [1000, 1000, WIDTH / 2, HEIGHT / 2]}


def rotation(turn):
    angle = np.linalg.norm(turn)
    x, y, z = turn / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def pair(rng, right, count):
    """Points before both cameras, half a pixel of noise, wrong matches anywhere; ratios as SIFT's, of which wrong ones have greater."""
    r, t = rotation(rng.normal(size=3) * 0.15), rng.normal(size=3) * [0.6, 0.3, 0.3]
    points = rng.uniform([-2.5, -1.8, 4], [2.5, 1.8, 10], (count, 3))
    first, second = points @ K.T, (points @ r.T + t) @ K.T
    x1, x2 = (p[:, :2] / p[:, 2:] + rng.normal(size=(count, 2)) * 0.5 for p in (first, second))
    wrong = np.arange(count) >= right * count
    x2[wrong] = rng.uniform([0, 0], [WIDTH, HEIGHT], (wrong.sum(), 2))
    ratio = np.where(wrong, rng.uniform(0.6, 1, count), rng.uniform(0.4, 0.9, count))
    order = np.argsort(ratio)
    return x1[order], x2[order], ratio[order], r, t


def pose_is_right(r, t, pose):
    turned = np.degrees(np.arccos(np.clip((np.trace(r.T @ pose[0]) - 1) / 2, -1, 1)))
    moved = np.degrees(np.arccos(np.clip(t @ pose[1] / np.linalg.norm(t) / np.linalg.norm(pose[1]), -1, 1)))
    return max(turned, moved) < 5


def matrix_is_right(r, t, matrix):
    points = np.random.default_rng(0).uniform([-2.5, -1.8, 4], [2.5, 1.8, 10], (100, 3))
    first, second = (p / p[:, 2:] for p in (points @ K.T, (points @ r.T + t) @ K.T))
    lines = first @ matrix.T
    return np.median(np.abs((second * lines).sum(1)) / np.linalg.norm(lines[:, :2], axis=1)) < 1


def our_pose(x1, x2, ratio, seed):
    pose = diffsac.estimate_essential(x1, x2, K, K, ratio, seed=seed).pose
    return None if pose is None or not pose.translation.any() else (pose.rotation, pose.translation)


def our_matrix(x1, x2, ratio, seed):
    estimate = diffsac.estimate_fundamental(x1, x2, ratio, seed=seed)
    return estimate.model if estimate.ok else None


def options(seed, draws):
    return {"max_epipolar_error": 1.0, "max_iterations": 1000, "min_iterations": draws, "progressive_sampling": True, "seed": seed}


def their_pose(x1, x2, seed, draws):
    pose, _ = poselib.estimate_relative_pose(x1, x2, CAMERA, CAMERA, options(seed, draws), {})
    return pose.R, pose.t


def their_matrix(x1, x2, seed, draws):
    return poselib.estimate_fundamental(x1, x2, options(seed, draws), {})[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=60, help="of each share of right matches (60)")
    parser.add_argument("--matches", type=int, default=1000, help="a pair (1000)")
    parser.add_argument("--draws", type=int, default=100, help="PoseLib's least; its most are 1000 (100)")
    args = parser.parse_args()
    print(f"diffsac {diffsac.__version__} beside PoseLib {poselib.__version__} ({args.draws} to 1000 draws), {args.pairs} synthetic pairs of {args.matches} matches a row\n")
    print("| right matches | right: diffsac | PoseLib | ms: diffsac | PoseLib | ratio of times |\n|---|--:|--:|--:|--:|--:|")
    for name, is_right, ours, theirs in (("E", pose_is_right, our_pose, their_pose), ("F", matrix_is_right, our_matrix, their_matrix)):
        for right in (0.5, 0.25, 0.1):
            rng = np.random.default_rng(1)
            found, times = ([], []), ([], [])
            for seed in range(args.pairs):
                x1, x2, ratio, r, t = pair(rng, right, args.matches)
                for k, estimate in enumerate((lambda: ours(x1, x2, ratio, seed), lambda: theirs(x1, x2, seed, args.draws))):
                    start = time.perf_counter()
                    model = estimate()
                    times[k].append(1e3 * (time.perf_counter() - start))
                    found[k].append(model is not None and is_right(r, t, model))
            (ours_right, theirs_right), ms = (np.mean(f) for f in found), [np.median(t) for t in times]
            print(f"| {name} {right:g} | {ours_right:.2f} | {theirs_right:.2f} | {ms[0]:.1f} | {ms[1]:.1f} | {ms[0] / ms[1]:.2f} |")


main()
