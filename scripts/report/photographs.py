"""report.html of a folder of diffsac_pair, by its pairs.json and matches/NAME: cameras, pairs, and their matches on the
photographs."""
import io
import json
import os

import h5py
import numpy as np

import html_page
from problem_list import point_bytes, undetermined_text
from tables import UNKNOWN, Table

MOST_PAIRS = 2000  # Of the page; pairs.json has all.
MOST_IMAGE_BYTES = 8_000_000  # Photographs are made smaller where there are many.
_DEGENERACIES = {"determined": "yes", "pure_rotation": "no: turned only", "static": "no: no motion", "plane": "no: one plane",
                 "line": "no: one line"}
_VERDICTS = ("sure", "not sure", "may be chance", "no model")


def _verdict(pair):
    if pair["status"] != "ok":
        return "no model"
    return "may be chance" if pair["may_be_chance"] else "sure" if pair["sure"] else "not sure"


def _focal(pair, side):
    """With 68 % of what it may be, and where it comes from."""
    focal = pair["focal"]
    if not focal:
        return None, UNKNOWN, UNKNOWN
    value, source = focal["px"][side], focal["source"][side]
    return value, f"{value:.0f}" + (f" [{focal['low_px'][side]:.0f}, {focal['high_px'][side]:.0f}]" if "low_px" in focal else ""), source


