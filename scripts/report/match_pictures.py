"""A picture for each kept fit of two views, matches_CONDITION_PAIR_METHOD.png: both images side by side."""
import os
import re

import numpy as np

import examples
import files
from pictures import DPI, INLIER, MISSED, MOST_LINES, OUTLIER, WRONG, _number, _save, plt, structure_colour

PANEL_WIDTH, PANEL_HEIGHT, GAP, TITLE = 760, 600, 10, 62  # In pixels; an image is made as large as fits.
KINDS = (("other", OUTLIER), ("missed", MISSED), ("right", INLIER), ("wrong", WRONG))  # In the order in which they are drawn.


def kinds_of(found, truth):
    """What an estimate makes of each point, and whether that is so, as places in KINDS; without a truth every inlier is right."""
    truth = found if truth is None else truth
    return np.where(found, np.where(truth, 2, 3), np.where(truth, 1, 0))


def found_inliers(fit, points):
    return np.array(fit["inliers"], dtype=bool) if len(fit["inliers"]) == points else np.zeros(points, dtype=bool)


def error_text(fit):
    error = fit["error"]
    if fit["status"] != "ok":
        return f"no model ({fit['status']})"
    if error["recall"] is not None:
        return f"misclassification error {_number(error['misclassified']):.1f} %, recall {_number(error['recall']):.2f}"
    if error["rotation_deg"] is not None:
        return ("no pose, " if error["failed"] else "") + \
            f"error R {_number(error['rotation_deg']):.2f}°, t {_number(error['translation_deg']):.2f}°"
    if error["error_px"] is None:
        return "error unknown"
    value = _number(error["error_px"])
    return "error " + (f"{value:.2f}" if abs(value) < 1e9 else f"{value:.3g}") + " px"


def counts_text(kinds, truth):
    counts = np.bincount(kinds, minlength=4)
    matches = f" of {len(kinds)} matches"
    if truth is None:
        text = f"inliers: {counts[2]} (green, truth unknown){matches}"
    else:
        text = f"inliers: {counts[2]} right (green), {counts[3]} wrong (red), {counts[1]} missed (blue){matches}"
    return text + (f"; lines: {MOST_LINES} of a colour at most" if max(counts[1:]) > MOST_LINES else "")


class _Canvas:
    """Both images of a pair; places in it are in pixels."""

    def __init__(self, run, example, sides):
        sizes = [example.size(side) for side in sides]
        self.scales = [min(PANEL_WIDTH / w, PANEL_HEIGHT / h) for w, h in sizes]
        extents = [(max(1, round(w * s)), max(1, round(h * s))) for (w, h), s in zip(sizes, self.scales)]
        self.origins = [(GAP, TITLE), (extents[0][0] + 2 * GAP, TITLE)]
        self.width = extents[0][0] + extents[1][0] + 3 * GAP
        self.height = TITLE + max(extents[0][1], extents[1][1]) + GAP
        self.figure = plt.figure(figsize=(self.width / DPI, self.height / DPI), dpi=DPI)
        self.axes = self.figure.add_axes((0, 0, 1, 1))
        self.axes.set(xlim=(0, self.width), ylim=(self.height, 0))
        self.axes.set_axis_off()
        for side, (x, y), (w, h) in zip(sides, self.origins, extents):
            image = examples.load_image(run.results["figures"]["images"], example, side, max(w, h))
            place = (x, x + w, y + h, y)
            if image is None:
                self.axes.imshow(np.full((1, 1, 3), 238, dtype=np.uint8), extent=place, aspect="auto")
            else:  # Paler, so that the matches stand out.
                self.axes.imshow(np.asarray(image), extent=place, aspect="auto", alpha=0.65)
        self.axes.set(xlim=(0, self.width), ylim=(self.height, 0))

    def at(self, points, panel):
        return points * self.scales[panel] + self.origins[panel]

    def titled(self, title, below):
        # Points outside their image must not cover the text.
        self.axes.add_patch(plt.Rectangle((0, 0), self.width, TITLE, color="white", zorder=9))
        for text, baseline, size in ((title, 26, 12.5), (below, 50, 10.5)):
            room = (self.width - 2 * GAP) / (0.6 * size * DPI / 72)  # Made smaller where it would not fit.
            self.axes.text(GAP, baseline, text, fontsize=size * min(1, room / max(1, len(text))), color="#202020", zorder=10)


