#!/usr/bin/env python3
"""ALIKED's or R2D2's keypoints and descriptors, found by their authors' code and weights, in a file as hloc writes it, which
`diffsac_prepare pairs --import-descriptors` and the sets of configs/sets.yaml read (data_tools/README.md). One thread of the CPU.

  extract_features.py --features aliked --checkout ALIKED --images DIR [--only PATTERN] [--every N] [--pairs-file FILE] --output OUT.h5
  extract_features.py --features r2d2   --checkout R2D2   ...

DIR is a folder of images (those in folders below it are not taken): of those that match PATTERN every N-th in the order of their names,
or those that FILE names, two in each line. Images that OUT.h5 has stay in it. Not part of the build, and nothing of these checkouts is
part of this repository:

  ALIKED  Shiaoming/ALIKED at 683d7c65197395c0b3f01ebe76e1084a27e73a65, BSD-3, models/aliked-n16.pth; Zhao and others, TIM 2023
  R2D2    naver/r2d2 at 0ff8f6afcbea91f19613d0cb7d93143a977830f5, CC BY-NC-SA 3.0, models/r2d2_WASF_N16.pt; Revaud and others, NeurIPS 2019

Measured with Python 3.11, torch 2.4.1, torchvision 0.19.1, numpy 1.26.4, h5py 3.11.0, opencv-python-headless 4.10.0.84, pillow 10.4.0.
"""
import argparse
import fnmatch
import os
import sys

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[threads] = "1"
import time
import warnings

import cv2
import h5py
import numpy as np
import torch

from peer_pairs import IMAGE_ENDINGS, listed_pairs


def fail(message):
    sys.exit(f"extract_features.py: {message}")


def load_on_cpu(path, *_, load=torch.load):
    return load(path, map_location="cpu", weights_only=True)


def aliked(arguments):
    """ALIKED-N16 with its authors' threshold. Its deformable descriptors need no compiled operator: where `custom_ops` cannot be
    imported it takes patches by indexing."""
    sys.modules["custom_ops"] = None
    torch.cuda.synchronize = lambda: None    # its forward pass waits for a GPU that is not there
    from nets.aliked import ALIKED
    model = ALIKED("aliked-n16", device="cpu", n_limit=arguments.max_keypoints)

    def extract(image):
        found = model.run(image)
        return found["keypoints"], found["descriptors"], found["scores"]
    return extract


def r2d2(arguments):
    """R2D2 at several scales, with the settings of its authors' extract.py."""
    from extract import NonMaxSuppression, extract_multiscale, load_network
    from tools.dataloader import norm_RGB
    network, detector = load_network(os.path.join(arguments.checkout, "models/r2d2_WASF_N16.pt")), NonMaxSuppression()

    def extract(image):
        places, descriptors, scores = (part.numpy() for part in extract_multiscale(network, norm_RGB(image)[None], detector))
        best = np.argsort(-scores, kind="stable")[:arguments.max_keypoints]
        return places[best, :2], descriptors[best], scores[best]
    return extract


FEATURES = {"aliked": aliked, "r2d2": r2d2}
LONGEST_SIDE = {"aliked": 1024, "r2d2": 640}


def names_of(arguments):
    names = sorted(n for n in os.listdir(arguments.images) if n.lower().endswith(IMAGE_ENDINGS) and fnmatch.fnmatch(n, arguments.only))
    if not names:
        fail(f"{arguments.images}: no images {arguments.only}")
    if arguments.pairs_file:
        asked = {name for pair in listed_pairs(arguments.pairs_file) for name in pair}
        if asked - set(names):
            fail(f"{arguments.images}: no image {sorted(asked - set(names))[0]}, which {arguments.pairs_file} names")
        return sorted(asked)
    return names[::arguments.every]


def features_of(path, extract, longest_side):
    """Keypoints in pixels of the image as it is stored; resizing keeps the corners of the images, not the centres of their pixels."""
    image = cv2.imread(path, cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
    if image is None:
        return None
    size = np.array(image.shape[1::-1])
    smaller = np.maximum(1, np.round(size * min(1.0, longest_side / size.max()))).astype(int)
    if (smaller != size).any():
        image = cv2.resize(image, [int(v) for v in smaller], interpolation=cv2.INTER_AREA)
    keypoints, descriptors, scores = extract(cv2.cvtColor(image, cv2.COLOR_BGR2RGB))
    return {"keypoints": ((keypoints + 0.5) * (size / smaller) - 0.5).astype(np.float32), "descriptors": descriptors.T.astype(np.float32),
            "scores": scores.astype(np.float32), "image_size": size}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--features", required=True, choices=FEATURES)
    parser.add_argument("--checkout", required=True, help="the authors' repository")
    parser.add_argument("--images", required=True)
    parser.add_argument("--only", default="*")
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--pairs-file")
    parser.add_argument("--longest-side", type=int, help="pixels; larger images are reduced to it (1024 for ALIKED, 640 for R2D2)")
    parser.add_argument("--max-keypoints", type=int, default=2048, help="the strongest")
    parser.add_argument("--output", required=True)
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    torch.set_grad_enabled(False)
    torch.load = load_on_cpu
    warnings.filterwarnings("ignore")    # of the authors' calls, which newer versions of torch would write in another way
    cv2.setNumThreads(1)
    for path in (arguments.checkout, arguments.images):
        os.path.isdir(path) or fail(f"{path}: no such folder")
    names = names_of(arguments)
    sys.path.insert(0, arguments.checkout)
    extract = FEATURES[arguments.features](arguments)
    os.makedirs(os.path.dirname(os.path.abspath(arguments.output)), exist_ok=True)
    seconds, counts = [], []
    with h5py.File(arguments.output, "a") as file:
        for name in names:
            if name in file:
                continue
            start = time.process_time()
            features = features_of(os.path.join(arguments.images, name), extract, arguments.longest_side or LONGEST_SIDE[arguments.features])
            if features is None:
                print(f"left out: {name}: not an image that can be read", file=sys.stderr)
                continue
            seconds.append(time.process_time() - start)
            counts.append(len(features["scores"]))
            for key, values in features.items():
                file[f"{name}/{key}"] = values
            file.flush()
    if counts:
        print(f"{arguments.output}: {len(counts)} images, {np.median(counts):.0f} keypoints (median), {np.mean(seconds):.2f} s an image")


if __name__ == "__main__":
    main()
