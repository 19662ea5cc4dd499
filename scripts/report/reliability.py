"""Reliability curves: share of inliers by predicted probability, from the sums in run.json."""
import math

import numpy as np

BINS = 10
RATIO = "by the matching ratio"  # The label of these curves, which stand beside each row's.


def curves_of(run):
    """Returns (label, condition, scene -> bins x (points, sum of probabilities, inliers)). Methods with the same network appear once, the matching
    ratio once per condition, last."""
    distinct = []
    for curve in sorted(run.facts["reliability"], key=lambda curve: (curve["condition"], curve["label"] == RATIO)):
        scenes = {}
        for scene, bins in curve["scenes"].items():
            group = run.group_of(scene)
            scenes[group] = scenes.get(group, 0) + np.array(bins, float)
        label, condition, scenes = curve["label"], curve["condition"], dict(sorted(scenes.items()))
        if not any(of == condition and (label == other == RATIO or same(scenes, known)) for other, of, known in distinct):
            distinct.append((label, condition, scenes))
    return distinct


def same(scenes, others):
    return list(scenes) == list(others) and all((bins == others[scene]).all() for scene, bins in scenes.items())


def calibration_error(bins):
    """Expected calibration error: |share of inliers - mean probability|, weighted by points (Naeini, Cooper, Hauskrecht, AAAI 2015)."""
    points = bins[:, 0].sum()
    return np.abs(bins[:, 2] - bins[:, 1]).sum() / points if points else math.nan


def table_of(run):
    """Rows of reliability.csv: bins of each scene, their unweighted mean over scenes, calibration error of each curve."""
    rows = []
    for label, condition, scenes in curves_of(run):
        names = [label, run.facts["conditions"][condition]["name"]]
        for b in range(BINS):
            shares = {scene: bins[b] for scene, bins in scenes.items() if bins[b][0] > 0}
            place = [f"{0.1 * b:.1f}", f"{0.1 * (b + 1):.1f}"]
            told = [(scene, points, predicted / points, inliers / points) for scene, (points, predicted, inliers) in shares.items()]
            if told:
                told.append(("mean", sum(one[1] for one in told), *(sum(one[k] for one in told) / len(told) for k in (2, 3))))
            rows += [[*names, scene, *place, f"{points:.0f}", f"{predicted:.4f}", f"{inliers:.4f}"] for scene, points, predicted, inliers in told]
        error = sum(calibration_error(bins) for bins in scenes.values()) / len(scenes)
        rows.append([*names, "calibration_error", "", "", "", f"{error:.4f}", ""])
    return rows