def cameras_table(pairs):
    """A row for each camera that had to be found: the middle of what its pairs say, which is one length where all of them together
    found it. None where the calibration is given."""
    cameras = {}
    for pair in pairs:
        for side in (0, 1):
            camera = pair[f"camera{side + 1}"]
            if camera is None:
                continue
            images, lengths = cameras.setdefault(camera, (set(), []))
            images.add(pair[f"image{side + 1}"])
            if pair["focal"] and _verdict(pair) == "sure":
                lengths.append(_focal(pair, side))
    if not cameras:
        return None
    table = Table("cameras", ["camera", "images", "f, px [68 %]", "from", "sure pairs", "of them"])
    for camera, (images, lengths) in sorted(cameras.items()):
        lengths.sort()
        _, focal, source = lengths[len(lengths) // 2] if lengths else (0, UNKNOWN, UNKNOWN)
        names = sorted(images)
        shown = ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
        table.add([str(camera), str(len(names)), focal, source, str(len(lengths)), shown])
    return table


def pairs_table(pairs):
    """A row for each pair, the surest verdict first, then the most inliers."""
    cameras = any(pair["camera1"] is not None for pair in pairs)
    columns = ["image 1", "image 2", "verdict", "t determined", "inliers", "matches"]
    columns += ["camera 1", "f1, px [68 %]", "f1 from", "camera 2", "f2, px [68 %]", "f2 from"] if cameras else ["f1, px", "f2, px"]
    table = Table("pairs", columns)
    for pair in pairs:
        verdict = _verdict(pair) + (", the matches contradict the focal lengths" if pair["focal_conflict"] else "")
        cells = [pair["image1"], pair["image2"], verdict, _DEGENERACIES.get(pair["degeneracy"], UNKNOWN), str(len(pair["inliers"])),
                 str(pair["matches"])]
        for side in (0, 1):
            camera, (_, focal, source) = pair[f"camera{side + 1}"], _focal(pair, side)
            cells += [UNKNOWN if camera is None else str(camera), focal, source] if cameras else [focal]
        table.add(cells)
    return table


def _details(pair):
    """What a line of the list opens (report.js)."""
    pose = pair["pose"]
    details = {"noise": pair["sigma_px"], "model": pair["model"] or None,
               "pose": pose["q"] + (pose["t"] or [None] * 3) if pose else None}
    text = undetermined_text(pair["degeneracy"], pair["task"])
    return {**details, "undetermined": text} if text else details


def _size(pair, side, points):
    """The image's, or else that of the box of its points."""
    known = pair[f"size{side + 1}"]
    if known:
        return known
    finite = points[np.isfinite(points).all(axis=1)][:, 2 * side:2 * side + 2]
    return [int(min(value, 1e5)) + 1 for value in np.maximum(finite.max(axis=0), 0)] if len(finite) else [1, 1]


class _Photographs:
    """Small copies, each once."""

    def __init__(self, folder, count):
        path = os.path.join(folder, "thumbnails.h5")
        self._file, self._numbers, self._used = h5py.File(path, "r") if os.path.exists(path) else {}, {}, 0
        # The longest side that lets them all in, at about a byte for 6 pixels.
        self._longest = int(np.clip(np.sqrt(6.0 * MOST_IMAGE_BYTES / max(1, count)), 240, 640))

    def number(self, page, name):
        """-1 where there is none, or no room."""
        if name in self._numbers:
            return self._numbers[name]
        number = -1
        if name in self._file and self._used < MOST_IMAGE_BYTES:
            from PIL import Image

            image = Image.open(io.BytesIO(self._file[name][()].tobytes())).convert("RGB")
            image.thumbnail((self._longest, self._longest))
            out = io.BytesIO()
            image.save(out, "JPEG", quality=72)
            number = sum(one >= 0 for one in self._numbers.values())
            page.bytes(f"image-{number}", out.getvalue())
            self._used += len(out.getvalue()) * 4 // 3
        self._numbers[name] = number
        return number


def add_list(page, run, pairs, folder):
    """The list of pairs, each with its matches, as report.js draws them."""
    photographs = _Photographs(folder, len({name for pair in pairs for name in pair["names"]}))
    statuses, lines, pictures = [], [], []
    with h5py.File(os.path.join(folder, "matches.h5"), "r") as matches:
        for number, pair in enumerate(pairs):
            points = matches[pair["pair"]][()]
            sizes = _size(pair, 0, points) + _size(pair, 1, points)
            page.bytes(f"points-{number}", point_bytes(points, max(sizes)))
            mask = np.zeros(len(points), dtype=bool)
            mask[pair["inliers"]] = True
            page.bytes(f"masks-{number}", np.packbits(mask, bitorder="little").tobytes())
            pictures.append([number, *sizes, *(photographs.number(page, name) for name in pair["names"]), 0, [0]])
            status = "ok, may be chance" if _verdict(pair) == "may be chance" else pair["status"].replace("_", " ")
            if status not in statuses:
                statuses.append(status)
            lines.append([number, 0, statuses.index(status), None, len(pair["inliers"]), pair["hypotheses"], pair["ms"]["estimate"]])
    page.json("pictures", json.dumps(pictures, separators=(",", ":")))
    problems = [[pair["pair"], 0, 0, pair["matches"], number] for number, pair in enumerate(pairs)]
    page.json("problems", json.dumps({
        "task": run["task"], "unit": "px", "poses": False, "structures": False, "two_view": True, "method": 0,
        "condition_label": "", "methods": [run["method"]], "conditions": [""], "scenes": [run["name"]], "statuses": statuses,
        "problems": problems, "details": {number: _details(pair) for number, pair in enumerate(pairs)}, "lines": lines},
        ensure_ascii=False, separators=(",", ":")))
    page.place("problem-list")
    page.script("report.js")


def write_page(folder):
    with open(os.path.join(folder, "pairs.json"), encoding="utf-8", errors="replace") as file:
        run = json.load(file)
    all_pairs = sorted(run["pairs"], key=lambda pair: (_VERDICTS.index(_verdict(pair)), -len(pair["inliers"])))
    pairs = all_pairs[:MOST_PAIRS]
    page = html_page.Page(f"{run['name']}, {run['task']}" + (" (partial)" if run["partial"] else ""))
    page.subtitles = [f"{len(all_pairs)} pairs, guidance {run['method']}, seed {run['seed']}", f"{run['version']}, {run['machine']}"]
    if run["partial"]:
        page.warning("Partial results: the run was interrupted.")
    page.section("Cameras and verdicts")
    cameras = cameras_table(all_pairs)
    if cameras:
        page.table(cameras)
    left = len(all_pairs) - len(pairs)
    page.table(pairs_table(pairs), f"{left} pairs more are in pairs.json." if left > 0 else "A click on a column's name sorts by it.")
    page.section("Pairs")
    add_list(page, run, pairs, os.path.join(folder, run["matches"]))
    page.write(os.path.join(folder, "report.html"))
