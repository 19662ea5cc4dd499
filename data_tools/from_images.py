"""What needs keypoints of images by OpenCV (python3-opencv): descriptors for the tutorial's scenes, and matches of images with the points of a
COLMAP model. Keypoints and descriptors are those of diffsac_prepare, by the same version of OpenCV."""

import os
import pathlib
import sys

import h5py
import numpy as np

from common import BadInput, images_in, need, open_h5, read_h5, read_text, write_h5

try:
    import cv2
except ImportError:
    cv2 = None

NEAREST_PLACE_PX, USUAL_DIAMETER, NEAREST_KEYPOINT_PX, BLOCK = 1.0, 8.0, 2.0, 1000


def grey(path, most=0):
    """The image as it is stored, reduced to this longer side (0: never), and its pixels in one of the reduced image."""
    need(cv2, "there is no module cv2 (Debian: python3-opencv)")
    need(os.path.isfile(path), f"{path}: no such file")
    image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION)
    need(image is not None, f"{path}: not an image, or truncated")
    longer = max(image.shape)
    scale = longer / most if 0 < most < longer else 1.0
    size = tuple(max(1, int(side / scale + 0.5)) for side in image.shape[::-1])
    return (image if scale == 1 else cv2.resize(image, size, interpolation=cv2.INTER_AREA)), scale, image.shape


def keypoints_of(image, scale, most):
    """Places in the file's pixels, OpenCV's keypoints, and SIFT's descriptors as bytes; at most so many (0: all)."""
    found, raw = cv2.SIFT_create(most, 3, 0.04).detectAndCompute(image, None)
    places = np.array([k.pt for k in found], np.float32).reshape(-1, 2).astype(float)
    return (places + 0.5) * scale - 0.5, found, np.zeros((0, 128), "u1") if raw is None else raw.astype("u1")


def unit(raw, rooted=True):
    """Of length one: SIFT's values, or their roots (RootSIFT)."""
    values = raw.astype(np.float32)
    values = np.sqrt(values) if rooted else values
    lengths = np.linalg.norm(values, axis=1, keepdims=True)
    return np.where(lengths > 0, values / np.maximum(lengths, np.float32(1e-30)), np.float32(1 / np.sqrt(np.float32(128)))).astype(np.float32)


def stem_of(name):
    return pathlib.PurePosixPath(name).stem.replace("-", "_")


