"""Matches by hloc (Sarlin and others, CVPR 2019) or its matchers: two HDF5 files, as a scene.

A group NAME of the features holds `keypoints` (N x 2) and, optionally, `image_size`, `scales` and `oris` (sizes, angles in degrees). A group
NAME1/NAME2 of the matches, with '-' for the '/' of folders, or in older files NAME1_NAME2, holds `matches0` (of each keypoint of image 1 that
of image 2, or -1) and, optionally, `matching_scores0`. Images and pairs that make no sense are named and left out.
"""

import os
import pathlib
import sys

import numpy as np

from common import BadInput, given_camera, need, open_h5, read_h5, what_all_have, write_scene


def groups_with(file, key):
    """Those that directly hold this data set, at any depth, by name."""
    found = []
    file.visit(lambda name: found.append(name[: -len(key) - 1]) if name.endswith("/" + key) else None)
    return found


def only_file(folder, key, what, option):
    found = []
    for path in sorted(pathlib.Path(folder).glob("*.h5")):
        with open_h5(path) as file:
            # matches.h5 may hold keypoints as well.
            if groups_with(file, key) and (key == "matches0" or not groups_with(file, "matches0")):
                found.append(path)
    names = f"{len(found)} ({', '.join(path.name for path in found)})" if found else "none"
    need(len(found) == 1, f"{folder}: expected one .h5 file with hloc's {what}, found {names}; name it with {option}")
    return str(found[0])


def read_image(file, name):
    place, keypoints = f"{file.filename}: {name}", read_h5(file, name + "/keypoints")
    need(keypoints.ndim == 2 and keypoints.shape[1] == 2, f"{place}/keypoints: expected Nx2, found {keypoints.shape}")
    need(np.isfinite(keypoints).all(), f"{place}/keypoints: a value is not finite")
    size, scales, angles = (read_h5(file, f"{name}/{key}") for key in ("image_size", "scales", "oris"))
    if size is not None:
        need(size.size == 2 and (size >= 1).all() and (size < 1e9).all(), f"{place}/image_size: expected width and height")
        size = size.ravel().astype("i4")
    frames = None
    if scales is not None and angles is not None:
        for key, values in (("scales", scales), ("oris", angles)):
            need(values.size == len(keypoints), f"{place}/{key}: expected {len(keypoints)} values, one a keypoint, found {values.shape}")
        with np.errstate(divide="ignore", invalid="ignore"):
            frames = np.column_stack([np.log(scales.ravel()), angles.ravel() * np.pi / 180])
        need(np.isfinite(frames).all(), f"{place}/scales: expected sizes above 0 and finite oris")
    return keypoints, size, frames


def images_of_pair(group, place, images):
    """The two images that its name means; images: by their names with '-' for '/'."""
    parts = group.split("/")
    need(len(parts) <= 2, f"{place}: expected NAME1/NAME2 as the name of a pair")
    if len(parts) == 2:
        for part in parts:
            need(part in images, f"{place}: there is no image {part} in the features")
        return images[parts[0]], images[parts[1]]
    words = group.split("_")  # NAME1_NAME2, where names may have '_' themselves.
    splits = [("_".join(words[:i]), "_".join(words[i:])) for i in range(1, len(words))]
    found = [(images[first], images[second]) for first, second in splits if first in images and second in images]
    need(found, f"{place}: the features have no two images of this name, NAME1/NAME2 or NAME1_NAME2")
    need(len(found) == 1, f"{place}: can be the name of several pairs")
    return found[0]


def read_matches(file, group, count1, count2):
    place, partners, scores = f"{file.filename}: {group}", read_h5(file, group + "/matches0"), read_h5(file, group + "/matching_scores0")
    need(partners.size == count1, f"{place}/matches0: expected {count1} values, one a keypoint, found {partners.shape}")
    partners = partners.ravel()
    kept = partners != -1
    wrong = partners[kept & ~((partners >= 0) & (partners < count2))]
    need(not wrong.size, f"{place}/matches0: {wrong.max(initial=-2):g} is no keypoint of its second image, which has {count2}")
    matches = np.column_stack([np.flatnonzero(kept), partners[kept]]).astype("i4")
    if scores is None:
        return matches, None
    need(scores.size == count1, f"{place}/matching_scores0: expected {count1} values, found {scores.shape}")
    scores = scores.ravel()[kept]
    need(((scores >= 0) & (scores <= 1)).all(), f"{place}/matching_scores0: expected scores from 0 to 1")
    return matches, scores


