#!/usr/bin/env python3
"""One unknown focal length shared by both images, on the pairs of a run of diffsac_eval and by the same error (docs/metrics.md): PoseLib's
estimator, which is told nothing of the cameras but the images' centre, and what COLMAP makes of two views whose focal length it guesses
(task `colmap`: F, decomposed with its guess; its own defaults, 4 px). Essential and fundamental matrices: two_view.py. Not part of the
build; scripts/peers/environment.sh makes the environment of it.

  .deps/peers/bin/python scripts/peers/poselib_pairs.py --run RUN --scenes SCENE... [--tasks shared_focal,colmap] [--seeds 5]

RUN is a folder that diffsac_eval wrote, whose problems.csv says which pairs of which condition; SCENE a folder of pairs that it read.
Both are decomposed by what they estimate. PoseLib gets the matches in the order of their ratio (PROSAC).
"""
import argparse
import os

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[threads] = "1"
import collections
import time

import numpy as np
import poselib

from peer_pairs import FAILURE, accuracy, fail, pair_ids, pose_errors, read_pair, select

EPSILON_PX = 1.0
REGIMES = {"all matches": 1.0, "ratio 0.85": 0.85}
FEWEST_POINTS = 8


def shared_focal(pair, options):
    """Relative to the centre of each image: images of unlike size have the same focal length only where one was not cut."""
    centre = (np.array(pair.sizes) - 1) / 2
    moved = pair.matches - centre
    estimated, report = poselib.estimate_shared_focal_relative_pose(moved[:, :2], moved[:, 2:], np.zeros(2), options, {})
    focal = estimated.camera1.params[0]
    return estimated.pose.R, estimated.pose.t, report, 100 * abs(focal / pair.k1[0, 0] - 1)


def colmap(pair, options):
    import pycolmap
    sides, cameras = (pair.matches[:, :2] + 0.5, pair.matches[:, 2:] + 0.5), []   # COLMAP's pixels begin at the corner
    for width, height in (pair.sizes[:2], pair.sizes[2:]):
        guess = 1.2 * max(width, height)
        cameras.append(pycolmap.Camera(model="SIMPLE_PINHOLE", width=int(width), height=int(height),
                                       params=[guess, width / 2, height / 2], has_prior_focal_length=False))
    ours = pycolmap.TwoViewGeometryOptions()
    ours.ransac.random_seed = options["seed"]
    every = np.repeat(np.arange(len(pair.ratios), dtype=np.uint32)[:, None], 2, axis=1)
    geometry = pycolmap.estimate_two_view_geometry(cameras[0], sides[0], cameras[1], sides[1], every, ours)
    report = {"num_inliers": len(geometry.inlier_matches)}
    if not pycolmap.estimate_two_view_geometry_pose(cameras[0], sides[0], cameras[1], sides[1], geometry):
        return None, None, report, None
    pose = geometry.cam2_from_cam1
    error = 100 * abs(cameras[0].focal_length / pair.k1[0, 0] - 1)
    return pose.rotation.matrix(), pose.translation, report, error


ESTIMATORS = {"colmap": colmap, "shared_focal": shared_focal}


def measure(task, pair, iterations, seed):
    """Degrees of rotation and translation, per cent of the focal length, milliseconds."""
    options = {"max_epipolar_error": EPSILON_PX, "max_iterations": iterations, "min_iterations": min(100, iterations),
               "success_prob": 0.9999, "progressive_sampling": True, "seed": seed}
    if len(pair.ratios) < FEWEST_POINTS:
        return *FAILURE, np.nan, 0.0
    start = time.process_time()
    turn, shift, report, focal_error = ESTIMATORS[task](pair, options)
    ms = 1e3 * (time.process_time() - start)
    if turn is None or report["num_inliers"] < 5:
        return *FAILURE, np.nan, ms
    return *pose_errors(turn, shift, pair), np.nan if focal_error is None else focal_error, ms


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--run", required=True)
    parser.add_argument("--scenes", nargs="+", required=True)
    parser.add_argument("--tasks", default="shared_focal", help=f"some of {','.join(ESTIMATORS)}")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--iterations", type=int, default=1000)
    parser.add_argument("--groups", nargs="*", default=["kitti"], help="scenes whose names begin so count as one")
    arguments = parser.parse_args()
    folders = {os.path.basename(os.path.normpath(f)): f for f in arguments.scenes}
    print(f"PoseLib {poselib.__version__}, PROSAC, at most {arguments.iterations} iterations, {EPSILON_PX:g} px, {arguments.seeds} seeds")
    for condition, max_ratio in REGIMES.items():
        results = collections.defaultdict(list)
        for scene, name in pair_ids(arguments.run, condition):
            pair = read_pair(folders.get(scene) or fail(f"{scene}/{name}: no folder {scene} among --scenes"), name)
            pair = select(pair, np.argsort(pair.ratios, kind="stable")[:np.count_nonzero(pair.ratios <= max_ratio)])
            group = next((g for g in arguments.groups if scene.startswith(g)), scene)
            for task in arguments.tasks.split(","):
                for seed in range(arguments.seeds):
                    results[task, seed, group].append(measure(task, pair, arguments.iterations, seed))
        groups = sorted({group for _, _, group in results})
        for task in arguments.tasks.split(","):
            by_seed = [[np.array(results[task, seed, group]) for group in groups] for seed in range(arguments.seeds)]
            scores = np.array([[accuracy(rows[:, :2].max(1)) for rows in seed] for seed in by_seed])
            every = np.vstack([rows for seed in by_seed for rows in seed])
            focal = "" if np.isnan(every[:, 2]).all() else f", focal length off by {np.nanmedian(every[:, 2]):.1f} % (median)"
            print(f"{condition}, {task}: mAA@10deg {scores.mean():.3f} (seeds {scores.mean(1).min():.3f} to {scores.mean(1).max():.3f})"
                  f"{focal}, {np.median(every[:, 3]):.1f} ms; " + ", ".join(f"{g} {s:.3f}" for g, s in zip(groups, scores.mean(0))))


if __name__ == "__main__":
    main()
