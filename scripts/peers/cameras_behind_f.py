#!/usr/bin/env python3
"""What a camera behind a fundamental matrix is worth: estimate_fundamental with cameras="unknown" and "photographs" on folders of pairs,
by the error of docs/metrics.md, with paired 95 % intervals over pairs; and where F is still lost, more than 10 degrees off, by scene and
cause. Not part of the build; needs the module and h5py, OpenCV, pandas.

  python scripts/peers/cameras_behind_f.py --scenes SCENE... [--seeds 3] [--pairs 25] [--crop 0.2]

SCENE is a folder of diffsac_prepare. --crop cuts that share from the left of both images. The first cause that holds is counted: `few`, below
20 right matches (2 px); `plane`, a homography has nine tenths of them (3 px); `far`, that of a turn has; `cluster`, they span less than a
sixth of an image's diagonal (four standard deviations); `repeats`, the F found has as many inliers as the true one; `missed`, it has fewer.
"""
import argparse

import cv2
import diffsac
import h5py
import numpy as np
import pandas as pd

from peer_pairs import accuracy, errors_of_matrix, essential_matrix, read_pair, sampson, select

STRATA = [0, 0.1, 0.2, 0.3, 1]


def cropped(pair, share):
    cut = np.floor(np.array([share * pair.sizes[0], 0, share * pair.sizes[2], 0]))
    kept = select(pair, ((pair.matches - cut)[:, [0, 2]] >= 0).all(1))
    kept.matches = kept.matches - cut
    kept.k1, kept.k2 = pair.k1.copy(), pair.k2.copy()
    kept.k1[0, 2] -= cut[0]
    kept.k2[0, 2] -= cut[2]
    kept.sizes = tuple(pair.sizes - cut)
    return kept


def explained(homography, matches):
    mapped = cv2.perspectiveTransform(matches[None, :, :2], homography)[0]
    return (np.linalg.norm(mapped - matches[:, 2:], axis=1) < 3).mean()


def cause(pair, right, found):
    matches = np.ascontiguousarray(pair.matches[right])
    if len(matches) < 20:
        return "few"
    plane = cv2.findHomography(matches[:, :2], matches[:, 2:], cv2.RANSAC, 3)[0]
    if plane is not None and explained(plane, matches) >= 0.9:
        return "far" if explained(pair.k2 @ pair.turn @ np.linalg.inv(pair.k1), matches) >= 0.9 else "plane"
    if any(4 * side.std(0).max() < np.hypot(*size) / 6 for side, size in ((matches[:, :2], pair.sizes[:2]), (matches[:, 2:], pair.sizes[2:]))):
        return "cluster"
    return "missed" if not found.ok or (sampson(found.model, pair.matches) < 4).sum() < len(matches) else "repeats"


def line(name, rows):
    accuracies = rows.groupby("pair").apply(lambda r: accuracy(r.photographs) - accuracy(r.unknown)).to_numpy()
    rng = np.random.default_rng(0)
    means = [rng.choice(accuracies, len(accuracies)).mean() for _ in range(1000)]
    print(f"{name:12} {len(accuracies):4} pairs  unknown {accuracy(rows.unknown):.3f}  photographs {accuracy(rows.photographs):.3f}"
          f"  gain {accuracies.mean():+.3f} [{np.percentile(means, 2.5):+.3f}, {np.percentile(means, 97.5):+.3f}]")


def rows_of(scene, name, options):
    pair = cropped(read_pair(scene, name), options.crop)
    fundamental = np.linalg.inv(pair.k2).T @ essential_matrix(pair.turn, pair.shift) @ np.linalg.inv(pair.k1)
    right = sampson(fundamental, pair.matches) < 4
    for seed in range(options.seeds):
        row = {"pair": f"{scene}/{name}", "scene": scene.rstrip("/").split("/")[-1], "right": right.mean()}
        for cameras in ("unknown", "photographs"):
            found = diffsac.estimate_fundamental(pair.matches[:, :2], pair.matches[:, 2:], pair.ratios, cameras=cameras, seed=seed,
                                                 size1=tuple(map(int, pair.sizes[:2])), size2=tuple(map(int, pair.sizes[2:])))
            row[cameras] = max(errors_of_matrix(found.model if found.ok else None, pair, "fundamental"))
            row[f"{cameras}, cause"] = cause(pair, right, found) if row[cameras] > 10 else ""
        yield row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", nargs="+", required=True)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--pairs", type=int, default=25, help="at most so many of a scene, evenly")
    parser.add_argument("--crop", type=float, default=0.0)
    options = parser.parse_args()
    rows = []
    for scene in options.scenes:
        with h5py.File(f"{scene}/matches.h5") as file:
            names = list(file)
        for name in names[:: max(1, len(names) // options.pairs)][: options.pairs]:
            rows.extend(rows_of(scene, name, options))
    rows = pd.DataFrame(rows)
    line("all", rows)
    for stratum, part in rows.groupby(pd.cut(rows.right, STRATA)):
        if len(part):
            line(f"{stratum} right", part)
    lost = {cameras: pd.crosstab(rows.scene, rows[f"{cameras}, cause"]).drop(columns="", errors="ignore") for cameras in ("unknown", "photographs")}
    print(f"\nestimates more than 10 degrees off, of {len(rows)}, `unknown` > `photographs`, by scene and cause")
    print((lost["unknown"].fillna(0).astype(int).astype(str) + " > " +
           lost["photographs"].reindex_like(lost["unknown"]).fillna(0).astype(int).astype(str)).replace("0 > 0", ".").to_string())
    print(lost["unknown"].sum().to_dict(), lost["photographs"].sum().to_dict())


if __name__ == "__main__":
    main()