def describe(path, places, most):
    """SIFT of each place: of the nearest keypoint within a pixel, the strongest of equally near ones; others are described themselves, upright
    and with the median diameter of the image's keypoints. Also how many have a keypoint, and height and width."""
    from scipy.spatial import cKDTree

    image, scale, shape = grey(path, most)
    positions, found, raw = keypoints_of(image, scale, 0)
    rows, rest = np.zeros((len(places), 128), "u1"), []
    diameter = np.sort([np.float32(k.size) for k in found])[len(found) // 2] if found else USUAL_DIAMETER
    near = cKDTree(positions).query_ball_point(places, NEAREST_PLACE_PX) if found else [[]] * len(places)
    for i, candidates in enumerate(near):
        if candidates:
            distances = np.linalg.norm(positions[candidates] - places[i], axis=1)
            rows[i] = raw[min(zip(distances, [-found[k].response for k in candidates], candidates))[2]]
        else:
            x, y = (places[i] + 0.5) / scale - 0.5
            rest.append(cv2.KeyPoint(float(x), float(y), float(diameter), 0.0, 0.0, 0, i))
    if rest:
        kept, described = cv2.SIFT_create(0, 3, 0.04).compute(image, rest)
        rows[[k.class_id for k in kept]] = described.astype("u1")
    return rows, len(places) - len(rest), shape


def places_of(matches, pair, image):
    """x + iy of the image's side of a pair, which sort and compare as numbers do."""
    rows = read_h5(matches, pair)
    need(rows.ndim == 2 and rows.shape[1] == 4 and np.isfinite(rows).all(), f"{matches.filename}: {pair}: expected Nx4 finite numbers")
    return rows[:, 2 * image] + 1j * rows[:, 2 * image + 1]


def tutorial(arguments):
    """Adds descriptors.h5 and sizes.h5 to a scene of the tutorial, from its images: each matched place of an image is described once."""
    scene = pathlib.Path(arguments.scene)
    if (scene / "descriptors.h5").exists() and not arguments.overwrite:
        print(f"convert: {scene}: descriptors are already there; --overwrite makes them again")
        return
    with open_h5(scene / "matches.h5") as matches:
        pairs, places, described = sorted(matches), {}, {}
        for pair in pairs:
            need(pair.count("-") == 1 and all(pair.split("-")), f"{scene}: {pair}: expected the name of a pair, img1-img2")
            for image, name in enumerate(pair.split("-")):
                places[name] = np.unique(np.concatenate([places.get(name, []), places_of(matches, pair, image)]))
        files = {stem_of(path.name): path for path in images_in(arguments.images or scene / "images")}
        problems = []
        for name in places:
            need(name in files, f"{arguments.images or scene / 'images'}: there is no image {name}")
            try:
                described[name] = describe(files[name], np.column_stack([places[name].real, places[name].imag]), arguments.max_image_size)
            except BadInput as error:
                problems.append(str(error))
        need(not problems, f"{problems[:1]} ({len(problems)} images cannot be described)")

        def sizes(file):
            for pair in pairs:
                file.create_dataset(pair, data=np.array([side for name in pair.split("-") for side in described[name][2]], "i4"))

        def descriptors(file):
            for pair in pairs:
                sides = [described[name][0][np.searchsorted(places[name], places_of(matches, pair, i))] for i, name in enumerate(pair.split("-"))]
                file.create_dataset(pair, data=np.hstack([unit(side, arguments.features == "rootsift") for side in sides]))

        write_h5(scene / "sizes.h5", sizes)
        write_h5(scene / "descriptors.h5", descriptors)
    count, found = sum(map(len, places.values())), sum(described[name][1] for name in described)
    print(f"convert: {scene}: {len(pairs)} pairs, {len(places)} images, {count} matched places; {100 * found / max(count, 1):.1f} % have a "
          "keypoint within a pixel, the others are described themselves")


def model_folder(folder):
    for name in ("", "colmap_ground_truth", "sparse/0", "sparse"):
        if all((pathlib.Path(folder, name) / f"{part}.txt").exists() for part in ("cameras", "images")):
            return pathlib.Path(folder, name)
    raise BadInput(f"{folder}: no COLMAP text model (cameras.txt, images.txt; colmap model_converter makes one of a binary model)")


def lines_of(path):
    return [(i, line.split()) for i, line in enumerate(read_text(path).splitlines(), 1) if not line.startswith("#")]


# Where fx, fy, cx, cy and k1 k2 p1 p2 k3 k4 k5 k6 stand among a camera's parameters.
LENSES = {"SIMPLE_PINHOLE": ((0, 0, 1, 2), 3), "PINHOLE": ((0, 1, 2, 3), 4), "SIMPLE_RADIAL": ((0, 0, 1, 2), 4), "RADIAL": ((0, 0, 1, 2), 5),
          "OPENCV": ((0, 1, 2, 3), 8), "FULL_OPENCV": ((0, 1, 2, 3), 12)}


def read_cameras(path):
    """K, whose first pixel has its centre at (0, 0), and the lens, by the camera's number."""
    cameras = {}
    for number, words in lines_of(path):
        if not words:
            continue
        need(len(words) > 4 and words[1] in LENSES, f"{path}:{number}: expected CAMERA_ID MODEL WIDTH HEIGHT PARAMS, of {', '.join(LENSES)}")
        (fx, fy, cx, cy), count = LENSES[words[1]]
        try:
            p = np.array(words[4:], float)
        except ValueError as error:
            raise BadInput(f"{path}:{number}: {error}") from None
        need(len(p) == count and np.isfinite(p).all(), f"{path}:{number}: expected {count} parameters")
        cameras[words[0]] = np.array([[p[fx], 0, p[cx] - 0.5], [0, p[fy], p[cy] - 0.5], [0, 0, 1]]), p[cy + 1:]
    return cameras


def rotation_of(quaternion):
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def read_images(path, cameras):
    """Name of the file -> camera, pose (3 x 4), observed pixels and their points' numbers."""
    lines, images = lines_of(path), {}
    for (number, words), (other, seen) in zip(lines[::2], lines[1::2] + [(0, [])]):
        if not words:
            continue
        try:
            pose, points = np.array(words[1:8], float), np.array(seen, float).reshape(-1, 3)
        except ValueError as error:
            raise BadInput(f"{path}:{number}: {error}") from None
        need(len(words) >= 10 and np.linalg.norm(pose[:4]) > 0, f"{path}:{number}: expected IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME")
        need(words[8] in cameras, f"{path}:{number}: there is no camera {words[8]}")
        points = points[points[:, 2] >= 0]
        images[" ".join(words[9:])] = cameras[words[8]], np.column_stack([rotation_of(pose[:4]), pose[4:]]), points[:, :2] - 0.5, points[:, 2].astype(int)
    return images


def undistorted(points, K, lens):
    if not np.any(lens):
        return points
    coefficients = np.zeros(max(4, len(lens)))
    coefficients[: len(lens)] = lens
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 200, 1e-12)
    return cv2.undistortPointsIter(points[:, None], K, coefficients, None, K, criteria)[:, 0]


