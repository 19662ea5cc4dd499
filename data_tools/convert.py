#!/usr/bin/env python3
"""Data sets in formats of their own, as what diffsac_prepare and the loaders read (data_tools/README.md).

    convert.py nerf|llff|strecha|middlebury|projections|poses INPUT OUTPUT    a COLMAP text model with links to the images
    convert.py adelaidermf|adelaidermf_matches|adelaidermf_planes|hloc INPUT OUTPUT    scenes of matches in OUTPUT
    convert.py nyu_vp|yud_plus INPUT OUTPUT                                   scenes of line segments in OUTPUT
    convert.py colmap_points INPUT OUTPUT                                     images against the points of a COLMAP text model
    convert.py registration INPUT OUTPUT                                      matches of clouds with their motion in OUTPUT
    convert.py matches INPUT.npy|INPUT.npz OUTPUT                             the text that diffsac_pair --from-matches reads
    convert.py matrix INPUT.npy OUTPUT                                        a calibration matrix as text
    convert.py tutorial SCENE                                                 descriptors of a scene that has images
    convert.py inspect FOLDER...                                              what stands in scenes of matches; a picture
    convert.py sets --config configs/sets.yaml --data DIR                     all sets of a list, by diffsac_prepare

An image whose pose or calibration makes no sense is left out and named. Bad input is one line and exit code 2.
COLMAP's first pixel has its centre at (0.5, 0.5), that of all these formats but NeRF's at (0, 0).
"""

import argparse
import csv
import json
import math
import os
import pathlib
import re
import sys

import h5py
import numpy as np

import from_images
import image_sets
import inspect_scenes
from common import BadInput, images_in, need, numbers, read_text, size_of, write_h5, write_scene
from hloc import hloc
from planes import dominant_plane


def rotation_near(matrix, place):
    """The nearest rotation of what is one within 1 %: few digits, or a tracker that drifted."""
    need(np.isfinite(matrix).all(), f"{place}: the pose is not finite")
    square = matrix @ matrix.T
    need(np.linalg.norm(square - np.eye(3)) <= 0.01 * np.sqrt(3) and np.linalg.det(matrix) > 0, f"{place}: the pose holds no rotation")
    u, _, v = np.linalg.svd(matrix)
    return u @ v


def world_to_camera(to_world, place):
    to_world = np.asarray(to_world, float)
    need(to_world.shape in ((3, 4), (4, 4)), f"{place}: expected a 3x4 or 4x4 matrix")
    need(to_world.shape == (3, 4) or (to_world[3] == [0, 0, 0, 1]).all(), f"{place}: expected 0 0 0 1 as the last row of the pose")
    rotation = rotation_near(to_world[:3, :3], place)
    return rotation.T, -rotation.T @ to_world[:3, 3]


def quaternion_of(rotation):
    """w x y z, w not negative, by the largest of the four."""
    m = rotation
    squares = np.array([1 + m[0, 0] + m[1, 1] + m[2, 2], 1 + m[0, 0] - m[1, 1] - m[2, 2],
                        1 - m[0, 0] + m[1, 1] - m[2, 2], 1 - m[0, 0] - m[1, 1] + m[2, 2]])
    products = np.array([[squares[0], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]],
                         [m[2, 1] - m[1, 2], squares[1], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]],
                         [m[0, 2] - m[2, 0], m[0, 1] + m[1, 0], squares[2], m[1, 2] + m[2, 1]],
                         [m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], squares[3]]])
    row = products[np.argmax(squares)]
    return row / np.linalg.norm(row) * (-1 if row[0] < 0 else 1)


