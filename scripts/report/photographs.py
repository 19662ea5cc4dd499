"""The tables of a run of diffsac_pair on photographs: its cameras and its pairs, by poses.csv."""
import os

from tables import UNKNOWN, Table

MOST_PAIRS = 2000  # Of the table; poses.csv has all.
_DEGENERACIES = {"determined": "yes", "pure_rotation": "no: turned only", "static": "no: no motion", "plane": "no: one plane",
                 "line": "no: one line"}
_VERDICTS = ("sure", "may be chance", "no model")


def read_poses(run):
    """None where the folder is another program's; names stay texts."""
    import pandas

    try:
        with open(run.path("config.yaml"), encoding="utf-8") as file:
            ours = file.readline().rstrip().endswith(" diffsac_pair")
    except OSError:
        return None
    if not ours or not os.path.exists(run.path("poses.csv")):
        return None
    texts = ("image1", "image2", "status", "degeneracy", "focal1_source", "focal2_source")
    return pandas.read_csv(run.path("poses.csv"), converters={name: str for name in texts})


def _verdict(pair):
    if pair.status != "ok":
        return _VERDICTS[2]
    return _VERDICTS[1] if pair.may_be_chance else _VERDICTS[0]


def _focal(value, low, high):
    if value != value:
        return UNKNOWN
    return f"{value:.0f}" + (f" [{low:.0f}, {high:.0f}]" if low == low else "")


def _focal_of(pair, side):
    return _focal(*(getattr(pair, f"focal{side}_{name}") for name in ("px", "low_px", "high_px")))


def _camera(value):
    return f"{value:.0f}" if value == value else UNKNOWN


def cameras_table(poses):
    """A row for each camera that had to be found: the middle of what its pairs say, which is one length where all of them together
    found it. None where the calibration is given."""
    cameras = {}
    for pair in poses.itertuples():
        for side in (1, 2):
            camera = getattr(pair, f"camera{side}")
            if camera != camera:
                continue
            images, lengths = cameras.setdefault(int(camera), (set(), []))
            images.add(getattr(pair, f"image{side}"))
            focal = getattr(pair, f"focal{side}_px")
            if focal == focal and _verdict(pair) == _VERDICTS[0]:
                lengths.append((focal, _focal_of(pair, side), getattr(pair, f"focal{side}_source")))
    if not cameras:
        return None
    table = Table("cameras", ["camera", "images", "f, px [68 %]", "from", "sure pairs", "of them"])
    for camera, (images, lengths) in sorted(cameras.items()):
        lengths.sort()
        _, focal, source = lengths[len(lengths) // 2] if lengths else (0, UNKNOWN, UNKNOWN)
        names = sorted(images)
        shown = ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
        table.add([str(camera), str(len(names)), focal, source or UNKNOWN, str(len(lengths)), shown])
    return table


def pairs_table(poses):
    """A row for each pair, the surest verdict first, then the most inliers."""
    pairs = sorted(poses.itertuples(), key=lambda pair: (_VERDICTS.index(_verdict(pair)), -pair.inliers))
    cameras = poses["camera1"].notna().any()
    columns = ["image 1", "image 2", "verdict", "t determined", "inliers", "matches"]
    columns += ["camera 1", "f1, px [68 %]", "f1 from", "camera 2", "f2, px [68 %]", "f2 from"] if cameras else ["f1, px", "f2, px"]
    table = Table("pairs", columns)
    for pair in pairs[:MOST_PAIRS]:
        cells = [pair.image1, pair.image2, _verdict(pair), _DEGENERACIES.get(pair.degeneracy, UNKNOWN), str(pair.inliers), str(pair.matches)]
        for side in (1, 2):
            focal = _focal_of(pair, side)
            cells += [_camera(getattr(pair, f"camera{side}")), focal, getattr(pair, f"focal{side}_source") or UNKNOWN] if cameras else [focal]
        table.add(cells)
    return table


def add_photographs(page, run):
    poses = read_poses(run)
    if poses is None or poses.empty:
        return
    page.section("Cameras and verdicts")
    cameras = cameras_table(poses)
    if cameras:
        page.table(cameras)
    left = len(poses) - MOST_PAIRS
    page.table(pairs_table(poses), f"{left} pairs more are in poses.csv." if left > 0 else "A click on a column's name sorts by it.")