def mutual(first, second):
    """Rows that are each other's nearest, with the distance's ratio to that of the next one; rows have unit length."""
    best, following, top, of_second = [], [], np.full(len(second), -np.inf, np.float32), np.zeros(len(second), int)
    for start in range(0, len(first), BLOCK):
        similarity = first[start:start + BLOCK] @ second.T
        row = similarity.argmax(0)
        value = similarity[row, np.arange(len(second))]
        of_second, top = np.where(value > top, start + row, of_second), np.maximum(value, top)
        best.append(similarity.argmax(1))
        similarity[np.arange(len(similarity)), best[-1]] = -np.inf
        following.append(similarity.argmax(1))
    best, following = np.concatenate(best), np.concatenate(following)
    rows = np.flatnonzero(of_second[best] == np.arange(len(first)))
    distance = lambda other: ((first[rows].astype(float) - second[other[rows]].astype(float)) ** 2).sum(1)
    near, next_one = distance(best), distance(following)
    ratios = np.where(next_one > 0, np.minimum(1, np.sqrt(near / np.where(next_one > 0, next_one, 1))), 1)
    return rows, best[rows], ratios


def colmap_points(source, arguments):
    """Each image of a COLMAP text model against the points as the other images see them: OUTPUT/SCENE/scene_points.h5, which the dataset
    absolute_poses reads. A point's descriptor is the mean of those of the keypoints within 2 pixels of its observations in the others."""
    model = model_folder(source)
    points = {}
    for number, words in lines_of(model / "points3D.txt"):
        if words:
            need(len(words) >= 8, f"{model / 'points3D.txt'}:{number}: expected POINT3D_ID X Y Z R G B ERROR TRACK")
            points[int(words[0])] = np.array(words[1:4], float)
    images, views, features = read_images(model / "images.txt", read_cameras(model / "cameras.txt")), {}, {}
    for name in sorted(images, key=stem_of):
        try:
            image, scale, _ = grey(pathlib.Path(source) / "images" / name)
        except BadInput as error:
            print(f"convert: left out: {error}", file=sys.stderr)
            continue
        positions, found, raw = keypoints_of(image, scale, 8000)
        order = sorted(range(len(found)), key=lambda i: (-found[i].response, found[i].pt[1], found[i].pt[0], found[i].size, found[i].angle, i))[:8000]
        positions, descriptors = positions[order], unit(raw[order])
        features[name] = positions, descriptors
        _, _, observed, numbers = images[name]
        for pixel, point in zip(observed, numbers):
            square = ((positions - pixel) ** 2).sum(1)
            nearest = len(square) - 1 - square[::-1].argmin()  # Of two orientations the weaker.
            if square[nearest] <= NEAREST_KEYPOINT_PX ** 2:
                views.setdefault(point, []).append((name, descriptors[nearest]))
    need(len(features) > 1, f"{source}: fewer than two images can be read")

    def fill(file):
        for name, (positions, descriptors) in features.items():
            (K, lens), pose, _, _ = images[name]
            sums = {p: np.sum([d for other, d in seen if other != name], axis=0) for p, seen in sorted(views.items()) if p in points}
            known = [p for p, total in sums.items() if np.linalg.norm(total) > 0]
            need(len(known) > 1, f"{model}: no point of another image has a keypoint near it")
            means = np.array([sums[p] / np.linalg.norm(sums[p]) for p in known], np.float32)
            rows, others, ratios = mutual(descriptors, means)
            group = file.create_group(stem_of(name))
            group["points"] = np.hstack([np.array([points[p] for p in known])[others], undistorted(positions[rows], K, lens)])
            group["ratios"], group["K"], group["pose"] = ratios, K, pose

    scene = os.path.join(arguments.output, arguments.scene or os.path.basename(os.path.abspath(source)))
    write_h5(os.path.join(scene, "scene_points.h5"), fill)
    print(f"convert: {scene}: {len(features)} images")