class Model:
    """Images with a camera and a pose each, written as cameras.txt, images.txt, points3D.txt and images/."""

    def __init__(self):
        self.images, self.left_out = {}, 0

    def add(self, read):
        """read() -> path, K (first pixel's centre at 0), (width, height), lens (k1 k2 p1 p2), R, t."""
        try:
            path, K, size, lens, R, t = read()
            K = np.asarray(K, float)
            need(np.isfinite(K).all() and K[0, 0] > 0 and K[1, 1] > 0, f"{path}: expected a calibration matrix")
            need(abs(K[0, 1]) <= 1e-4 * K[0, 0], f"{path}: K with skew, which COLMAP's cameras have not")
            need(np.isfinite(t).all(), f"{path}: the pose is not finite")
            stem = path.stem
            need(stem not in self.images, f"{path}: two images have this name")
            self.images[stem] = (path, K, size, lens, R, t)
        except BadInput as error:
            self.left_out += 1
            if self.left_out <= 5:
                print(f"convert: left out: {error}", file=sys.stderr)

    def write(self, folder):
        need(len(self.images) > 1, f"{folder}: fewer than two images are left")
        folder = pathlib.Path(folder)
        (folder / "images").mkdir(parents=True, exist_ok=True)
        cameras, images = {}, []
        for number, stem in enumerate(sorted(self.images), 1):
            path, K, size, lens, R, t = self.images[stem]
            parameters = [K[0, 0], K[1, 1], K[0, 2] + 0.5, K[1, 2] + 0.5] + (list(lens) if any(lens) else [])
            camera = " ".join([("OPENCV" if any(lens) else "PINHOLE"), *map(str, size), *(repr(float(p)) for p in parameters)])
            identifier = cameras.setdefault(camera, len(cameras) + 1)
            pose = " ".join(repr(float(value)) for value in [*quaternion_of(R), *t])
            images.append(f"{number} {pose} {identifier} {path.name}\n\n")
            link = folder / "images" / path.name
            if link.is_symlink():
                link.unlink()
            link.symlink_to(path.resolve())
        texts = {"points3D.txt": "", "cameras.txt": "".join(f"{number} {text}\n" for text, number in cameras.items()),
                 "images.txt": "".join(images)}  # Last: it says that the model is whole.
        for name, text in texts.items():
            (folder / (name + ".part")).write_text(text)
            os.replace(folder / (name + ".part"), folder / name)
        print(f"convert: {folder}: {len(images)} images" + (f", {self.left_out} left out" if self.left_out else ""))


def nerf(source, _):
    """transforms.json as instant-ngp writes it: OpenGL's axes, COLMAP's pixels."""
    source = pathlib.Path(source)
    file = source if source.is_file() else source / "transforms.json"
    try:
        every = json.loads(read_text(file))
    except json.JSONDecodeError as error:
        raise BadInput(f"{file}: not JSON: {error}") from None
    frames = every.get("frames") if isinstance(every, dict) else None
    need(isinstance(frames, list), f"{file}: expected an object with a list of frames")

    def image_path(name):
        path = pathlib.Path(os.path.normpath(file.parent / name.replace("\\", "/")))  # Of Windows; without extension; moved.
        for candidate in (path, file.parent / path.name):
            for extension in ("", ".png", ".jpg", ".jpeg"):
                if os.path.isfile(str(candidate) + extension):
                    return pathlib.Path(str(candidate) + extension)
        raise BadInput(f"{path}: no such file")

    def read(frame):
        name = frame.get("file_path") if isinstance(frame, dict) else None
        need(isinstance(name, str) and name, f"{file}: a frame: expected file_path")
        place, path = f"{file}: {name}", image_path(name)

        def value(key, other=None):
            found = next((values[key] for values in (frame, every) if values.get(key) is not None), None)
            need(found is None or (isinstance(found, (int, float)) and math.isfinite(found)), f"{place}: expected a number as {key}")
            return other if found is None else found

        need(not any(value(key, 0) for key in ("k3", "k4")), f"{place}: lens distortion with k3 or k4 is not supported")
        fisheye = frame.get("is_fisheye", every.get("is_fisheye")), str(frame.get("camera_model", every.get("camera_model")))
        need(fisheye[0] is not True and "FISHEYE" not in fisheye[1], f"{place}: fisheye cameras are not supported")
        w, h = value("w", 0), value("h", 0)
        if value("fl_x") is None:
            angle = value("camera_angle_x", 0)
            need(w and 1e-6 < angle < math.pi, f"{place}: expected fl_x, or camera_angle_x between 0 and pi and w")
            fx = 0.5 * w / math.tan(0.5 * angle)
        else:
            fx = value("fl_x")
        fy = value("fl_y", fx)
        need((w or value("cx") is not None) and (h or value("cy") is not None), f"{place}: neither cx, cy nor w, h are given")
        cx, cy = value("cx", w / 2), value("cy", h / 2)
        size = size_of(path)
        # Some images were reduced after their calibration: of the same shape, but for rounding.
        if w and h and (w, h) != size and abs(w * size[1] - h * size[0]) <= max(w, h):
            x, y = size[0] / w, size[1] / h
            fx, fy, cx, cy = fx * x, fy * y, cx * x, cy * y
        lens = [value(key, 0) for key in ("k1", "k2", "p1", "p2")]
        try:
            to_world = np.array(frame["transform_matrix"], float) * [1, -1, -1, 1]
        except (KeyError, TypeError, ValueError):
            raise BadInput(f"{place}: expected transform_matrix, a 4x4 matrix") from None
        return path, [[fx, 0, cx - 0.5], [0, fy, cy - 0.5], [0, 0, 1]], size, lens, *world_to_camera(to_world, place)

    return [lambda frame=frame: read(frame) for frame in frames]


