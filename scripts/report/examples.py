"""Reads estimates.h5 (estimates, examples with their points, fits) and the photographs of examples."""
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
    """Examples of estimates.h5 (docs/estimates.md): problems with their points, in the order of the data."""

    def __init__(self, group):
        self._group, self.json = group, json.loads(group["json"][()].tobytes())

    def __len__(self):
        return len(self.json["examples"])

    def _rows(self, name, number):
        rows = self._group.get(f"{name}-{number}")
        return None if rows is None else rows[()]

    def at(self, number, in_image=False):
        """Returns an example. `in_image` takes the points' positions in the image, if the problem has one."""
        points, inliers = self._rows("image_points", number) if in_image else None, self._rows("inliers", number)
        points = self._rows("points", number) if points is None else points
        points = np.zeros((0, 2)) if points is None else points
        return Example(self.json["examples"][number], points, None if inliers is None else inliers != 0)

    def source(self, number):
        """All points of a user's file, including those that max_points left out."""
        source = self._rows("source", number)
        return self._rows("points", number) if source is None else source

    def has_image(self, number):
        return f"image_points-{number}" in self._group


class Estimates:
    """Estimates of one method on one condition."""

    def __init__(self, group):
        self._group, self._read = group, {}
        self.at = {int(index): i for i, index in enumerate(self._column("index"))}

    def __len__(self):
        return len(self.at)

    def _column(self, name):
        if name not in self._read:
            self._read[name] = self._group[name][()] if name in self._group else None
        return self._read[name]

    def value(self, name, i):
        column = self._column(name)
        return None if column is None else column[i]

    def text(self, name, i):
        value = self.value(name, i)
        return "" if value is None else value.decode()

    def _list(self, name, i, ends="", otherwise=()):
        values, ends = self._column(name), self._column(ends or name + "_end")
        return np.array(otherwise) if values is None else values[ends[i - 1] if i else 0:ends[i]]

    def model(self, i):
        """Model parameters without padding."""
        model = self.value("model", i)
        return model[:np.flatnonzero(np.isfinite(model))[-1] + 1] if np.isfinite(model).any() else model[:0]

    def inliers(self, i):
        return self._list("inliers", i)

    def mask(self, i, points):
        mask = np.zeros(points, dtype=bool)
        mask[self.inliers(i)] = True
        return mask

    def structures(self, i):
        return self._list("structures", i)

    def labels(self, i):
        return self._list("labels", i, otherwise=np.zeros(0, int))

    def rows(self, i):
        return self._list("rows", i, otherwise=np.zeros(0, int))


