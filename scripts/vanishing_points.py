#!/usr/bin/env python3
"""What diffsac.estimate_vanishing_points finds in images whose vanishing points people labelled.

    python3 scripts/vanishing_points.py runs/segments/nyu_vp_val/segments.h5 [FILE...] [--least 0.2 0.35 0.5] [--without-K]

A line for each least value at which a list may end:
  found      vanishing points in a list, and labelled ones in an image, in the mean
  precision  share of those found that are within 10 degrees of a labelled one, each of one of its own
  recall     share of the labelled ones that such a one was found for
  horizon    distance of the horizon from the true one at the worse side of the image, in per cent of its height: median, and
             share of the images that have one. True is that of the labelled direction within 30 degrees of the vertical.
  focal      --without-K: relative error, median in per cent; share of the images in which it is determined; share of these
             within one of its standard deviations
FILE is of `diffsac_vanish --estimates`. Needs h5py, scipy and the module diffsac (docs/python.md).
"""

import argparse

import h5py
import numpy as np
import scipy.optimize

import diffsac

WITHIN_DEG = 10.0
UPRIGHT_COSINE = np.cos(np.radians(30.0))


class Image:
    def __init__(self, group):
        self.segments = group["segments"][()]
        self.size = tuple(int(side) for side in group["size"][()])
        self.K = group["K"][()]
        self.directions = self.space(group["vanishing_points"][()])

    def space(self, points):
        directions = points @ np.linalg.inv(self.K).T
        return directions / np.linalg.norm(directions, axis=1, keepdims=True)

    def true_horizon(self):
        vertical = self.directions[np.abs(self.directions[:, 1]).argmax()]
        return np.linalg.inv(self.K).T @ vertical if abs(vertical[1]) > UPRIGHT_COSINE else None


def read_images(path):
    with h5py.File(path) as file:
        return [Image(group) for group in file.values() if "vanishing_points" in group]


def matched(found, true):
    """How many of both are within WITHIN_DEG of each other, each with one partner."""
    if not len(found):
        return 0
    degrees = np.degrees(np.arccos(np.clip(np.abs(found @ true.T), 0.0, 1.0)))
    near = (degrees <= WITHIN_DEG).astype(float)
    rows, columns = scipy.optimize.linear_sum_assignment(-near)
    return int(near[rows, columns].sum())


def rows_at_sides(line, width):
    return np.array([-(line[0] * x + line[2]) / line[1] for x in (0.0, width)])


class Totals:
    def __init__(self):
        self.images = self.found = self.true = self.matched = self.with_horizon = 0
        self.horizon, self.focal, self.within_sigma = [], [], []

    def add(self, image, estimate):
        self.images += 1
        self.found += len(estimate.points)
        self.true += len(image.directions)
        self.matched += matched(image.space(estimate.points), image.directions)
        line = image.true_horizon()
        if line is not None:
            self.with_horizon += 1
            if estimate.horizon:
                off = rows_at_sides(estimate.horizon.line, image.size[0]) - rows_at_sides(line, image.size[0])
                self.horizon.append(100.0 * np.abs(off).max() / image.size[1])
        if estimate.focal:
            off = np.log(estimate.focal.focal_px / image.K[0, 0])
            self.focal.append(abs(off))
            self.within_sigma.append(abs(off) <= estimate.focal.log_sigma)

    def text(self, least):
        precision, recall = self.matched / max(1, self.found), self.matched / self.true
        text = f"{least:5.2f}  found {self.found / self.images:.2f} of {self.true / self.images:.2f}"
        text += f"  precision {precision:.3f} recall {recall:.3f} F1 {2 * precision * recall / (precision + recall):.3f}"
        if self.horizon:
            text += f"  horizon {np.median(self.horizon):.2f} % in {len(self.horizon) / self.with_horizon:.2f}"
        if self.focal:
            text += f"  focal {100 * np.median(self.focal):.1f} % in {len(self.focal) / self.images:.2f},"
            text += f" {np.mean(self.within_sigma):.2f} within sigma"
        return text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+")
    parser.add_argument("--least", nargs="+", type=float, default=[0.35])
    parser.add_argument("--without-K", action="store_true")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    images = [image for path in arguments.files for image in read_images(path)]
    for least in arguments.least:
        totals = Totals()
        for image in images:
            K = None if arguments.without_K else image.K
            totals.add(
                image,
                diffsac.estimate_vanishing_points(
                    image.segments, K, size=image.size, least_value=least, seed=arguments.seed
                ),
            )
        print(totals.text(least))


if __name__ == "__main__":
    main()