def llff(source, _):
    """poses_bounds.npy: rows of [R | centre | height width focal] (axes down, right, backwards) and two depths."""
    file = pathlib.Path(source) / "poses_bounds.npy"
    try:
        rows = np.load(file, allow_pickle=False).astype(float)
    except (OSError, ValueError) as error:
        raise BadInput(f"{file}: {getattr(error, 'strerror', None) or error}") from None
    need(rows.ndim == 2 and rows.shape[1] == 17, f"{file}: expected N rows of 17 numbers")
    paths = images_in(pathlib.Path(source) / "images")
    need(len(paths) == len(rows), f"{file}: {len(rows)} poses for {len(paths)} images")

    def read(i):
        place, matrix, size = f"{file}: row {i}", rows[i, :15].reshape(3, 5), size_of(paths[i])
        height, width, focal = matrix[:, 4]
        need(height > 0 and width > 0 and focal > 0, f"{place}: expected height, width, focal length")
        K = [[focal * size[0] / width, 0, 0.5 * size[0] - 0.5], [0, focal * size[1] / height, 0.5 * size[1] - 0.5], [0, 0, 1]]
        to_world = np.column_stack([matrix[:, 1], matrix[:, 0], -matrix[:, 2], matrix[:, 3]])
        return paths[i], K, size, [], *world_to_camera(to_world, place)

    return [lambda i=i: read(i) for i in range(len(paths))]


def strecha(source, _):
    """images/ and gt_dense_cameras/IMAGE.camera: K, three zeros, camera-to-world rotation, centre, width, height."""

    def read(path):
        file = pathlib.Path(source) / "gt_dense_cameras" / (path.name + ".camera")
        v = numbers(file, 26, "26 numbers")
        need(not v[9:12].any(), f"{file}: expected an undistorted image (three zeros after K)")
        to_world = np.column_stack([v[12:21].reshape(3, 3), v[21:24]])
        return path, v[:9].reshape(3, 3), (int(v[24]), int(v[25])), [], *world_to_camera(to_world, str(file))

    return [lambda path=path: read(path) for path in images_in(pathlib.Path(source) / "images")]


def middlebury(source, _):
    """NAME_par.txt: IMAGE K R t, world-to-camera, a line an image; names may have blanks."""
    files = sorted(pathlib.Path(source).glob("*_par.txt"))
    need(files, f"{source}: no file NAME_par.txt")

    def read(number, line):
        place, words = f"{files[0]}:{number}", line.rsplit(None, 21)
        need(len(words) == 22, f"{place}: expected an image and 21 numbers")
        path = pathlib.Path(source) / words[0]
        need(path.is_file(), f"{place}: there is no {path}")
        try:
            v = np.array(words[1:], float)
        except ValueError as error:
            raise BadInput(f"{place}: {error}") from None
        return path, v[:9].reshape(3, 3), size_of(path), [], rotation_near(v[9:18].reshape(3, 3), place), v[18:]

    lines = [(i, line) for i, line in enumerate(read_text(files[0]).splitlines(), 1) if len(line.split()) > 1]
    return [lambda number=number, line=line: read(number, line) for number, line in lines]


