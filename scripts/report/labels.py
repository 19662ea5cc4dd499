"""Writes labels/: one file per input of a user's own points, with all points and one column of labels per method (docs/points.md). Clouds read
from PLY or HDF5 become coloured PLY files, others CSV."""
import os
import re

import numpy as np
import pandas as pd

import files
from pictures import INLIER, OUTLIER, structure_colour

TEXT_FILES = (".csv", ".txt", ".xyz", ".dat", ".tsv")


def labels_of(estimates, i, status, points, limit):
    """Returns 0 for outliers, 1 for inliers, or the number of the structure. Points left out by max_points get the nearest model within the
    estimate's inlier threshold, or within `limit` if it has none."""
    if status != "ok":
        return np.zeros(len(points), np.int32)
    rows, own, models = estimates.rows(i), estimates.labels(i), estimates.structures(i)
    if not len(own):
        own = estimates.mask(i, int(estimates.value("points", i)))
    if not len(rows):
        return own.astype(np.int32)
    models = models if len(models) else [estimates.model(i)]
    threshold = estimates.value("inlier_threshold", i)
    distances = np.stack([np.abs(points @ model[:-1] + model[-1]) for model in models], axis=1)
    distances = np.where(np.isnan(distances), np.inf, distances)
    near = distances.min(axis=1) <= (threshold if threshold is not None and np.isfinite(threshold) else limit)
    labels = np.where(near, distances.shape[1] - distances[:, ::-1].argmin(axis=1), 0).astype(np.int32)
    labels[rows] = own
    return labels


def labels_ply(points, methods, shown, used):
    """Returns a binary PLY file with the colours of the method `shown`."""
    names = ["label_" + re.sub("[^A-Za-z0-9]", "_", name) for name in methods]
    colours = [INLIER] if methods[shown].max(initial=0) <= 1 else [structure_colour(k) for k in range(1, 7)]
    palette = np.array([[int(colour[k:k + 2], 16) for k in (1, 3, 5)] for colour in (OUTLIER, *colours)], np.uint8)
    own = methods[shown]
    fields = [(axis, "<f8") for axis in "xyz"] + [(colour, "u1") for colour in ("red", "green", "blue")]
    fields += [(name, "<i4") for name in names] + ([("used", "u1")] if used is not None else [])
    table = np.zeros(len(points), fields)
    for axis, values in zip("xyz", points.T):
        table[axis] = values
    for colour, values in zip(("red", "green", "blue"), palette[np.where(own > 0, (own - 1) % len(colours) + 1, 0)].T):
        table[colour] = values
    for name, values in zip(names, methods.values()):
        table[name] = values
    comments = [f"diffsac_eval: colours are those of {names[list(methods).index(shown)]}; labels: 0 an outlier, 1 an inlier, or the number of its structure"]
    if used is not None:
        table["used"] = used
        comments.append("used: 1 for points that the estimators were given")
    kinds = {"f8": "double", "i4": "int", "u1": "uchar"}
    header = ["ply", "format binary_little_endian 1.0", *("comment " + one for one in comments), f"element vertex {len(points)}",
              *(f"property {kinds[kind[-2:]]} {name}" for name, kind in fields), "end_header\n"]
    return "\n".join(header).encode() + table.tobytes()


def labels_csv(points, methods, used):
    table = pd.DataFrame({**dict(zip("xyz", points.T)), **methods, **({} if used is None else {"used": used.astype(int)})})
    return table.to_csv(index=False, lineterminator="\n", float_format="%.9g", na_rep="nan")


def _write_example(run, number, folder, names):
    facts = run.examples.json["examples"][number]
    condition, index, points = facts["condition"], facts["index"], run.examples.source(number)
    methods, used, shown = {}, None, None
    for m, method in enumerate(run.facts["methods"]):
        estimates, line = run.estimates.get((condition, m)), run.line_of(condition, m, index)
        if line is None or estimates is None or index not in estimates.at:
            continue
        rows = estimates.rows(estimates.at[index])
        if len(rows):
            used = np.isin(np.arange(len(points)), rows)
        methods[method["name"]] = labels_of(estimates, estimates.at[index], line["status"], points, facts["inlier_threshold"])
        shown = method["name"] if shown is None and method["type"] != "oracle" else shown
    if not methods:
        return
    text = os.path.splitext(facts["path"])[1].lower() in TEXT_FILES or points.shape[1] != 3
    extension = ".csv" if text else ".ply"
    prefix = run.facts["conditions"][condition]["name"] + "_" if len(run.facts["conditions"]) > 1 else ""
    stem = re.sub(r"[^A-Za-z0-9._+=-]", "_", prefix + facts["id"]).removesuffix(extension)
    name, again = stem + extension, 2
    while name in names:  # Each once, whatever the inputs are called.
        name, again = f"{stem}_{again}{extension}", again + 1
    names.add(name)
    os.makedirs(folder, exist_ok=True)
    content = labels_csv(points, methods, used) if text else labels_ply(points, methods, shown or next(iter(methods)), used)
    files.write_whole(os.path.join(folder, name), content)


def write_labels(run):
    """Writes the files and removes those of an earlier run."""
    folder, names = run.path("labels"), set()
    for name in os.listdir(folder) if os.path.isdir(folder) else ():
        if name.endswith((".csv", ".ply")):
            files.remove(os.path.join(folder, name))
    for number, facts in enumerate(run.examples.json["examples"] if run.examples else ()):
        if facts.get("path"):
            _write_example(run, number, folder, names)
    if os.path.isdir(folder) and not os.listdir(folder):
        os.rmdir(folder)
