"""fits.h5 and pairs.h5 (lib/lab/eval/example_files.h), and the photographs of their images."""
import fnmatch
import io
import json
import os

import h5py
import numpy as np

MOST_PIXELS_AWAY = 1e5  # Points farther out do not make a canvas larger.


class Example:
    def __init__(self, facts, points, inliers):
        self.points, self.inliers = points, inliers  # Rows; whether each is a true inlier, or None.
        self.id, self.name, self.scene, self.folder = (facts[key] for key in ("id", "name", "scene", "folder"))
        # `name` is unique, as problems.csv has it.
        self.condition, self.index = facts["condition"], facts["index"]
        self.images = (facts["image1"], facts["image2"])
        self.known_sizes = (facts["size1"], facts["size2"])

    def size(self, side):
        """Of a canvas for an image's points: the image's, or else the box of its points from (0, 0) on."""
        width, height = self.known_sizes[side]
        if width > 0 and height > 0:
            return width, height
        finite = self.points[np.isfinite(self.points).all(axis=1)][:, 2 * side:2 * side + 2]
        return tuple(int(min(value, MOST_PIXELS_AWAY)) + 1 for value in np.maximum(finite.max(axis=0), 0)) if len(finite) else (1, 1)


class ExampleFile:
    def __init__(self, path):
        self._file = h5py.File(path, "r")
        self.json = json.loads(self._file["json"][()].tobytes())
        self.fits = self.json.get("fits", [])

    def __len__(self):
        return len(self.json["examples"])

    def at(self, number):
        inliers = self._file.get(f"inliers-{number}")
        return Example(self.json["examples"][number], self._file[f"points-{number}"][()], None if inliers is None else inliers[()] != 0)

    def example(self, fit):
        return self.at(fit["example"])


def open_examples(run, name):
    path = run.path(name)
    return ExampleFile(path) if os.path.exists(path) else None


def image_file(folders, scene, image):
    """The file of an image by the scene's folder (`figures.images`), whatever its extension; None when there is none."""
    from PIL import Image

    for folder in folders:
        if not image or not fnmatch.fnmatchcase(scene, folder["scenes"]) or not os.path.isdir(folder["folder"]):
            continue
        for name in sorted(os.listdir(folder["folder"])):
            stem, extension = os.path.splitext(name)
            if stem == image and extension.lower() in Image.registered_extensions():
                return os.path.join(folder["folder"], name)
    return None


def load_image(folders, example, side, longest):
    """An image in colour, made smaller than `longest`: the file's, or else the small copy in the scene's folder. None where
    there is none or it cannot be read."""
    from PIL import Image

    path = image_file(folders, example.scene, example.images[side])
    try:
        image = Image.open(path) if path else Image.open(io.BytesIO(_thumbnail(example.folder, example.images[side])))
        image.draft("RGB", (longest, longest))  # A JPEG of many megapixels is read several times faster at a part of its size.
        if image.mode.startswith("I;16") or image.mode == "I":  # Of 16 bits.
            image = Image.fromarray((np.asarray(image) >> 8).astype(np.uint8))
        image = image.convert("RGB")
        image.thumbnail((longest, longest), Image.Resampling.BOX if max(image.size) > 4 * longest else Image.Resampling.LANCZOS)
        return image
    except Exception:  # Of a file that is damaged, as of none, the matches stand on grey.
        return None


def _thumbnail(folder, image):
    with h5py.File(os.path.join(folder, "thumbnails.h5"), "r") as file:
        return file[image][()].tobytes()
