#!/usr/bin/env python3
"""What the covariances of pairs' rotations are worth as weights of rotation averaging, beside inlier counts and beside none.

  PYTHON scripts/peers/rotation_averaging.py --run RUN --tuning TUNING --scenes SCENE...

PYTHON has numpy, scipy, h5py and OpenCV. RUN and TUNING are folders that diffsac_eval wrote (estimates.h5, one method and condition), of
left-out and of tuning scenes; SCENE the
folders of pairs that they read, whose R.h5 has the true rotations. Folders NAME_step_K are one scene. Pairs that may be chance are left
out, alike for all. The rotations of the largest connected part are those of least robust cost (Cauchy) of log(Rj Ri' Rij') over the
pairs, from the tree of most inliers; a pair's weight is 1, its number of inliers over their mean, or the inverse of its covariance plus
floor^2. The cost's scale and the floor are those of least error on TUNING for each kind. Errors: degrees of each image's rotation after
the two sets are aligned (L1); means over images, then scenes, and the interval of 95 % of the difference to weights alike by bootstrap
over scenes and their images.
"""
import argparse
import os
import re

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[threads] = "1"
import collections

import h5py
import numpy as np
from scipy.spatial.transform import Rotation

from peer_pairs import fail

FEWEST_IMAGES = 5
SCALES = {"alike": [0.05, 0.1, 0.2, 0.5, 1, 2], "inliers": [0.05, 0.1, 0.2, 0.5, 1, 2], "covariance": [0.3, 1, 3, 10, 30],
          "covariance + floor": [0.5, 1, 2, 4]}
FLOORS = {"covariance": [0.0], "covariance + floor": [0.05, 0.1, 0.2, 0.5]}
Pair = collections.namedtuple("Pair", "first second turn covariance inliers")


def scenes_of(run, folders):
    """Of each scene its pairs and its true rotations, by the images' names."""
    pairs, truth = collections.defaultdict(list), collections.defaultdict(dict)
    with h5py.File(os.path.join(run, "estimates.h5")) as file:
        groups = [group for method in file.values() for group in method.values()]
        group = groups[0] if len(groups) == 1 else fail(f"{run}: expected one method and one condition")
        read = {name: group[name][()] for name in ("id", "pose", "pose_covariance", "log10_nfa", "inliers_end")}
    counts = np.diff(read["inliers_end"], prepend=0)
    for row, name in enumerate(read["id"]):
        folder, pair = name.decode().split("/")
        turn, covariance = read["pose"][row].reshape(3, 4)[:, :3], read["pose_covariance"][row].reshape(6, 6)[:3, :3]
        if np.isfinite(turn).all() and np.isfinite(covariance).all() and read["log10_nfa"][row] <= 0:
            scene = re.sub(r"_step_\d+$", "", folder)
            pairs[scene].append(Pair(*pair.split("-"), turn, covariance, counts[row]))
            if folder in folders:
                with h5py.File(os.path.join(folders[folder], "R.h5")) as file:
                    truth[scene].update({image: file[image][()].reshape(3, 3) for image in pair.split("-")})
    missing = set(pairs) - set(truth)
    return {scene: (pairs[scene], truth[scene]) for scene in sorted(pairs)} if not missing else fail(f"no --scenes of {sorted(missing)}")


def connected(pairs):
    """Rotations along the tree of most inliers, of the largest part that pairs connect."""
    neighbours, best = collections.defaultdict(list), {}
    for pair in sorted(pairs, key=lambda pair: -pair.inliers):
        neighbours[pair.first].append((pair.inliers, pair.second, pair.turn))
        neighbours[pair.second].append((pair.inliers, pair.first, pair.turn.T))
    for root in sorted(neighbours):
        if root in best:
            continue
        found = {root: np.eye(3)}
        while True:
            edges = [(count, image, other, turn) for image in found for count, other, turn in neighbours[image] if other not in found]
            if not edges:
                break
            count, image, other, turn = max(edges, key=lambda edge: edge[:3])
            found[other] = turn @ found[image]
        best = found if len(found) > len(best) else best
    return best


