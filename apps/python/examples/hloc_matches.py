"""Relative poses of all pairs of hloc's files of features and matches; needs h5py.

    python hloc_matches.py features.h5 matches.h5 FOCAL CX,CY

All images are of one camera, in pixels, the centre of the first one at (0, 0) as in hloc's files.
"""

import sys

import h5py
import numpy as np

import diffsac


def pairs_of(matches: h5py.File):
    """Groups that hold a pair: of the names of two images, with '-' for '/'."""
    found = []
    matches.visititems(lambda name, group: found.append((name, group)) if "matches0" in group else None)
    return found


def main(features_path: str, matches_path: str, focal: str, center: str) -> None:
    cx, cy = (float(value) for value in center.split(","))
    K = np.array([[float(focal), 0, cx], [0, float(focal), cy], [0, 0, 1]])
    with h5py.File(features_path) as features, h5py.File(matches_path) as matches:
        keypoints = {}
        features.visititems(
            lambda name, group: keypoints.update({name.replace("/", "-"): group["keypoints"][:]})
            if isinstance(group, h5py.Group) and "keypoints" in group
            else None
        )
        for pair, group in pairs_of(matches):
            first, second = pair.split("/")
            partner = group["matches0"][:]
            rows = np.flatnonzero(partner >= 0)
            x1, x2 = keypoints[first][rows], keypoints[second][partner[rows]]
            estimate = diffsac.estimate_essential(x1, x2, K, K)
            print(f"{first} {second}: {len(rows)} matches, {estimate.status.value}", end="")
            if estimate.ok and estimate.pose is not None:
                print(f", {estimate.num_inliers} inliers, t = {np.round(estimate.pose.translation, 4)}", end="")
                print(f" ({estimate.verdict.value})", end="")
            print()


if __name__ == "__main__":
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    main(*sys.argv[1:])
