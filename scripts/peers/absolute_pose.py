#!/usr/bin/env python3
"""PoseLib's absolute poses on the images of configs/tables/absolute_pose.yaml, by the same error (docs/metrics.md). Not part
of the build: needs h5py, numpy and poselib of Python.

  scripts/peers/absolute_pose.py runs/poses/lund_door/scene_points.h5
"""
import os
import sys
import time

os.environ["OMP_NUM_THREADS"] = "1"
import h5py
import numpy as np
import poselib

THRESHOLD_PX, MOST_DEGREES = 4.0, 0.05


def error_degrees(R, t, truth, scene):
    R_true, t_true = truth[:, :3], truth[:, 3]
    turn = np.degrees(np.arccos(np.clip((np.trace(R @ R_true.T) - 1) / 2, -1, 1)))
    centre, true_centre = -R.T @ t, -R_true.T @ t_true
    offset, away = np.linalg.norm(centre - true_centre), np.linalg.norm(true_centre - scene.mean(axis=0))
    return max(turn, np.degrees(np.arctan2(offset, away)))


def estimate(group, max_ratio, hypotheses, prosac):
    points, ratios, K = group["points"][()], group["ratios"][()], group["K"][()]
    points = points[np.argsort(ratios, kind="stable")][: np.count_nonzero(ratios <= max_ratio)]
    camera = {"model": "PINHOLE", "width": int(2 * K[0, 2]), "height": int(2 * K[1, 2]),
              "params": [K[0, 0], K[1, 1], K[0, 2], K[1, 2]]}
    options = {"max_reproj_error": THRESHOLD_PX, "max_iterations": hypotheses, "min_iterations": min(hypotheses, 100),
               "success_prob": 0.9999, "progressive_sampling": prosac}
    start = time.perf_counter()
    pose, _ = poselib.estimate_absolute_pose(np.ascontiguousarray(points[:, 3:]), np.ascontiguousarray(points[:, :3]),
                                             camera, options, {})
    ms = 1e3 * (time.perf_counter() - start)
    return error_degrees(pose.R, pose.t, group["pose"][()], points[:, :3]), ms


def main():
    for name, max_ratio in (("all matches", 1.0), ("ratio 0.9", 0.9)):
        for prosac in (False, True):
            results = []
            for path in sys.argv[1:]:
                with h5py.File(path, "r") as scene:
                    results += [estimate(scene[image], max_ratio, 1000, prosac) for image in scene]
            errors, times = np.array(results).T
            accurate = errors[:, None] <= np.arange(1, 11) * MOST_DEGREES / 10
            print(f"{name}, PoseLib{' + PROSAC' if prosac else ''} to 1000: mAA@{MOST_DEGREES}deg {accurate.mean():.3f}, "
                  f"median {np.median(errors):.4f} deg, {np.median(times):.1f} ms")


if __name__ == "__main__":
    main()
