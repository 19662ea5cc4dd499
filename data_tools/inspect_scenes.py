"""What stands in scenes of matches: counts, share of matches near the truth, checks; and a picture of a pair's matches."""

import os
import pathlib
import sys

import numpy as np

from common import SCENE_FILES, need, open_h5, read_h5

OUTSIDE, DISAGREEMENT, MOST_SHOWN, MOST_LINES, WIDEST = 0.1, 1e-4, 20, 60, 2400


class Pair:
    """Its matches, what is known of it, and the distances of the matches from its true model."""

    def __init__(self, files, name):
        read = lambda key, what=name: read_h5(files[key], what) if key in files else None
        for key, shape in (("matches", (-1, 4)), ("similarities", (-1, 2)), ("sizes", (4,)), ("Egt", (3, 3)), ("Fgt", (3, 3)), ("Hgt", (3, 3)), ("K1_K2", (2, 3, 3))):
            values = read(key)
            place = f"{files[key].filename}: {name}" if key in files else ""
            need(key not in files or values is not None, f"{place}: there is no such pair")
            need(values is None or shape[0] < 0 and values.shape[1:] == shape[1:] or values.size == np.prod(shape), f"{place}: expected {shape}, found {np.shape(values)}")
            setattr(self, key, values if values is None else values.reshape(shape))
        self.name, self.images = name, name.split("-") if name.count("-") == 1 else ["", ""]
        self.scored = "match_scores" in files
        self.quality, self.labels = read("match_scores" if self.scored else "match_conf"), read("labels")
        poses = [(read("R", image), read("T", image)) for image in self.images] if "R" in files and "T" in files else []
        self.has_pose = len(poses) == 2 and all(value is not None for pose in poses for value in pose)
        self.motion_essential = None
        if self.has_pose:
            (R1, t1), (R2, t2) = ((R.reshape(3, 3), t.ravel()) for R, t in poses)
            R = R2 @ R1.T
            self.motion_essential = cross(t2 - R @ t1) @ R
        self.E, self.F = (self.Egt if self.Egt is not None else self.motion_essential), self.Fgt
        if self.K1_K2 is not None:
            K1, K2 = self.K1_K2
            self.E = K2.T @ self.F @ K1 if self.E is None and self.F is not None else self.E
            self.F = np.linalg.inv(K2).T @ self.E @ np.linalg.inv(K1) if self.F is None and self.E is not None else self.F
        self.distances = self._distances()

    def _distances(self):
        """Transfer errors of H, else Sampson's of F; None where the truth is not known."""
        first, second = (np.column_stack([side, np.ones(len(side))]) for side in (self.matches[:, :2], self.matches[:, 2:]))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            if self.Hgt is not None:
                moved = first @ self.Hgt.T
                distances = np.linalg.norm(moved[:, :2] / moved[:, 2:] - second[:, :2], axis=1)
            elif self.F is not None:
                lines2, lines1 = first @ self.F.T, second @ self.F
                distances = abs((second * lines2).sum(1)) / np.sqrt((lines1[:, :2] ** 2).sum(1) + (lines2[:, :2] ** 2).sum(1))
            else:
                return None
        return np.where(np.isfinite(distances), distances, np.inf)

    def contents(self):
        has = (("score" if self.scored else "ratio", self.quality), ("similarities", self.similarities), ("sizes", self.sizes), ("K", self.K1_K2),
               ("pose", self.motion_essential), ("E", self.E), ("F", self.F), ("H", self.Hgt), ("labels", self.labels))
        return " ".join(name for name, value in has if value is not None)

    def problems(self, threshold):
        m = self.matches
        if not np.isfinite(m).all():
            yield "a coordinate is not finite"
        if self.sizes is not None:
            size = np.array([self.sizes[1], self.sizes[0], self.sizes[3], self.sizes[2]])
            if not ((m > -OUTSIDE * size) & (m < (1 + OUTSIDE) * size)).all():
                yield "a point lies outside its image"
        if self.quality is not None and not ((self.quality >= 0) & (self.quality <= 1)).all():
            yield f"a {'score' if self.scored else 'ratio'} is not in [0, 1]"
        agree = lambda a, b: 1 - abs((a * b).sum()) / (np.linalg.norm(a) * np.linalg.norm(b)) < DISAGREEMENT
        through_K = None if self.K1_K2 is None or self.F is None else self.K1_K2[1].T @ self.F @ self.K1_K2[0]
        if (self.has_pose and not agree(self.motion_essential, self.E)) or (through_K is not None and self.E is not None and not agree(through_K, self.E)):
            yield "E, F, the poses and K disagree"
        if self.distances is not None and not (self.distances <= threshold).any():
            yield "no match is near the truth"


def cross(t):
    return np.array([[0, -t[2], t[1]], [t[2], 0, -t[0]], [-t[1], t[0], 0]])


def scenes_in(root):
    need(os.path.isdir(root), f"{root}: no such folder")
    if os.path.exists(os.path.join(root, "matches.h5")):
        return [root]
    found = sorted(str(path.parent) for path in pathlib.Path(root).glob("*/matches.h5"))
    need(found, f"{root}: no matches.h5 in it or in a folder directly below")
    return found


def files_of(scene):
    return {name: open_h5(path) for name in ("matches", *SCENE_FILES) if (path := os.path.join(scene, name + ".h5")) and os.path.exists(path)}


def spread(values, *shares):
    ordered = np.sort(values)
    return [ordered[int(share * (len(ordered) - 1) + 0.5)] for share in shares]