def _finite(points):
    return np.isfinite(points).all(axis=1) & (np.abs(np.nan_to_num(points)).max(axis=1, initial=0) < 1e6)


def _draw_matches(canvas, example, kinds):
    known = _finite(example.points)
    for k, (name, colour) in enumerate(KINDS):
        rows = np.flatnonzero((kinds == k) & known)
        left, right = canvas.at(example.points[rows, :2], 0), canvas.at(example.points[rows, 2:4], 1)
        shown = [i * len(rows) // MOST_LINES for i in range(MOST_LINES)] if len(rows) > MOST_LINES else range(len(rows))
        if name != "other" and len(rows):
            ends = np.stack([left, right], axis=1)[list(shown)]
            canvas.axes.plot(*ends.transpose(2, 1, 0), color=colour, linewidth=0.7, alpha=0.6)
        for places in (left, right):
            canvas.axes.scatter(*places.T, s=8, color=colour, linewidths=0, zorder=3)


def _draw_labels(canvas, points, labels, panel, column):
    """Outliers first, as small dots, so that they hide nothing."""
    known = _finite(points)
    places = canvas.at(points[:, column:column + 2], panel)
    outliers = known & (labels == 0)
    canvas.axes.scatter(*places[outliers].T, s=8, color=OUTLIER, linewidths=0, zorder=3)
    for k in range(1, int(labels.max(initial=0)) + 1):
        canvas.axes.scatter(*places[known & (labels == k)].T, s=36, color=structure_colour(k), edgecolors="white", linewidths=0.7, zorder=4)


def _picture(run, fit, example):
    structures = fit.get("structures")
    known_labels = structures.get("true_labels") if structures else None
    # Those found in image 1 and, beside them, the true ones with the colours of their partners; without a truth both images.
    canvas = _Canvas(run, example, (0, 0) if known_labels is not None else (0, 1))
    if structures:
        labels = np.array(structures["labels"])
        _draw_labels(canvas, example.points, labels, 0, 0)
        _draw_labels(canvas, example.points, labels if known_labels is None else np.array(known_labels), 1, 2 if known_labels is None else 0)
        found, matches = len(structures["models"]), f"{len(example.points)} matches, outliers grey"
        below = f"{found} structures found; {matches}" if known_labels is None else \
            f"left: {found} structures found, right: {len(structures['true_models'])} true ones; {matches}"
    else:
        kinds = kinds_of(found_inliers(fit, len(example.points)), example.inliers)
        _draw_matches(canvas, example, kinds)
        below = counts_text(kinds, example.inliers)
    conditions = run.results["conditions"]
    condition = f", {conditions[fit['condition']]['label']}" if len(conditions) > 1 else ""
    canvas.titled(f"{run.results['methods'][fit['method']]['label']}: {error_text(fit)} ({example.id}{condition})", below)
    return canvas.figure


def file_name(run, fit, example):
    """Without what a shell or a file system could mind."""
    condition, method = run.results["conditions"][fit["condition"]], run.results["methods"][fit["method"]]
    return re.sub(r"[^A-Za-z0-9.-]", "_", f"matches_{condition['name']}_{example.id}_{method['name']}")


def draw_matches(run, fits):
    """Those of an earlier run go."""
    drawn = set()
    if fits and run.results["two_view"]:
        for fit in fits.fits:
            example = fits.example(fit)
            name = file_name(run, fit, example)
            _save(_picture(run, fit, example), run.folder, name, tight=False)
            drawn.add(name + ".png")
    for name in os.listdir(run.folder):
        if name.startswith("matches_") and name.endswith(".png") and name not in drawn:
            files.remove(run.path(name))
