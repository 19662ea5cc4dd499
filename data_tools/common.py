"""What the converters of this folder share."""

import os
import pathlib

import h5py
import numpy as np

IMAGES = {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".ppm", ".pgm", ".webp"}


class BadInput(Exception):
    """What is wrong, with the file that it is wrong in."""


def need(truth, message):
    if not truth:
        raise BadInput(message)


def read_text(path):
    try:
        return pathlib.Path(path).read_text()
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(f"{path}: {getattr(error, 'strerror', None) or 'no text'}") from None


def numbers(path, count, what):
    try:
        values = [float(word) for word in read_text(path).replace(",", " ").split()]
    except ValueError as error:
        raise BadInput(f"{path}: {error}") from None
    need(len(values) in np.atleast_1d(count), f"{path}: expected {what}, found {len(values)} numbers")
    return np.array(values)


def images_in(folder):
    need(os.path.isdir(folder), f"{folder}: no such folder")
    found = sorted(path for path in pathlib.Path(folder).iterdir() if path.suffix.lower() in IMAGES)
    need(found, f"{folder}: no images in this folder")
    return found


def size_of(path):
    from PIL import Image

    try:
        with Image.open(path) as image:
            return image.size
    except OSError as error:
        raise BadInput(f"{path}: {error.strerror or 'no image'}") from None


def write_h5(path, fill):
    """A file that is there whole or not at all."""
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with h5py.File(str(path) + ".part", "w") as file:
        fill(file)
    os.replace(str(path) + ".part", path)


SCENE_FILES = ("match_conf", "match_scores", "similarities", "K1_K2", "R", "T", "Egt", "Fgt", "Hgt", "sizes", "descriptors", "labels", "match_indices")


def write_scene(folder, files):
    """files: name of the file -> pair (of R and T: image) -> values. What another run left there goes; matches.h5 is last: it says that
    the scene is whole."""
    for name in ("matches", *SCENE_FILES):
        pathlib.Path(folder, name + ".h5").unlink(missing_ok=True)
    for name in sorted(files, key=lambda name: name == "matches"):
        write_h5(os.path.join(folder, name + ".h5"), lambda file: [file.create_dataset(key, data=value) for key, value in files[name].items()])


def what_all_have(files):
    """The files that hold all pairs of matches.h5; those of some pairs alone are left out."""
    return {name: values for name, values in files.items() if len(values) == len(files["matches"])}


def open_h5(path):
    need(os.path.isfile(path), f"{path}: no such file")
    try:
        return h5py.File(path, "r")
    except OSError as error:
        raise BadInput(f"{path}: not a readable HDF5 file, or truncated: {error}") from None


def read_h5(file, key):
    """The numbers of a data set; None where there is none."""
    place = f"{file.filename}: {key}"
    try:
        if key not in file:
            return None
        values = file[key][()]
    except (OSError, RuntimeError) as error:
        raise BadInput(f"{place}: damaged or truncated: {error}") from None
    need(isinstance(values, (np.ndarray, np.generic)) and values.dtype.kind in "fiub", f"{place}: expected numbers")
    return np.asarray(values, float)


def given_camera(arguments):
    """K by --calibration, or --focal and --center; None where nothing is given."""
    if arguments.calibration:
        return numbers(arguments.calibration, 9, "a 3x3 matrix").reshape(3, 3)
    if not arguments.focal:
        return None
    need(len(arguments.center) == 2, "--focal needs --center CX,CY")
    return np.array([[arguments.focal, 0, arguments.center[0]], [0, arguments.focal, arguments.center[1]], [0, 0, 1]])