def averaged(pairs, start, weights, scale, rounds=60):
    """Iteratively reweighted least squares on SO(3); the first image stays."""
    images = {image: i for i, image in enumerate(start)}
    turns = np.array(list(start.values()))
    first, second = (np.array([images[getattr(pair, side)] for pair in pairs]) for side in ("first", "second"))
    measured = np.array([pair.turn for pair in pairs])
    for _ in range(rounds):
        between = turns[second] @ turns[first].transpose(0, 2, 1)
        residual = Rotation.from_matrix(between @ measured.transpose(0, 2, 1)).as_rotvec()
        squares = np.einsum("ni,nij,nj->n", residual, weights, residual)
        robust = weights / (1 + squares / scale**2)[:, None, None]
        system, side = np.zeros((len(images), len(images), 3, 3)), np.zeros((len(images), 3))
        for i, j, step, weight, r in zip(first, second, between, robust, residual):
            system[i, i] += step.T @ weight @ step
            system[j, j] += weight
            system[i, j] -= step.T @ weight
            system[j, i] -= weight @ step
            side[i] += step.T @ weight @ r
            side[j] -= weight @ r
        matrix = system.transpose(0, 2, 1, 3).reshape(3 * len(images), -1)[3:, 3:]
        move = np.linalg.lstsq(matrix, side.reshape(-1)[3:], rcond=1e-12)[0].reshape(-1, 3)
        turns[1:] = Rotation.from_rotvec(move).as_matrix() @ turns[1:]
        if np.abs(move).max() < 1e-9:
            break
    return dict(zip(start, turns))


def errors(found, truth):
    """Degrees of each image, aligned by the rotation of least sum of angles."""
    steps = Rotation.from_matrix(np.array([found[image].T @ truth[image] for image in found]))
    mean = steps.mean()
    for _ in range(50):
        angles = (mean.inv() * steps).magnitude()
        mean = steps.mean(1 / np.maximum(angles, 1e-6))
    return np.degrees((mean.inv() * steps).magnitude())


def weights_of(kind, pairs, floor):
    degree = np.radians(1)
    if kind == "alike":
        return np.tile(np.eye(3) / degree**2, (len(pairs), 1, 1))
    if kind == "inliers":
        counts = np.array([pair.inliers for pair in pairs], float)
        return (counts / counts.mean())[:, None, None] * np.eye(3) / degree**2
    return np.array([np.linalg.inv(pair.covariance + (floor * degree)**2 * np.eye(3)) for pair in pairs])


def graphs_of(run, folders):
    graphs = {}
    for scene, (pairs, truth) in scenes_of(run, folders).items():
        start = connected(pairs)
        kept = [pair for pair in pairs if pair.first in start]
        if len(start) >= FEWEST_IMAGES and len(kept) > len(start):   # else nothing is averaged
            graphs[scene] = kept, start, truth
    return graphs or fail(f"{run}: no scene with more pairs than images")


def errors_of(graphs, kind, floor, scale):
    return {scene: errors(averaged(pairs, start, weights_of(kind, pairs, floor), scale), truth) for scene, (pairs, start, truth) in graphs.items()}


def mean_of(by_scene):
    return np.mean([values.mean() for values in by_scene.values()])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--run", required=True)
    parser.add_argument("--tuning", required=True)
    parser.add_argument("--scenes", nargs="+", required=True)
    arguments = parser.parse_args()
    folders = {os.path.basename(os.path.normpath(folder)): folder for folder in arguments.scenes}
    graphs, tuning = (graphs_of(run, folders) for run in (arguments.run, arguments.tuning))
    for scene, (pairs, start, _) in graphs.items():
        print(f"{scene}: {len(start)} images, {len(pairs)} pairs")
    random, base = np.random.default_rng(1), None
    tree = {scene: errors(start, truth) for scene, (_, start, truth) in graphs.items()}
    print(f"tree of most inliers: {mean_of(tree):.3f} deg; " + ", ".join(f"{scene} {values.mean():.3f}" for scene, values in tree.items()))
    for kind, scales in SCALES.items():
        tried = [(mean_of(errors_of(tuning, kind, floor, scale)), floor, scale) for floor in FLOORS.get(kind, [0.0]) for scale in scales]
        least, floor, scale = min(tried)
        found = errors_of(graphs, kind, floor, scale)
        base = found if base is None else base
        moved = [found[scene] - base[scene] for scene in found]
        draws = [np.mean([random.choice(moved[i], len(moved[i])).mean() for i in random.integers(0, len(moved), len(moved))])
                 for _ in range(2000)]
        low, high = np.percentile(draws, (2.5, 97.5))
        print(f"{kind} (scale {scale:g}, floor {floor:g}; {least:.3f} deg on tuning scenes): {mean_of(found):.3f} deg, "
              f"{mean_of(found) - mean_of(base):+.3f} [{low:+.3f}, {high:+.3f}]; "
              + ", ".join(f"{scene} {values.mean():.3f}" for scene, values in found.items()), flush=True)


if __name__ == "__main__":
    main()
