#!/usr/bin/env python3
"""CONSAC's official weights (fkluger/consac, revision e0a4f69) on AdelaideRMF's homographies, beside our rows.

CONSAC's own evaluation script runs as it is, with its defaults (100 x 100 hypotheses, six models at most, ten EM
iterations), on files made of the pairs that our table reads: NAME_pts.txt with rows `x1 y1 1 x2 y2 1 label`, NAMEA.png
and NAMEB.png. They hold no matching scores; its network reads none. Printed for each pair, as means over the runs: the
misclassification error by its own matching (intersection over union, with the outliers as one more structure), and that
of docs/metrics.md of the labels before that matching.

    python3 scripts/peers/multi_homography.py CONSAC_FOLDER DATA_FOLDER [--runs 5] [--uniform]

needs numpy, scipy, pillow, matplotlib, torch. The repository has no licence file: nothing of it is kept here.
"""

import argparse
import os
import pathlib
import runpy
import sys
import tempfile
import time

import numpy as np
import scipy.io
import scipy.optimize
from PIL import Image


def misclassification(true, found):
    """Per cent of wrong points under the one-to-one matching of structures that leaves the fewest."""
    right = np.sum((true == 0) & (found == 0))
    common = np.array([[np.sum((true == t) & (found == f)) for f in range(1, found.max() + 1)]
                       for t in range(1, true.max() + 1)])
    if common.size:
        rows, columns = scipy.optimize.linear_sum_assignment(-common)
        right += common[rows, columns].sum()
    return 100.0 * (1.0 - right / len(true))


def write_pairs(data, folder):
    names = sorted(path.name[: -len("_pts.txt")] for path in pathlib.Path(data).glob("*_pts.txt"))
    if not names:
        sys.exit(f"{data}: no *_pts.txt")
    for name in names:
        rows = np.loadtxt(f"{data}/{name}_pts.txt")
        images = [np.asarray(Image.open(f"{data}/{name}{side}.png").convert("RGB")) for side in "AB"]
        scipy.io.savemat(f"{folder}/{name}.mat", {"data": rows[:, :6].T, "label": rows[:, 6].astype(int),
                                                  "score": np.zeros(len(rows)), "img1": images[0], "img2": images[1]})
    return names


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("consac")
    parser.add_argument("data")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--uniform", action="store_true", help="sequential RANSAC by the same program")
    options = parser.parse_args()
    folder = tempfile.mkdtemp()
    names = write_pairs(os.path.abspath(options.data), folder)
    os.chdir(options.consac)
    sys.path.insert(0, os.getcwd())
    if not hasattr(np, "int"):
        np.int = int  # the program is of a time when numpy had it

    from datasets.homographies import adelaide
    from util import evaluation

    adelaide.AdelaideRMF.homography_sequences = [f"{name}.mat" for name in names]
    own = []
    theirs_of = evaluation.calc_labels_and_misclassification_error

    def measured(data, count, models, threshold, labels):
        matched, error = theirs_of(data, count, models, threshold, labels)
        # What it returns is renamed by its matching (-1 where a structure has no partner): ours needs the labels before,
        # which it makes within a hundred times the threshold.
        found = evaluation.calc_labels(data, count, models, 100 * threshold)
        own.append((100.0 * error, misclassification(labels.numpy().astype(int), found.astype(int))))
        return matched, error

    evaluation.calc_labels_and_misclassification_error = measured
    sys.argv = ["evaluate_homography.py", "--dataset_path", folder, "--runcount", str(options.runs), "--cpu"]
    if options.uniform:
        sys.argv.append("--uniform")
    start = time.process_time()
    program = runpy.run_path("evaluate_homography.py", run_name="__main__")
    seconds = time.process_time() - start

    runs = np.array(own).reshape(len(names), options.runs, 2)
    errors = runs.mean(axis=1)
    print("\n| pair | by CONSAC's matching | by docs/metrics.md |\n|---|---|---|")
    for name, (theirs, ours) in zip(names, errors):
        print(f"| {name} | {theirs:.2f} | {ours:.2f} |")
    print("| mean | {:.2f} | {:.2f} |".format(*errors.mean(axis=0)))
    print("| median | {:.2f} | {:.2f} |".format(*np.median(errors, axis=0)))
    for which, label in enumerate(("CONSAC's matching", "docs/metrics.md")):
        means, medians = runs[:, :, which].mean(axis=0), np.median(runs[:, :, which], axis=0)
        print(f"\nSingle runs by {label}: mean {means.min():.2f} to {means.max():.2f}, "
              f"median {medians.min():.2f} to {medians.max():.2f}")
    print(f"A pair and run: {1000 * program['elapsed_time_total'] / len(own):.0f} ms by its own clock, "
          f"{1000 * seconds / len(own):.0f} ms of processor time in all")


if __name__ == "__main__":
    main()