class Fits:
    """Fits selected by `figures`, and the reverse steps of one problem."""

    def __init__(self, run, file):
        self.run, self.file = run, file
        figures, facts = run.told("figures", {}), run.facts
        self._names = [one["name"] for one in facts["methods"]]
        self._two_ends = facts["two_view"] or facts["task"] == "vanishing_point"  # Drawn from one end to the other.
        self.qualitative = int(figures.get("qualitative", 1))
        rows = self._rows(figures)
        self.label = facts["methods"][rows[0]]["label"] if rows else ""
        self.fits = [fit for c in self._conditions(figures) for m in rows for number in self._numbers(c) for fit in self._fit(number, c, m)]
        named = figures.get("confidence_condition", "")
        conditions = [one["name"] for one in facts["conditions"]]
        shown = conditions.index(named) if named in conditions else len(conditions) // 2
        self.trace = next(({**one, "downwards": facts["two_view"] or file.has_image(one["example"])} for one in file.json["traces"] if one["condition"] == shown), None)

    def _conditions(self, figures):
        """Named conditions, or up to four, evenly spread."""
        names = [one["name"] for one in self.run.facts["conditions"]]
        named = figures.get("qualitative_conditions", [])
        return [c for c, name in enumerate(names) if name in named] if named else evenly_chosen(range(len(names)))

    def _rows(self, figures):
        """Named methods, or the first that are not `oracle`: three for two views, else one."""
        named = figures.get("qualitative_methods") or [name for name in [figures.get("qualitative_method", "")] if name]
        first = [m for m, one in enumerate(self.run.facts["methods"]) if one["type"] != "oracle"][:3 if self.run.facts["two_view"] else 1]
        return [self._names.index(name) for name in named if name in self._names] if named else first

    def _numbers(self, condition):
        """First examples of a condition; for two views, whose data is ordered by scene, evenly spread ones."""
        own = [number for number, one in enumerate(self.file.json["examples"]) if one["condition"] == condition]
        count = min(self.qualitative, len(own))
        return [own[i * len(own) // count] for i in range(count)] if self.run.facts["two_view"] else own[:count]

    def _fit(self, number, condition, method):
        facts, estimates = self.file.json["examples"][number], self.run.estimates.get((condition, method))
        i = None if estimates is None else estimates.at.get(facts["index"])
        line = self.run.line_of(condition, method, facts["index"])
        if i is None or line is None:
            return
        error = {name: none_if_nan(line.get(name)) for name in ("angle_deg", "rotation_deg", "translation_deg", "error_px", "recall", "misclassified")}
        count = len(self.file.at(number).points)
        fit = {"example": number, "condition": condition, "method": method, "status": line["status"], "model": list(estimates.model(i)),
               "inliers": estimates.mask(i, count).astype(int).tolist() if line["status"] == "ok" else [], "true_model": numbers(facts["true_model"]),
               "shown_error": error["misclassified"] if error["misclassified"] is not None else error["error_px" if "threshold_px" in self.run.facts else "angle_deg"],
               "error": {**error, "failed": bool(line["failed"])}, "downwards": self.file.has_image(number)}
        models, labels = estimates.structures(i), estimates.labels(i)
        if len(models) or facts.get("true_models"):
            labels = labels if len(labels) == count else estimates.mask(i, count).astype(int)
            models = list(models) or ([fit["model"]] if line["status"] == "ok" else [])
            fit["structures"] = {"models": models, "labels": labels, "true_models": [numbers(one) for one in facts.get("true_models", [])]}
            if len(facts.get("true_labels", ())) == count:
                fit["structures"]["true_labels"] = aligned_truth(labels, np.array(facts["true_labels"]))
        yield fit

    def example(self, fit):
        example = self.file.at(fit["example"], in_image=not self._two_ends or "timesteps" in fit)
        if "timesteps" in fit and self.run.facts["two_view"]:
            example.points = example.points[:, :2]  # Of the first image.
        return example


def numbers(values):
    """Converts JSON numbers, where null is NaN and "inf" infinity."""
    return [float("nan" if value is None else value) for value in values]


def none_if_nan(value):
    return None if value is None or value != value else value


def evenly_chosen(items, most=4):
    """Selects at most `most` items, evenly spread, including the first and the last."""
    if len(items) <= most:
        return list(items)
    return [items[i * (len(items) - 1) // (most - 1)] for i in range(most)]


def aligned_truth(found, truth):
    """Renumbers the true labels by the best-matching found structures. Unmatched ones get new numbers."""
    from scipy.optimize import linear_sum_assignment

    common = np.zeros((truth.max(initial=0), found.max(initial=0)))
    both = (found > 0) & (truth > 0)
    np.add.at(common, (truth[both] - 1, found[both] - 1), 1)
    number, unmatched = np.zeros(len(common) + 1, int), found.max(initial=0)
    rows, partners = linear_sum_assignment(-common)
    number[1:][rows] = partners + 1
    for k in np.flatnonzero(number[1:] == 0) + 1:
        unmatched += 1
        number[k] = unmatched
    return number[truth]


def open_estimates(run):
    """Returns Estimates by (condition, method), and the ExampleFile or None."""
    if not os.path.exists(run.path("estimates.h5")):
        return {}, None
    file = h5py.File(run.path("estimates.h5"), "r")
    places = {(group.attrs["condition"], group.attrs["method"]): group
              for name, methods in file.items() if name != "examples" for group in methods.values()}
    names = {(c, m): (condition["name"], method["name"]) for c, condition in enumerate(run.facts["conditions"])
             for m, method in enumerate(run.facts["methods"])}
    found = {place: Estimates(places[name]) for place, name in names.items() if name in places}
    return found, ExampleFile(file["examples"]) if "examples" in file else None


def open_fits(run):
    """Returns the fits, with several seeds the first one's; None without examples."""
    run = run.parts[0] if run.parts else run
    return Fits(run, run.examples) if run.examples else None


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
