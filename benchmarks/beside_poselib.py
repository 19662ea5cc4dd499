"""Relative poses of synthetic pairs by this library (pip install .) and by PoseLib (pip install poselib): share within 5 degrees, milliseconds a
pair, and the ratio of the two, as Markdown. It is for seeing a change from one night to the next; on photographs: docs/peers.md.
"""

import argparse
import time

import diffsac
import numpy as np
import poselib

WIDTH, HEIGHT, MATCHES = 1280, 960, 1000
K = np.array([[1000.0, 0, WIDTH / 2], [0, 1000, HEIGHT / 2], [0, 0, 1]])
CAMERA = {"model": "PINHOLE", "width": WIDTH, "height": HEIGHT, "params": [1000, 1000, WIDTH / 2, HEIGHT / 2]}


def rotation(turn):
    angle = np.linalg.norm(turn)
    x, y, z = turn / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def pair(rng, right):
    """Points before both cameras, half a pixel of noise, wrong matches anywhere; ratios as SIFT's, of which wrong ones have greater."""
    r, t = rotation(rng.normal(size=3) * 0.15), rng.normal(size=3) * [0.6, 0.3, 0.3]
    points = rng.uniform([-2.5, -1.8, 4], [2.5, 1.8, 10], (MATCHES, 3))
    first, second = points @ K.T, (points @ r.T + t) @ K.T
    x1, x2 = (p[:, :2] / p[:, 2:] + rng.normal(size=(MATCHES, 2)) * 0.5 for p in (first, second))
    wrong = np.arange(MATCHES) >= right * MATCHES
    x2[wrong] = rng.uniform([0, 0], [WIDTH, HEIGHT], (wrong.sum(), 2))
    ratio = np.where(wrong, rng.uniform(0.6, 1, MATCHES), rng.uniform(0.4, 0.9, MATCHES))
    order = np.argsort(ratio)
    return x1[order], x2[order], ratio[order], r, t


def degrees(r, t, pose):
    turned = np.degrees(np.arccos(np.clip((np.trace(r.T @ pose[0]) - 1) / 2, -1, 1)))
    moved = np.degrees(np.arccos(np.clip(t @ pose[1] / np.linalg.norm(t) / np.linalg.norm(pose[1]), -1, 1)))
    return max(turned, moved)


def ours(x1, x2, ratio, seed):
    pose = diffsac.estimate_essential(x1, x2, K, K, ratio, seed=seed).pose
    return None if pose is None or not pose.translation.any() else (pose.rotation, pose.translation)


def theirs(x1, x2, ratio, seed):
    options = {"max_epipolar_error": 1.0, "max_iterations": 1000, "min_iterations": 100, "progressive_sampling": True, "seed": seed}
    pose, _ = poselib.estimate_relative_pose(x1, x2, CAMERA, CAMERA, options, {})
    return pose.R, pose.t


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=60, help="of each share of right matches (60)")
    pairs = parser.parse_args().pairs
    print(f"diffsac {diffsac.__version__} beside PoseLib {poselib.__version__}, {pairs} synthetic pairs of {MATCHES} matches a row\n")
    print("| right matches | within 5°: diffsac | PoseLib | ms: diffsac | PoseLib | ratio of times |\n|---|--:|--:|--:|--:|--:|")
    for right in (0.5, 0.25, 0.1):
        rng = np.random.default_rng(1)
        errors, times = ([], []), ([], [])
        for seed in range(pairs):
            x1, x2, ratio, r, t = pair(rng, right)
            for k, estimate in enumerate((ours, theirs)):
                start = time.perf_counter()
                pose = estimate(x1, x2, ratio, seed)
                times[k].append(1e3 * (time.perf_counter() - start))
                errors[k].append(180.0 if pose is None else degrees(r, t, pose))
        within = [np.mean(np.array(e) < 5) for e in errors]
        ms = [np.median(t) for t in times]
        print(f"| {right:g} | {within[0]:.2f} | {within[1]:.2f} | {ms[0]:.1f} | {ms[1]:.1f} | {ms[0] / ms[1]:.2f} |")


main()
