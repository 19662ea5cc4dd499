"""Folders of pairs as diffsac_prepare writes them, for the scripts of this folder: matches, truth, and the sizes and angles of
keypoints, which the folders do not hold and which are found again in the images as lib/lab/images/detection.cpp found them."""
import csv
import glob
import os
import sys
import types

import cv2
import h5py
import numpy as np

FAILURE = (180.0, 90.0)      # degrees of rotation and translation, where there is no estimate
EPSILON_PX = 1.0             # of the inliers that choose a matrix's pose
IMAGE_ENDINGS = (".jpg", ".jpeg", ".png", ".ppm", ".pgm")


def fail(message):
    print(f"{os.path.basename(sys.argv[0])}: {message}", file=sys.stderr)
    sys.exit(2)


def existing(path, what):
    if path is None:
        fail(f"expected the path of a {what}")
    return path if os.path.exists(path) else fail(f"{path}: no such {what}")


def read_problems(run):
    path = run if run.endswith(".csv") else os.path.join(run, "problems.csv")
    with open(existing(path, "file; expected a folder that diffsac_eval wrote")) as file:
        return list(csv.DictReader(file))


def conditions_of(run):
    return {row["condition"] for row in read_problems(run)}


def pair_ids(run, condition):
    """(scene, pair) in the order of the run."""
    ids = dict.fromkeys(tuple(row["id"].split("/")) for row in read_problems(run) if row["condition"] == condition)
    return list(ids) or fail(f"{run}: no problems of condition '{condition}'")


def listed_pairs(pairs_file):
    """The pairs of images that FILE, or FILE#NAME below its line [NAME], names: by the names of their files."""
    path, _, part = pairs_file.partition("#")
    with open(path) as file:
        text = file.read()
    if part:
        text = ("\n" + text).split(f"\n[{part}]\n")[1].split("\n[")[0]
    return [tuple(os.path.basename(name) for name in line.split()[:2]) for line in text.splitlines() if line.split()]


def read_pair(folder, pair):
    """Matches x1 y1 x2 y2, ratios, K1, K2, sizes (w1 h1 w2 h2), the true motion R, t."""
    def of(name, key):
        with h5py.File(existing(f"{folder}/{name}.h5", "file")) as file:
            return file[key][()] if key in file else fail(f"{folder}/{name}.h5: no pair or image '{key}'")
    first, second = pair.split("-")
    rotations, shifts = [of("R", i) for i in (first, second)], [of("T", i).reshape(3) for i in (first, second)]
    turn = rotations[1] @ rotations[0].T
    height1, width1, height2, width2 = (float(v) for v in of("sizes", pair).reshape(-1))
    k1, k2 = of("K1_K2", pair).reshape(2, 3, 3)
    matches, scored = of("matches", pair).astype(float), os.path.exists(f"{folder}/match_scores.h5")
    ratios = of("match_scores" if scored else "match_conf", pair).reshape(-1).astype(float)
    if scored:
        ratios = 1.0 - ratios    # In the order of which estimators get matches.
    return types.SimpleNamespace(matches=matches, ratios=ratios, k1=k1, k2=k2, sizes=(width1, height1, width2, height2), turn=turn,
                                 shift=shifts[1] - turn @ shifts[0])


def select(pair, keep):
    chosen = types.SimpleNamespace(**vars(pair))
    chosen.matches, chosen.ratios = pair.matches[keep], pair.ratios[keep]
    if hasattr(pair, "affine"):
        chosen.affine = pair.affine[keep]
    return chosen


def normalized(pair):
    """Matches in coordinates of the cameras."""
    sides = [(pair.matches[:, 2 * i:2 * i + 2] - k[:2, 2]) / (k[0, 0], k[1, 1]) for i, k in enumerate((pair.k1, pair.k2))]
    return np.hstack(sides)


def write_pair_files(source, target, ratios, matches):
    os.makedirs(target, exist_ok=True)
    for name in os.listdir(source):
        changed = name in ("matches.h5", "match_conf.h5", "descriptors.h5", "thumbnails.h5")
        if not changed and not os.path.lexists(f"{target}/{name}"):
            os.symlink(os.path.abspath(f"{source}/{name}"), f"{target}/{name}")
    for name, values in (("match_conf", ratios), ("matches", matches)):
        with h5py.File(f"{target}/{name}.h5", "w") as file:
            for pair, value in values.items():
                file[pair] = value


def option_of_scene(folder, key):
    with open(existing(f"{folder}/prepared.txt", "file: keypoints can only be found again as diffsac_prepare found them")) as file:
        return float(dict(line.split()[:2] for line in file if len(line.split()) > 1)[key])


def detect(path, max_keypoints, max_size, contrast, cache={}):
    if path not in cache:
        image = cv2.imread(path, cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION)
        scale = max(1.0, max(image.shape) / max_size) if max_size else 1.0
        if scale > 1.0:
            image = cv2.resize(image, (round(image.shape[1] / scale), round(image.shape[0] / scale)), interpolation=cv2.INTER_AREA)
        points, rows = cv2.SIFT_create(int(max_keypoints), 3, contrast).detectAndCompute(image, None)
        place = np.array([((p.pt[0] + 0.5) * scale - 0.5, (p.pt[1] + 0.5) * scale - 0.5) for p in points])
        cache[path] = (place, np.array([(p.size * scale, p.angle) for p in points]), np.sqrt(rows / rows.sum(1, keepdims=True)))
    return cache[path]