def projections(source, _):
    """image/ (or images/) and cameras.npz with world_mat_I, whose upper three rows are K [R | t] of the I-th image."""
    file = pathlib.Path(source) / "cameras.npz"
    try:
        arrays = np.load(file, allow_pickle=False)
    except (OSError, ValueError) as error:
        raise BadInput(f"{file}: {getattr(error, 'strerror', None) or error}") from None
    folder = pathlib.Path(source) / ("image" if (pathlib.Path(source) / "image").is_dir() else "images")

    def read(i, path):
        key = f"world_mat_{i}"
        need(key in arrays, f"{file}: there is no {key}")
        P = np.asarray(arrays[key], float)[:3]
        need(P.shape == (3, 4) and np.isfinite(P).all() and np.linalg.det(P[:, :3]) != 0, f"{file}: {key}: expected a projection matrix")
        P = P * np.sign(np.linalg.det(P[:, :3]))  # Its sign is free; so the scene is before the camera.
        # K R by the QR decomposition of the rows in reverse order.
        q, r = np.linalg.qr(P[::-1, :3].T)
        K, R = r.T[::-1, ::-1], q.T[::-1]
        signs = np.sign(np.diag(K))
        K, R = K * signs, signs[:, None] * R
        return path, K / K[2, 2], size_of(path), [], rotation_near(R, f"{file}: {key}"), np.linalg.solve(K, P[:, 3])

    return [lambda i=i, path=path: read(i, path) for i, path in enumerate(images_in(folder))]


def poses(source, arguments):
    """Folders image, pose, intrinsic of 4x4 camera-to-world and 3x3 matrices; or NAME.pose.txt beside NAME.color.png."""
    root = pathlib.Path(source)
    first = lambda *names: next((root / name for name in names if (root / name).is_dir()), None)
    pose_folder = first("pose", "poses")
    folder = first("image", "images", "rgb", "color") if pose_folder else root
    need(folder, f"{root}: no folder image, images, rgb or color beside the poses")
    intrinsics = first("intrinsic", "intrinsics")
    need(arguments.focal or intrinsics, f"{root}: no folder intrinsic; give --focal F --center CX,CY")
    paths = images_in(folder)
    paths = [path for path in paths if path.stem.endswith(".color")] or paths

    def read(path):
        name = re.sub(r"\.color$", "", path.stem)
        file = pose_folder / (path.stem + ".txt") if pose_folder else folder / (name + ".pose.txt")
        if arguments.focal:
            K = [[arguments.focal, 0, arguments.center[0]], [0, arguments.focal, arguments.center[1]], [0, 0, 1]]
        else:
            K = numbers(intrinsics / (path.stem + ".txt"), 9, "a 3x3 matrix").reshape(3, 3)
        return path, K, size_of(path), [], *world_to_camera(numbers(file, 16, "a 4x4 matrix").reshape(4, 4), str(file))

    return [lambda path=path: read(path) for path in paths]


def matlab(path):
    from scipy.io import loadmat

    try:
        return loadmat(path)
    except (OSError, ValueError, NotImplementedError) as error:
        raise BadInput(f"{path}: {getattr(error, 'strerror', None) or error}") from None


def adelaidermf_matches(source, arguments):
    """NAME.mat with data (x1 y1 1 x2 y2 1 in columns), label (0: outlier), img1 and img2, a pair of images each."""
    need(os.path.isdir(source), f"{source}: no such folder")
    files = sorted(pathlib.Path(source).glob("*.mat"))
    need(files, f"{source}: no files *.mat")
    pairs = {}
    for path in files:
        content = matlab(path)
        data, label = (np.asarray(content.get(key, []), float) for key in ("data", "label"))
        need(data.ndim == 2 and len(data) == 6 and (data[[2, 5]] == 1).all(), f"{path}: expected a variable data, 6xN numbers x1 y1 1 x2 y2 1")
        need(label.size == data.shape[1] and (label >= 0).all() and (label == np.floor(label)).all(),
             f"{path}: expected a variable label, a whole number at least 0 for each column of data")
        sizes = [content[key].shape[:2] for key in ("img1", "img2") if key in content]
        need(len(sizes) == 2, f"{path}: expected the images img1 and img2")
        name = path.stem.replace("-", "_")
        pairs[f"{name}A-{name}B"] = data[[0, 1, 3, 4]].T.copy(), label.ravel().astype("i4"), np.array(sizes, "i4").ravel()
    folder = os.path.join(arguments.output, arguments.scene or "adelaidermf_matches")
    write_scene(folder, {name: {key: pair[part] for key, pair in pairs.items()} for part, name in enumerate(("matches", "labels", "sizes"))})
    print(f"convert: {folder}: {len(pairs)} pairs")