def pair_names(files):
    """A name for each image that can stand in img1-img2."""
    stems = [str(pathlib.PurePosixPath(file).with_suffix("")).replace("-", "_").replace("/", "_") for file in files]
    names = [f"{stem}_{i}" if stems.count(stem) > 1 else stem for i, stem in enumerate(stems)]
    need(len(set(names)) == len(names), "two images cannot be told apart by their names: rename one")
    return names


def turned(change):
    """An angle in (-pi, pi]."""
    return change - 2 * np.pi * np.ceil((change - np.pi) / (2 * np.pi))


def hloc(source, arguments):
    """matches.h5, or a folder that holds it and the features; images.txt says which file each image of a pair is, and what was left out."""
    is_folder = os.path.isdir(source)
    matches_file = only_file(source, "matches0", "matches", "INPUT") if is_folder else source
    need(os.path.isfile(matches_file), f"{matches_file}: no such file or folder")
    folder = os.path.dirname(os.path.abspath(matches_file))
    features_file = arguments.features or only_file(folder, "keypoints", "features", "--features")
    scene = arguments.scene or (os.path.basename(os.path.abspath(source)) if is_folder else pathlib.Path(source).stem)
    output = os.path.join(arguments.output, scene)
    for path in (matches_file, features_file):
        inside = os.path.isdir(output) and os.path.samefile(os.path.dirname(os.path.abspath(path)), output)
        need(not inside, f"{path} is an input, and would be replaced in the folder of the scene {output}: give another OUTPUT or --scene")
    K, left_out = given_camera(arguments), []

    with open_h5(features_file) as file:
        files = groups_with(file, "keypoints")
        need(files, f"{features_file}: no group of it holds keypoints, as hloc's features do")
        images = []
        for name in files:
            try:
                images.append(read_image(file, name))
            except BadInput as error:  # Its place among the names stays, so that its pairs are known.
                images.append(None)
                left_out.append(str(error))
    by_name = {}
    for i, name in enumerate(files):
        other = by_name.setdefault(name.replace("/", "-"), i)
        need(other == i, f"{features_file}: the names {files[other]} and {name} are the same in pairs")
    names, scene_files, seen, of_bad_images = pair_names(files), {"matches": {}}, set(), 0

    def put(pair, **values):
        for key, value in values.items():
            if value is not None:
                scene_files.setdefault(key, {})[pair] = value

    with open_h5(matches_file) as file:
        for group in groups_with(file, "matches0"):
            try:
                first, second = images_of_pair(group, f"{matches_file}: {group}", by_name)
                if not images[first] or not images[second]:
                    of_bad_images += 1
                    continue
                if (min(first, second), max(first, second)) in seen:
                    continue  # The same pair the other way round.
                seen.add((min(first, second), max(first, second)))
                (points1, size1, frames1), (points2, size2, frames2) = images[first], images[second]
                rows, scores = read_matches(file, group, len(points1), len(points2))
            except BadInput as error:
                left_out.append(str(error))
                continue
            similarities = None
            if frames1 is not None and frames2 is not None:
                similarities = frames2[rows[:, 1]] - frames1[rows[:, 0]]
                similarities[:, 1] = turned(similarities[:, 1])
            sizes = None if size1 is None or size2 is None else np.array([*size1[::-1], *size2[::-1]], "i4")
            put(f"{names[first]}-{names[second]}", matches=np.hstack([points1[rows[:, 0]], points2[rows[:, 1]]]), match_scores=scores,
                similarities=similarities, sizes=sizes, match_indices=rows, K1_K2=None if K is None else np.array([[K, K]]))
    pairs = len(scene_files["matches"])
    need(pairs, left_out[0] if left_out else f"{matches_file}: no group of it holds matches0, as hloc's matches do")
    if of_bad_images:
        left_out.append(f"{of_bad_images} pairs of images that were left out")
    for problem in left_out:
        print(f"convert: left out: {problem}", file=sys.stderr)
    write_scene(output, what_all_have(scene_files))
    lines = [f"{name}\t{file}" for name, file in zip(names, files)] + [f"\t{problem}" for problem in left_out]
    pathlib.Path(output, "images.txt").write_text("\n".join(lines) + "\n")
    print(f"convert: {output}: {pairs} pairs")