def mutual_matches(first, second):
    """Rows of both and their ratios."""
    similar = first @ second.T
    nearest = similar.argmax(1)
    rows = np.flatnonzero(similar.argmax(0)[nearest] == np.arange(len(first)))
    nearest = nearest[rows]
    others = similar[rows]
    others[np.arange(len(rows)), nearest] = -np.inf
    def distance(columns):
        return np.sqrt(((first[rows].astype(float) - second[columns]) ** 2).sum(1))
    return rows, nearest, distance(nearest) / distance(others.argmax(1))


def scale_and_angle(folder, images, name, pair):
    """The ratio of sizes and the difference of angles of each match, as ARS-MAGSAC takes them. Ratio and place tell a match."""
    options = [option_of_scene(folder, key) for key in ("max_keypoints", "max_image_size", "contrast_threshold")]
    found = []
    for image in name.split("-"):
        files = glob.glob(f"{glob.escape(images)}/{glob.escape(image)}.*") or fail(f"{images}/{image}.*: no such image")
        found.append(detect(files[0], *options))
    rows, columns, ratios = mutual_matches(found[0][2], found[1][2])
    places = np.hstack([found[0][0][rows], found[1][0][columns]])
    affine, lost = np.empty((len(pair.ratios), 2)), 0
    for i, (match, ratio) in enumerate(zip(pair.matches, pair.ratios)):
        moved = np.abs(places - match).max(1)          # by lens distortion, where there is some
        best = np.argmin(1e4 * np.abs(ratios - ratio) + moved)
        chosen = rows[best], columns[best]
        if abs(ratios[best] - ratio) > 1e-3 or moved[best] > 60:   # a tie that fell otherwise
            lost += 1
            chosen = [np.abs(f[0] - match[2 * k:2 * k + 2]).max(1).argmin() for k, f in enumerate(found)]
        one, two = found[0][1][chosen[0]], found[1][1][chosen[1]]
        affine[i] = two[0] / one[0], np.deg2rad((two[1] - one[1]) % 180)
    if lost > 0.02 * len(affine):
        fail(f"{folder}: {name}: {lost} of {len(affine)} matches were not found again in {images}")
    return affine


def affine_of_pair(arguments, folder, images, name, pair):
    if not arguments.cache:
        return scale_and_angle(folder, images, name, pair)
    with h5py.File(arguments.cache, "a") as file:
        key = f"{os.path.basename(os.path.normpath(folder))}/{name}"
        if key not in file:
            file[key] = scale_and_angle(folder, images, name, pair)
        return file[key][()]


def essential_matrix(turn, shift):
    x, y, z = shift
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ turn


def matrix_of(pose):
    """The essential matrix of a motion."""
    return essential_matrix(pose.R, pose.t)


def pose_errors(turn, shift, pair):
    """As docs/metrics.md has them: degrees of the rotation, and of the translation with either sign."""
    cosine = (np.trace(turn @ pair.turn.T) - 1) / 2
    sine = np.linalg.norm(np.cross(shift, pair.shift)) / (np.linalg.norm(shift) * np.linalg.norm(pair.shift))
    errors = np.degrees(np.arccos(np.clip(cosine, -1, 1))), np.degrees(np.arcsin(min(sine, 1.0)))
    return errors if np.isfinite(errors).all() else FAILURE


def sampson(matrix, points):
    """Squared Sampson distances."""
    one = np.ones((len(points), 1))
    first, second = np.hstack([points[:, :2], one]), np.hstack([points[:, 2:], one])
    lines, others = first @ matrix.T, second @ matrix
    gradient = (lines[:, :2] ** 2).sum(1) + (others[:, :2] ** 2).sum(1)
    return (second * lines).sum(1) ** 2 / np.maximum(gradient, 1e-30)


def motion_by_cheirality(essential, points):
    """R and t of the four motions of E that has the most points before both cameras; None where all have none. OpenCV's recoverPose does
    the same in fifty times the time."""
    rays = [np.hstack([side, np.ones((len(points), 1))]) for side in (points[:, :2], points[:, 2:])]
    *turns, shift = cv2.decomposeEssentialMat(essential)
    best, chosen = 0, None
    for turn in turns:
        turned = rays[0] @ turn.T
        normal = np.cross(turned, rays[1])                       # depths: depth2 ray2 = depth1 turned + shift
        depth1 = (normal * np.cross(rays[1], shift[:, 0])).sum(1)
        depth2 = (normal * np.cross(turned, shift[:, 0])).sum(1)
        for sign in (1, -1):
            before = np.count_nonzero((sign * depth1 > 0) & (sign * depth2 > 0))
            if before > best:
                best, chosen = before, (turn, sign * shift[:, 0])
    return chosen


def errors_of_matrix(matrix, pair, task):
    """Of the motion that the inliers of a fundamental or essential matrix choose by cheirality."""
    if matrix is None or np.shape(matrix) != (3, 3) or not np.isfinite(matrix).all():
        return FAILURE
    essential = pair.k2.T @ matrix @ pair.k1 if task == "fundamental" else matrix
    fundamental = matrix if task == "fundamental" else np.linalg.inv(pair.k2).T @ matrix @ np.linalg.inv(pair.k1)
    inliers = sampson(fundamental, pair.matches) < EPSILON_PX ** 2
    motion = motion_by_cheirality(essential, normalized(pair)[inliers]) if inliers.sum() >= 5 else None
    return pose_errors(*motion, pair) if motion else FAILURE


def accuracy(errors, most=10):
    """mAA at `most` degrees."""
    return (np.asarray(errors)[:, None] <= np.arange(1, most + 1)).mean()