# Fundamental matrices that were fitted to the labelled matches (OpenCV's USAC_MAGSAC, 2 px), which those of the files miss.
REFITTED = {
    "napierb": [[1.386558066970109e-06, -3.640055453591526e-05, 0.011071302382660377],
                [3.699681584975637e-05, 1.230955235543768e-06, -0.02051304839881127],
                [-0.009580083861100212, 0.016603266993407466, -0.18557257814804484]],
    "neem": [[-2.781417796202435e-08, 2.463517710694504e-07, -1.530575508234141e-06],
             [2.214875941093008e-06, 1.1205859633995379e-08, -0.00644216585886457],
             [-0.0007431862849756304, 0.005795931391532775, 0.22212441698275254]]}


def explains(F, matches):
    """Whether four fifths of the matches lie within 3 px of F (Sampson's distance)."""
    first, second = (np.column_stack([part, np.ones(len(part))]) for part in (matches[:, :2], matches[:, 2:]))
    lines2, lines1 = first @ F.T, second @ F
    distances = abs((second * lines2).sum(1)) / np.sqrt((lines1[:, :2] ** 2).sum(1) + (lines2[:, :2] ** 2).sum(1))
    return (distances < 3).sum() >= 0.8 * len(matches)


def rows(path, width):
    lines = [(number, line.split()) for number, line in enumerate(read_text(path).splitlines(), 1)]
    for number, words in lines:
        need(not words or len(words) == width, f"{path}:{number}: expected {width} numbers, found {len(words)}")
    try:
        return np.array([words for _, words in lines if words], float).reshape(-1, width)
    except ValueError as error:
        raise BadInput(f"{path}: {error}") from None


def read_adelaidermf(source):
    """NAMEA.png, NAMEB.png, NAME_model.txt (F) and NAME_pts.txt (x1 y1 1 x2 y2 1 label); sift_update/NAME_pts.txt
    (a count, x1 y1 x2 y2) with NAME_score.txt (ratios): files of a scene of labelled matches, and of one of tentative ones."""
    need(os.path.isdir(source), f"{source}: no such folder")
    names = sorted(path.name[: -len("_model.txt")] for path in pathlib.Path(source).glob("*_model.txt"))
    need(names, f"{source}: no files NAME_model.txt")
    labelled_scene, tentative_scene = {}, {}

    def put(pair, scene, **values):
        for file, value in values.items():
            scene.setdefault(file, {})[pair] = value

    for name in names:
        prefix = os.path.join(source, name)
        labelled = rows(prefix + "_pts.txt", 7)
        need((labelled[:, [2, 5]] == 1).all() and (labelled[:, 6] >= 0).all(), f"{prefix}_pts.txt: expected x1 y1 1 x2 y2 1 label")
        matches, labels = labelled[:, [0, 1, 3, 4]], labelled[:, 6].astype("i4")
        given = numbers(prefix + "_model.txt", 9, "a 3x3 matrix").reshape(3, 3)
        found = [F for F in (given, np.array(REFITTED.get(name, given))) if explains(F, matches[labels > 0])]
        need(found, f"{prefix}_model.txt: it misses the labelled inliers")
        sizes = np.array([size_of(prefix + side)[::-1] for side in ("A.png", "B.png")], "i4").ravel()
        pair = "{0}A-{0}B".format(name.replace("-", "_"))
        put(pair, labelled_scene, labels=labels, sizes=sizes, Fgt=found[0], matches=matches)
        if not os.path.isdir(os.path.join(source, "sift_update")):
            continue
        prefix = os.path.join(source, "sift_update", name)
        count, _, rest = read_text(prefix + "_pts.txt").partition("\n")
        points = np.array(rest.split(), float).reshape(-1, 4)
        ratios = numbers(prefix + "_score.txt", len(points), f"{len(points)} ratios")
        need(count.strip() == str(len(points)), f"{prefix}_pts.txt:1: expected the number of rows that follow")
        put(pair, tentative_scene, match_conf=ratios, sizes=sizes, Fgt=found[0], matches=points)
    return labelled_scene, tentative_scene


def adelaidermf(source, arguments):
    """A scene of labelled matches, and one of tentative ones where there are some."""
    labelled, tentative = read_adelaidermf(source)
    scene = os.path.join(arguments.output, arguments.scene or "adelaidermf")
    for name, files in ((scene, labelled), (scene + "_sift", tentative)):
        if files:
            write_scene(name, files)
    print(f"convert: {scene}: {len(labelled['matches'])} pairs")