def row_of(scene, threshold, problems):
    files = files_of(scene)
    pairs = [Pair(files, name) for name in sorted(files["matches"])]
    need(pairs, f"{scene}: there is no pair")
    name, bad = os.path.basename(os.path.abspath(scene)), [f"{pair.name}: {problem}" for pair in pairs for problem in pair.problems(threshold)]
    problems += [f"{name}: {text}" for text in bad[:MOST_SHOWN]] + ([f"{name}: and {len(bad) - MOST_SHOWN} more"] if len(bad) > MOST_SHOWN else [])
    shares = [(pair.distances <= threshold).sum() / max(1, len(pair.matches)) for pair in pairs if pair.distances is not None]
    labelled = [(pair.labels > 0).sum() / max(1, len(pair.matches)) for pair in pairs if pair.labels is not None]
    repeats = sum(len(m) - len(np.unique(m, axis=0)) for m in (pair.matches[np.isfinite(pair.matches).all(1)] for pair in pairs))
    percent = lambda values: "/".join(f"{100 * value:.1f}" for value in values)
    counts = "/".join(f"{value:.0f}" for value in spread([len(pair.matches) for pair in pairs], 0, 0.5, 1))
    return (f"{name:<24} {len(pairs):6d}  {counts:<20} {percent([np.mean(shares)]) if shares else '-':>6}  "
            f"{percent(spread(shares, 0.1, 0.5, 0.9)) if shares else '-':<24} {percent([np.mean(labelled)]) if labelled else '-':>8} {repeats:7d}  "
            f"{f'{len(bad)} bad' if bad else 'ok':<8} {pairs[0].contents()}")


def background(folder, name, size):
    from PIL import Image

    if not folder:
        need(size is not None, "without --images the scene must have sizes.h5")
        return Image.new("RGB", (int(size[1]), int(size[0])), "white")
    for place in (pathlib.Path(folder), pathlib.Path(folder) / "images"):
        for path in sorted(place.iterdir()) if place.is_dir() else []:
            if path.is_file() and path.stem.replace("-", "_") == name:
                return Image.blend(Image.open(path).convert("L").convert("RGB"), Image.new("RGB", Image.open(path).size, "white"), 0.3)
    need(False, f"{folder}: there is no image {name}")


def draw(pair, threshold, folder, path):
    """Side by side; matches near the truth (or labelled) are green, others orange, all blue where nothing is known; lines for 60 of each."""
    from PIL import Image, ImageDraw

    sides = [background(folder, name, None if pair.sizes is None else pair.sizes[2 * i:2 * i + 2]) for i, name in enumerate(pair.images)]
    scale = min(1, (WIDEST - 4) / sum(side.width for side in sides))
    sides = [side.resize([max(1, round(length * scale)) for length in side.size]) for side in sides]
    canvas = Image.new("RGB", (sides[0].width + sides[1].width + 4, max(side.height for side in sides)), "white")
    for side, left in zip(sides, (0, sides[0].width + 4)):
        canvas.paste(side, (left, 0))
    good = pair.distances <= threshold if pair.distances is not None else pair.labels > 0 if pair.labels is not None else None
    groups = [("#1f77b4", np.ones(len(pair.matches), bool))] if good is None else [("#ff7f0e", ~good), ("#2ca02c", good)]
    pen, ends = ImageDraw.Draw(canvas), (pair.matches + 0.5) * scale - 0.5 + [0, 0, sides[0].width + 4, 0]
    for colour, chosen in groups:
        rows = ends[chosen & np.isfinite(ends).all(1)].clip(-1e4, 1e4)
        for row in rows[np.linspace(0, len(rows) - 1, min(len(rows), MOST_LINES)).astype(int)]:
            pen.line(list(row), fill=colour)
        for x1, y1, x2, y2 in rows:
            pen.ellipse([x1 - 2, y1 - 2, x1 + 2, y1 + 2], fill=colour)
            pen.ellipse([x2 - 2, y2 - 2, x2 + 2, y2 + 2], fill=colour)
    canvas.save(path)
    print(f"{path}: {pair.name}, {len(pair.matches)} matches" + ("" if good is None else f", {good.sum()} inliers"))


def inspect(arguments):
    if arguments.picture:
        need(len(arguments.folders) == 1 and len(scenes_in(arguments.folders[0])) == 1, "--picture needs one scene")
        files = files_of(scenes_in(arguments.folders[0])[0])
        pairs = sorted(files["matches"])
        name = arguments.pair or pairs[0]
        need(name in pairs, f"{arguments.folders[0]}: there is no pair {name}; the first is {pairs[0]}")
        need(not os.path.exists(arguments.picture) or pathlib.Path(arguments.picture).suffix != ".h5", f"{arguments.picture}: no name of a picture")
        return draw(Pair(files, name), arguments.threshold_px, arguments.images, arguments.picture)
    need(not arguments.pair and not arguments.images, "--pair and --images are for --picture")
    problems, rows = [], []
    for folder in arguments.folders:
        rows += [row_of(scene, arguments.threshold_px, problems) for scene in scenes_in(folder)]
    print(f"share: matches within {arguments.threshold_px:g} px of the true model, % (Sampson distance; transfer error for H)")
    print(f"{'scene':<24} {'pairs':>6}  {'matches min/med/max':<20} {'mean':>6}  {'share p10/median/p90':<24} {'labelled':>8} {'repeats':>7}  {'checks':<8} contents")
    print("\n".join(rows + problems))
    sys.exit(2 if problems else 0)
