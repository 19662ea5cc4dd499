#!/usr/bin/env python3
"""What cameras behind a fundamental matrix are worth: estimate_fundamental with cameras="unknown" and "photographs" on folders of pairs,
by the error of docs/metrics.md, with paired 95 % intervals over pairs. Not part of the build; needs the module and h5py, OpenCV, pandas.

  python scripts/peers/cameras_behind_f.py --scenes SCENE... [--seeds 3] [--pairs 25] [--crop 0.2]

SCENE is a folder of diffsac_prepare. --crop cuts that share from the left of both images.
"""
import argparse

import diffsac
import h5py
import numpy as np
import pandas as pd

from peer_pairs import accuracy, errors_of_matrix, essential_matrix, read_pair, sampson, select

STRATA = [0, 0.1, 0.2, 0.3, 1]


def cropped(pair, share):
    width1, height1, width2, height2 = pair.sizes
    cut = np.array([share * width1, 0, share * width2, 0])
    kept = select(pair, ((pair.matches - cut)[:, [0, 2]] >= 0).all(1))
    kept.matches = kept.matches - cut
    kept.k1, kept.k2 = pair.k1.copy(), pair.k2.copy()
    kept.k1[0, 2] -= cut[0]
    kept.k2[0, 2] -= cut[2]
    kept.sizes = (width1 - cut[0], height1, width2 - cut[2], height2)
    return kept


def right_share(pair, px=2.0):
    fundamental = np.linalg.inv(pair.k2).T @ essential_matrix(pair.turn, pair.shift) @ np.linalg.inv(pair.k1)
    return (sampson(fundamental, pair.matches) < px**2).mean()


def error(pair, seed, cameras):
    sizes = [int(round(side)) for side in pair.sizes]
    found = diffsac.estimate_fundamental(pair.matches[:, :2], pair.matches[:, 2:], pair.ratios, size1=tuple(sizes[:2]),
                                         size2=tuple(sizes[2:]), cameras=cameras, seed=seed)
    return max(errors_of_matrix(found.model if found.ok else None, pair, "fundamental"))


def line(name, rows):
    accuracies = rows.groupby("pair").apply(lambda r: accuracy(r.photographs) - accuracy(r.unknown)).to_numpy()
    rng = np.random.default_rng(0)
    means = [rng.choice(accuracies, len(accuracies)).mean() for _ in range(1000)]
    print(f"{name:12} {len(accuracies):4} pairs  unknown {accuracy(rows.unknown):.3f}  photographs {accuracy(rows.photographs):.3f}"
          f"  gain {accuracies.mean():+.3f} [{np.percentile(means, 2.5):+.3f}, {np.percentile(means, 97.5):+.3f}]")


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
            pair = cropped(read_pair(scene, name), options.crop)
            for seed in range(options.seeds):
                errors = {cameras: error(pair, seed, cameras) for cameras in ("unknown", "photographs")}
                rows.append({"pair": f"{scene}/{name}", "right": right_share(pair), **errors})
    rows = pd.DataFrame(rows)
    line("all", rows)
    for stratum, part in rows.groupby(pd.cut(rows.right, STRATA)):
        if len(part):
            line(f"{stratum} right", part)


if __name__ == "__main__":
    main()