def adelaidermf_planes(source, arguments):
    """The tentative matches with the homography of their dominant labelled plane: two scenes, of the pairs at even and at odd places.
    planes.py says which pairs are left out."""
    labelled, tentative = read_adelaidermf(source)
    need(tentative, f"{source}: there is no folder sift_update")
    for first, ending in enumerate(("_even", "_odd")):
        files = {name: {} for name in ("Hgt", "sizes", "match_conf", "matches")}
        for pair in sorted(tentative["matches"])[first::2]:
            matches, sizes = tentative["matches"][pair], tentative["sizes"][pair]
            H, why = dominant_plane(labelled["matches"][pair], labelled["labels"][pair], matches, sizes)
            if H is None:
                print(f"convert: left out: {pair}, {why}", file=sys.stderr)
                continue
            for name in files:
                files[name][pair] = H if name == "Hgt" else tentative[name][pair]
        scene = os.path.join(arguments.output, (arguments.scene or "adelaidermf_planes") + ending)
        write_scene(scene, files)
        print(f"convert: {scene}: {len(files['matches'])} pairs")


def table(path):
    """Columns by name of a text with blanks between values; empty values are NaN."""
    rows = list(csv.reader(read_text(path).splitlines(), delimiter=" "))
    need(rows, f"{path}:1: expected the names of the columns")
    names = [name for name in rows[0] if name]
    values = [[float(word) for word in row if word] for row in rows[1:]]
    for number, row in enumerate(values, 2):
        need(len(row) == len(names), f"{path}:{number}: expected {len(names)} numbers")
    return {name: np.array([row[i] for row in values]) for i, name in enumerate(names)}


def columns(path, names):
    found = table(path)
    for name in names:
        need(name in found, f"{path}:1: there is no column {name}")
    return np.column_stack([found[name] for name in names])


def write_segments(arguments, images, beginnings):
    """images: name -> (segments, K, vanishing points), divided into scenes that begin at these places."""
    names = sorted(images)
    for (scene, first), last in zip(beginnings, [place for _, place in beginnings[1:]] + [len(names)]):
        if not names[first:last]:
            continue

        def fill(file):
            for name in names[first:last]:
                group = file.create_group(name)
                segments, K, points = images[name]
                for key, values in (("segments", segments), ("vanishing_points", points), ("K", K), ("size", [640.0, 480.0])):
                    if len(values) or key == "segments":
                        group.create_dataset(key, data=np.asarray(values, float))

        write_h5(os.path.join(arguments.output, scene, "segments.h5"), fill)
        print(f"convert: {os.path.join(arguments.output, scene)}: {len(names[first:last])} images")


ENDS = ["point1_x", "point1_y", "point2_x", "point2_y"]


def calibration(fx, fy, cx, cy):
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])


def files_of(folder, beginning):
    found = sorted(pathlib.Path(folder).glob(beginning + "*"))
    need(found, f"{folder}: there is no file {beginning}*")
    return found


def nyu_vp(source, arguments):
    """NYU-VP's folder data (Kluger et al., CVPR 2020): lsd_lines_*.csv, vps_*.csv; the Kinect's calibration (Silberman et al., 2012)."""
    K = calibration(518.85790117450188, 519.46961112127485, 325.58244941119034, 253.73616633400465)
    images = {}
    for path in files_of(source, "lsd_lines_"):
        name = path.stem[len("lsd_lines_"):]
        points = columns(pathlib.Path(source) / f"vps_{name}.csv", ["X", "Y"])
        images[name] = columns(path, ENDS), K, np.column_stack([points, np.ones(len(points))])
    write_segments(arguments, images, [("nyu_vp_train", 0), ("nyu_vp_val", 1000), ("nyu_vp_test", 1224)])


def yud_plus(source, arguments):
    """YUD+'s folder data (the same): lines/*, vps/*GroundTruthVP_CamParams.mat; York Urban's calibration (Denis et al., 2008)."""
    focal = 6.05317058975369 / 0.00896875
    K = calibration(focal, focal, 307.551305282635, 251.454244960136)
    images = {}
    for path in files_of(pathlib.Path(source) / "lines", "P"):
        file = pathlib.Path(source) / "vps" / f"{path.stem}GroundTruthVP_CamParams.mat"
        directions = np.asarray(matlab(file).get("vp", []), float)
        need(directions.ndim == 2 and len(directions) == 3 and directions.size, f"{file}: expected a variable vp, 3xK numbers")
        images[path.stem] = columns(path, ENDS), K, (K @ (directions * [[1], [-1], [1]])).T  # Their y axis points up.
    write_segments(arguments, images, [("yud_plus_train", 0), ("yud_plus_test", 25)])


def matches(source, arguments):
    """N x 4 to 7 numbers as diffsac_pair --matches writes them; or SuperGlue's .npz: keypoints0, keypoints1, matches, match_confidence."""
    names = ["x1", "y1", "x2", "y2", "ratio", "log_size", "angle"]
    loaded = numpy_file(source)
    if isinstance(loaded, np.lib.npyio.NpzFile) and {"keypoints0", "keypoints1", "matches"} <= set(loaded.files):
        first, second, other = loaded["keypoints0"], loaded["keypoints1"], loaded["matches"]
        need(other.shape == (len(first),) and (other < len(second)).all(), f"{source}: expected one of keypoints1 for each of keypoints0, or -1")
        kept = other >= 0
        values, names = np.column_stack([first[kept], second[other[kept]]]), names[:4]
        if "match_confidence" in loaded.files:
            values, names = np.column_stack([values, loaded["match_confidence"][kept]]), [*names, "score"]
    else:
        values, names = one_array(source, loaded, names, (4, 5, 7), "one array, or keypoints0, keypoints1 and matches")
    write_table(arguments.output, values, names)


def matrix(source, arguments):
    """A calibration matrix as text."""
    loaded = numpy_file(source)
    need(getattr(loaded, "shape", None) == (3, 3) and loaded.dtype.kind in "fiu", f"{source}: expected one array of 3 x 3 numbers")
    np.savetxt(arguments.output, loaded, fmt="%.17g")


def numpy_file(source):
    try:
        return np.load(source, allow_pickle=False)
    except (ValueError, EOFError) as error:
        raise BadInput(f"{source}: no NumPy file of numbers: {error}") from None


def one_array(source, loaded, names, widths, expected):
    if isinstance(loaded, np.lib.npyio.NpzFile):
        need(len(loaded.files) == 1, f"{source}: expected {expected}; found {', '.join(loaded.files)}")
        loaded = loaded[loaded.files[0]]
    counts = f"{', '.join(map(str, widths[:-1]))} or {widths[-1]}"
    fits = loaded.ndim == 2 and loaded.shape[1] in widths and loaded.dtype.kind in "fiub"
    need(fits, f"{source}: expected N x {counts} numbers, found {loaded.shape} of {loaded.dtype}")
    return loaded, names[: loaded.shape[1]]


def write_table(path, values, names):
    np.savetxt(path, np.asarray(values, float), delimiter=",", header=",".join(names), comments="", fmt="%.17g")


def registration(source, arguments):
    """Matches of clouds with the motion between them, as the repositories of TCF, TurboReg and MAC++ have them, with the limits of
    their benchmarks: inliers within, and a motion right within so many degrees and metres."""
    root, pairs = pathlib.Path(source), []
    for path in sorted(root.glob("data/*/*/*_top3.match")):  # TCF
        first, second = path.name.split("_")[:2]
        limits, scene = ((0.6, 5, 0.6), "tcf_kitti") if "KITTI" in path.parts else ((0.2, 5, 0.3), "tcf_eth")
        pairs.append((scene, f"{first}_{second}", [path], path.with_name(f"{first}-{second}.pose"), limits))
    for path in sorted(root.glob("demo_data/*_trans.txt")):  # TurboReg
        name = path.name[: -len("_trans.txt")]
        pairs.append(("turboreg_kitti", name, [path.with_name(f"{name}_fpfh_kpts_{side}.txt") for side in ("src", "dst")], path, (0.6, 5, 0.6)))
    if (root / "demo" / "corr.txt").exists():  # MAC++
        pairs.append(("macpp", "demo", [root / "demo" / "corr.txt"], root / "demo" / "GTmat.txt", (0.1, 15, 0.3)))
    need(pairs, f"{source}: neither data/*/*/*_top3.match nor demo_data/*_trans.txt nor demo/corr.txt")
    for scene in sorted({pair[0] for pair in pairs}):
        content = {}
        for _, name, files, truth, limits in (pair for pair in pairs if pair[0] == scene):
            parts = [rows(file, 6 // len(files)) for file in files]
            need(len(parts[0]) == len(parts[-1]), f"{files[0]}: expected as many rows as in {files[-1]}, {len(parts[-1])}, found {len(parts[0])}")
            values = numbers(truth, (12, 16), "a 3x4 or 4x4 matrix")[:12].reshape(3, 4)
            motion = np.column_stack([rotation_near(values[:, :3], truth), values[:, 3]])
            content[name] = {"points": np.hstack(parts), "motion": motion, "limits": np.array(limits)}

        def fill(file):
            for name, values in content.items():
                for key, value in values.items():
                    file.create_dataset(f"{name}/{key}", data=value)

        write_h5(os.path.join(arguments.output, scene, "cloud_matches.h5"), fill)
        print(f"convert: {arguments.output}/{scene}: {len(content)} pairs")


POSED = {f.__name__: f for f in (nerf, llff, strecha, middlebury, projections, poses)}
SCENES = {f.__name__: f for f in (adelaidermf, adelaidermf_planes, adelaidermf_matches, hloc, nyu_vp, yud_plus, matches, matrix, registration,
                                  from_images.colmap_points)}


def words_of(text):
    return text.split(",")


def add_converters(commands):
    for name, reader in {**POSED, **SCENES}.items():
        command = commands.add_parser(name, help=" ".join((reader.__doc__ or "").split()).replace("%", "%%"))
        command.add_argument("input")
        command.add_argument("output")
        command.add_argument("--scene", default="", help="the scene's name")
        command.add_argument("--focal", type=float, default=0, help="poses, hloc: focal length of all images, pixels")
        command.add_argument("--center", type=lambda text: [float(word) for word in words_of(text)], default=[], help="CX,CY, pixels")
        command.add_argument("--calibration", default="", help="hloc: a file with the 3x3 matrix K of all images")
        command.add_argument("--features", default="", help="hloc: the file of features, where there are several beside the matches")
        command.set_defaults(run=lambda arguments, name=name: convert(name, arguments))


def convert(name, arguments):
    need(not arguments.focal or len(arguments.center) == 2, "--focal needs --center CX,CY")
    if name in SCENES:
        return SCENES[name](arguments.input, arguments)
    model = Model()
    for read in POSED[name](arguments.input, arguments):
        model.add(read)
    model.write(arguments.output)


def add_tools(commands):
    made = commands.add_parser("sets", help="makes the matches of the image sets that a file lists, by diffsac_prepare")
    made.add_argument("--config", required=True, help="a list of image sets (configs/sets.yaml)")
    made.add_argument("--data", required=True, help="the folder of the image sets")
    made.add_argument("--only", type=words_of, default=[], help="sets by name (* for any text), or by the folders that they make")
    made.add_argument("--threads", default="0", help="of diffsac_prepare; 0: all cores")
    made.add_argument("--program", default="", help="diffsac_prepare (default: that of PATH, or build/release/bin)")
    made.set_defaults(run=image_sets.sets)
    seen = commands.add_parser("inspect", help="counts, inliers and checks of scenes of matches; a picture of one pair")
    seen.add_argument("folders", nargs="+", help="scenes, or folders of scenes")
    seen.add_argument("--threshold-px", type=float, default=1, help="distance to the truth that counts as an inlier")
    seen.add_argument("--picture", default="", help="draw the matches of one pair into this file instead")
    seen.add_argument("--pair", default="", help="img1-img2 (default: the first)")
    seen.add_argument("--images", default="", help="folder of the pair's images (default: white)")
    seen.set_defaults(run=inspect_scenes.inspect)
    described = commands.add_parser("tutorial", help="adds descriptors to a scene of the tutorial, from its images")
    described.add_argument("scene", help="its folder, ROOT/split/scene")
    described.add_argument("--images", default="", help="folder of its images (default: images in the scene's)")
    described.add_argument("--features", choices=["sift", "rootsift"], default="rootsift")
    described.add_argument("--max-image-size", type=int, default=0, help="larger images are reduced to this side; 0: never")
    described.add_argument("--overwrite", action="store_true", help="make descriptors again that are there already")
    described.set_defaults(run=from_images.tutorial)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="format", required=True)
    add_converters(commands)
    add_tools(commands)
    arguments = parser.parse_args()
    try:
        arguments.run(arguments)
    except (BadInput, OSError) as error:
        print(f"convert: {error}", file=sys.stderr)
        sys.exit(2)


if __name__ == "__main__":
    main()
