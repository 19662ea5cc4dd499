"""What data_tools/convert.py makes of files in each format, written here from the formats' own documents: convert_test.py BUILD SOURCE."""

import atexit
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import h5py
import numpy as np
from PIL import Image
from scipy.io import savemat

SOURCE = sys.argv[2]
ROOT = pathlib.Path(tempfile.mkdtemp())
atexit.register(shutil.rmtree, ROOT)
SIZE = (320, 240)
K = np.array([[300.0, 0, 158], [0, 310, 121], [0, 0, 1]])


def turn(degrees, axis):
    axis, angle = np.array(axis) / np.linalg.norm(axis), np.radians(degrees)
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


POSES = [(np.eye(3), np.zeros(3)), (turn(20, (1, 2, 3)), np.array([0.3, -0.1, 0.2])), (turn(170, (0, 1, 0.2)), np.array([1, 2, 3.0]))]


def to_world(i):
    R, t = POSES[i]
    return np.vstack([np.column_stack([R.T, -R.T @ t]), [0, 0, 0, 1]])


def folder(*names):
    path = ROOT.joinpath(*names)
    path.mkdir(parents=True)
    return path


def image(path, size=SIZE):
    Image.new("L", size, 90).save(path)


def text(matrix):
    return "\n".join(" ".join(repr(float(value)) for value in row) for row in np.atleast_2d(matrix)) + "\n"


def convert(*words, expect=0):
    done = subprocess.run([sys.executable, os.path.join(SOURCE, "data_tools/convert.py"), *map(str, words)], capture_output=True, text=True)
    assert done.returncode == expect, done
    return done.stdout + done.stderr


def read_model(path):
    """name -> (R, t, camera's words)."""
    cameras = {line.split()[0]: line.split()[1:] for line in (path / "cameras.txt").read_text().splitlines()}
    images = {}
    for line in (path / "images.txt").read_text().splitlines()[::2]:
        words = line.split(maxsplit=9)
        w, x, y, z = map(float, words[1:5])
        R = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                      [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                      [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])
        images[words[9]] = R, np.array(words[5:8], float), cameras[words[8]]
        assert (path / "images" / words[9]).is_file()
    return images


def check(path, names, camera=("PINHOLE", 320, 240, 300, 310, 158.5, 121.5), poses=(0, 1, 2)):
    model = read_model(path)
    assert sorted(model) == sorted(names), model
    for name, i in zip(names, poses):
        R, t, words = model[name]
        assert np.allclose(R, POSES[i][0], atol=1e-9) and np.allclose(t, POSES[i][1], atol=1e-9), name
        assert words[0] == camera[0] and np.allclose(np.array(words[1:], float), camera[1:], atol=1e-6), words


def test_strecha():
    images, cameras = folder("strecha", "images"), folder("strecha", "gt_dense_cameras")
    for i in range(3):
        image(images / f"{i}.png")
        world = to_world(i)
        (cameras / f"{i}.png.camera").write_text(text(K) + "0 0 0\n" + text(world[:3, :3]) + text(world[:3, 3]) + "320 240\n")
    convert("strecha", ROOT / "strecha", ROOT / "out" / "strecha")
    check(ROOT / "out" / "strecha", ["0.png", "1.png", "2.png"])
    (cameras / "1.png.camera").write_text("1 2 3\n")
    said = convert("strecha", ROOT / "strecha", ROOT / "out" / "strecha")
    assert "left out" in said and "1.png.camera: expected 26 numbers, found 3" in said
    check(ROOT / "out" / "strecha", ["0.png", "2.png"], poses=(0, 2))


def test_nerf():
    images = folder("nerf", "images")
    gl = np.diag([1.0, -1, -1, 1])
    frames = [{"file_path": f"./images/im-{i}", "transform_matrix": (to_world(i) @ gl).tolist()} for i in (2, 0, 1)]
    for i in range(3):
        image(images / f"im-{i}.png")
    every = {"fl_x": 300, "fl_y": 310, "cx": 158.5, "cy": 121.5, "w": 320, "h": 240, "k1": -0.1, "frames": frames}
    file = ROOT / "nerf" / "transforms.json"

    def made(changes, expect=0):
        file.write_text(json.dumps({**every, **changes}))
        return convert("nerf", ROOT / "nerf", ROOT / "out" / "nerf", expect=expect)

    names = [f"im-{i}.png" for i in range(3)]
    made({})
    check(ROOT / "out" / "nerf", names, ("OPENCV", 320, 240, 300, 310, 158.5, 121.5, -0.1, 0, 0, 0))
    # Reduced to half after the calibration.
    made({"w": 640, "h": 480, "fl_x": 600, "fl_y": 620, "cx": 317, "cy": 243, "k1": 0})
    check(ROOT / "out" / "nerf", names)
    made({"fl_x": None, "fl_y": None, "camera_angle_x": 2 * np.arctan(160 / 300), "cx": None, "cy": None, "k1": 0})
    check(ROOT / "out" / "nerf", names, ("PINHOLE", 320, 240, 300, 300, 160, 120))
    for wrong, message in (({"k3": 0.1}, "k3"), ({"is_fisheye": True}, "fisheye"), ({"fl_x": "a"}, "expected a number as fl_x"),
                           ({"frames": 3}, "list of frames"), ({"frames": [{}]}, "expected file_path"),
                           ({"frames": [{"file_path": "nobody"}]}, "no such file"),
                           ({"frames": [{"file_path": "images/im-0", "transform_matrix": [[1]]}]}, "expected a 3x4 or 4x4 matrix")):
        assert message in made(wrong, expect=2), message
    file.write_text("{")
    assert "not JSON" in convert("nerf", ROOT / "nerf", ROOT / "out" / "nerf", expect=2)


def test_llff():
    images = folder("llff", "images")
    rows = []
    for i in range(3):
        image(images / f"{i}.png")
        world = to_world(i)[:3]
        # Axes down, right, backwards; the focal length is for twice the size.
        matrix = np.column_stack([world[:, 1], world[:, 0], -world[:, 2], world[:, 3], [480, 640, 600]])
        rows.append([*matrix.ravel(), 1, 2])
    np.save(ROOT / "llff" / "poses_bounds.npy", rows)
    convert("llff", ROOT / "llff", ROOT / "out" / "llff")
    check(ROOT / "out" / "llff", ["0.png", "1.png", "2.png"], ("PINHOLE", 320, 240, 300, 300, 160, 120))
    np.save(ROOT / "llff" / "poses_bounds.npy", rows[:2])
    assert "2 poses for 3 images" in convert("llff", ROOT / "llff", ROOT / "out" / "llff", expect=2)
    (ROOT / "llff" / "poses_bounds.npy").write_bytes(b"none")
    assert "poses_bounds.npy: " in convert("llff", ROOT / "llff", ROOT / "out" / "llff", expect=2)


def test_middlebury():
    here = folder("middlebury")
    lines = ["3"]
    for i, (R, t) in enumerate(POSES):
        image(here / f"a {i}.png")
        lines.append(f"a {i}.png " + " ".join(map(repr, map(float, [*K.ravel(), *R.ravel(), *t]))))
    (here / "a_par.txt").write_text("\n".join(lines + ["b.png " + " ".join(["1"] * 21)]) + "\n")
    said = convert("middlebury", here, ROOT / "out" / "middlebury")
    assert "a_par.txt:5: there is no" in said
    check(ROOT / "out" / "middlebury", ["a 0.png", "a 1.png", "a 2.png"])


def test_projections():
    images = folder("projections", "image")
    matrices = {}
    for i, (R, t) in enumerate(POSES):
        image(images / f"{i}.png")
        P = K @ np.column_stack([R, t]) * (-2.5 if i == 1 else 1)
        matrices[f"world_mat_{i}"] = np.vstack([P, [0, 0, 0, 1]])
    np.savez(ROOT / "projections" / "cameras.npz", **matrices)
    convert("projections", ROOT / "projections", ROOT / "out" / "projections")
    check(ROOT / "out" / "projections", ["0.png", "1.png", "2.png"])
    os.remove(ROOT / "projections" / "cameras.npz")
    assert "cameras.npz: No such file" in convert("projections", ROOT / "projections", ROOT / "out" / "projections", expect=2)


def test_poses():
    images, poses, intrinsics = folder("poses", "image"), folder("poses", "pose"), folder("poses", "intrinsic")
    beside = folder("beside")
    for i in range(3):
        image(images / f"{i}.png")
        (poses / f"{i}.txt").write_text(text(to_world(i)))
        (intrinsics / f"{i}.txt").write_text(text(K))
        image(beside / f"{i}.color.png")
        image(beside / f"{i}.depth.png")
        (beside / f"{i}.pose.txt").write_text(text(to_world(i)))
    convert("poses", ROOT / "poses", ROOT / "out" / "poses")
    check(ROOT / "out" / "poses", ["0.png", "1.png", "2.png"])
    convert("poses", beside, ROOT / "out" / "beside", "--focal", 300, "--center", "158,121")
    check(ROOT / "out" / "beside", [f"{i}.color.png" for i in range(3)], ("PINHOLE", 320, 240, 300, 300, 158.5, 121.5))
    assert "no folder intrinsic" in convert("poses", beside, ROOT / "out" / "beside", expect=2)
    (poses / "0.txt").write_text("2 0 0 0\n0 2 0 0\n0 0 2 0\n0 0 0 1\n")
    assert "holds no rotation" in convert("poses", ROOT / "poses", ROOT / "out" / "poses")
    (poses / "1.txt").write_text("1 0 0 nan\n0 1 0 0\n0 0 1 0\n0 0 0 1\n")
    assert "not finite" in convert("poses", ROOT / "poses", ROOT / "out" / "poses", expect=2)


def test_adelaidermf():
    here = folder("adelaide", "sift_update").parent
    generator = np.random.default_rng(1)
    points = generator.uniform(0, 400, (20, 4))
    points[:, 3] = points[:, 1]  # the camera moves along x

    def write(name, F, labels):
        for side in "AB":
            image(here / f"{name}{side}.png", (10, 8))
        (here / f"{name}_model.txt").write_text(text(F))
        (here / f"{name}_pts.txt").write_text(text(np.column_stack([points[:, :2], np.ones(20), points[:, 2:], np.ones(20), labels])))
        (here / f"sift_update/{name}_pts.txt").write_text("20\n" + text(points))
        (here / f"sift_update/{name}_score.txt").write_text(text(np.full((20, 1), 0.5)))

    F = np.array([[0, 0, 0], [0, 0, -1.0], [0, 1, 0]])
    write("ho-use", F, np.arange(20) % 3)
    convert("adelaidermf", here, ROOT / "out")
    read = lambda name: h5py.File(ROOT / "out" / name)["ho_useA-ho_useB"]
    assert (read("adelaidermf/matches.h5")[()] == points).all() and (read("adelaidermf_sift/matches.h5")[()] == points).all()
    assert read("adelaidermf/labels.h5")[()].tolist() == [i % 3 for i in range(20)] and read("adelaidermf/labels.h5").dtype == "i4"
    assert read("adelaidermf/sizes.h5")[()].tolist() == [8, 10, 8, 10] and (read("adelaidermf_sift/Fgt.h5")[()] == F).all()
    assert (read("adelaidermf_sift/match_conf.h5")[()] == 0.5).all()
    assert not (ROOT / "out" / "adelaidermf_sift" / "labels.h5").exists()
    (here / "sift_update/ho-use_score.txt").write_text("0.5\n")
    assert "ho-use_score.txt: expected 20 ratios" in convert("adelaidermf", here, ROOT / "out", expect=2)
    (here / "sift_update/ho-use_pts.txt").write_text("21\n1 2 3 4\n")
    assert "number of rows" in convert("adelaidermf", here, ROOT / "out", expect=2)
    write("ho-use", F.T + 1, np.ones(20))
    assert "ho-use_model.txt: it misses" in convert("adelaidermf", here, ROOT / "out", expect=2)
    (here / "ho-use_pts.txt").write_text("1 2 1 3 4 1 0\n1 2 1 3 4 1\n")
    assert "ho-use_pts.txt:2: expected 7 numbers" in convert("adelaidermf", here, ROOT / "out", expect=2)
    assert "no files NAME_model.txt" in convert("adelaidermf", folder("no_pairs"), ROOT / "out", expect=2)


def write_house(here, others=10, extent=500.0, noise=0.0):
    """Two planes in images of 640 x 480 pixels, `others` matches of the second, which moves otherwise; those of the first lie within `extent`
    pixels of the corner."""
    generator = np.random.default_rng(7)
    x, y = generator.uniform(0, 1, (2, 40 + others)) * np.where(np.arange(40 + others) < 40, extent, 500)
    first = np.arange(40 + others) < 40
    moved = x + np.where(first, 40 + noise * generator.normal(size=40 + others), -300)
    points, ones = np.column_stack([x, 0.8 * y, moved, 0.8 * y]), np.ones(40 + others)
    for name in "abc":
        for side in "AB":
            image(here / f"{name}{side}.png", (640, 480))
        (here / f"{name}_model.txt").write_text("0 0 0\n0 0 -1\n0 1 0\n")
        (here / f"{name}_pts.txt").write_text(text(np.column_stack([points[:, :2], ones, points[:, 2:], ones, 2 - first])))
        (here / f"sift_update/{name}_pts.txt").write_text(f"{len(points)}\n" + text(points))
        (here / f"sift_update/{name}_score.txt").write_text(text(ones[:, None] / 2))


def test_adelaidermf_planes():
    here = folder("house", "sift_update").parent
    write_house(here)
    convert("adelaidermf_planes", here, ROOT / "out")
    with h5py.File(ROOT / "out" / "adelaidermf_planes_even" / "Hgt.h5") as even, h5py.File(ROOT / "out" / "adelaidermf_planes_odd" / "Hgt.h5") as odd:
        assert (list(even), list(odd)) == (["aA-aB", "cA-cB"], ["bA-bB"])
        H = even["aA-aB"][()]
        assert abs(H / H[2, 2] - [[1, 0, 40], [0, 1, 0], [0, 0, 1]]).max() < 1e-6
    assert not (ROOT / "out" / "adelaidermf_planes_even" / "Fgt.h5").exists()  # Which plane is meant is the homography's to say.
    # Another plane with more than two thirds as many, and one whose noisy labels in a corner say little of the rest.
    for house, kept in (({"others": 26}, True), ({"others": 28}, False), ({"extent": 30}, True), ({"extent": 30, "noise": 1}, False)):
        write_house(here, **house)
        done = subprocess.run([sys.executable, os.path.join(SOURCE, "data_tools/convert.py"), "adelaidermf_planes", here, ROOT / "out"], capture_output=True, text=True)
        assert ("even: 2 pairs" in done.stdout) == kept, (house, done)
        assert kept or "left out: aA-aB" in done.stderr


def write_hloc(here):
    with h5py.File(here / "feats.h5", "w") as file:
        for first, (name, count) in enumerate((("db/a_1.jpg", 3), ("db/b.jpg", 4), ("q.jpg", 5)), 1):
            file[name + "/keypoints"] = np.column_stack([first + 10 * np.arange(count), 5.5 + np.arange(count)])
            file[name + "/image_size"] = [320, 240]
            file[name + "/scales"], file[name + "/oris"] = np.full(count, 2.0 * first), np.full(count, 100.0 * first)


def hloc_matches(here, **pairs):
    with h5py.File(here / "matches.h5", "w") as file:
        for pair, (partners, scores) in pairs.items():
            file[pair.replace("__", "/") + "/matches0"] = np.array(partners, "i2")
            if scores:
                file[pair.replace("__", "/") + "/matching_scores0"] = np.array(scores, "f2")


def test_hloc():
    here = folder("hloc")
    write_hloc(here)
    good = {"q.jpg__db-a_1.jpg": ([-1, 2, -1, 0, 1], [0, 0.75, 0, 1, 0.5]), "db-a_1.jpg__q.jpg": ([3, 4, 1], [1, 1, 1]),
            "db-a_1.jpg_db-b.jpg": ([3, -1, 0], [0.25, 0, 0.125])}
    hloc_matches(here, **good)
    convert("hloc", here, ROOT / "out", "--scene", "h", "--focal", 300, "--center", "160,120")
    read = lambda name: h5py.File(ROOT / "out" / "h" / name)
    assert list(read("matches.h5")) == ["db_a_1-db_b", "db_a_1-q"]
    assert read("matches.h5")["db_a_1-db_b"][()].tolist() == [[1, 5.5, 32, 8.5], [21, 7.5, 2, 5.5]]
    assert read("match_scores.h5")["db_a_1-db_b"][()].tolist() == [0.25, 0.125] and len(read("matches.h5")["db_a_1-q"]) == 3
    assert read("match_indices.h5")["db_a_1-db_b"][()].tolist() == [[0, 3], [2, 0]] and read("sizes.h5")["db_a_1-q"][()].tolist() == [240, 320, 240, 320]
    assert np.allclose(read("similarities.h5")["db_a_1-q"][0], [np.log(3), np.radians(200 - 360)]) and read("K1_K2.h5")["db_a_1-q"][0, 1, 0, 2] == 160
    assert "db_a_1\tdb/a_1.jpg" in (ROOT / "out" / "h" / "images.txt").read_text()
    # A bad image or pair costs no other; what only some have, none keeps.
    with h5py.File(here / "feats.h5", "a") as file:
        file["q.jpg/keypoints"][0, 0] = np.nan
        del file["db/b.jpg/scales"]
    hloc_matches(here, **good, **{"x.jpg__q.jpg": ([0], []), "x/y__q.jpg": ([0], [])})
    said = convert("hloc", here / "matches.h5", ROOT / "out", "--scene", "h", "--features", here / "feats.h5")
    assert "q.jpg/keypoints: a value is not finite" in said and "no image x.jpg" in said and "expected NAME1/NAME2" in said and "2 pairs of images" in said
    assert list(read("matches.h5")) == ["db_a_1-db_b"] and not (ROOT / "out" / "h" / "similarities.h5").exists()
    assert "\t" + str(here) in (ROOT / "out" / "h" / "images.txt").read_text()
    write_hloc(here)
    for wrong, message in (([3, -1], "expected 3 values"), ([4, -1, -1], "4 is no keypoint"), ([-2, 0, 0], "-2 is no keypoint")):
        hloc_matches(here, **{"db-a_1.jpg__db-b.jpg": (wrong, [])})
        assert message in convert("hloc", here, ROOT / "out", expect=2), message
    hloc_matches(here, **{"db-a_1.jpg__db-b.jpg": ([0, 1, 2], [0, 2, 0])})
    assert "expected scores from 0 to 1" in convert("hloc", here, ROOT / "out", expect=2)
    assert "would be replaced" in convert("hloc", here / "matches.h5", ROOT, "--scene", "hloc", expect=2)
    shutil.copy(here / "feats.h5", here / "others.h5")
    assert "hloc's features, found 2 (feats.h5, others.h5)" in convert("hloc", here, ROOT / "out", expect=2)
    (here / "others.h5").write_text("none")
    assert "others.h5: not a readable HDF5 file" in convert("hloc", here, ROOT / "out", expect=2)
    assert "none.h5: no such file" in convert("hloc", here / "none.h5", ROOT / "out", expect=2)


def write_scene(scene, **files):
    scene.mkdir(parents=True, exist_ok=True)
    for name, value in files.items():
        with h5py.File(scene / (name + ".h5"), "w") as file:
            for key in ("a", "b") if name in ("R", "T") else ("a-b",):
                file[key] = value[key] if isinstance(value, dict) else value


def test_inspect():
    scene, generator = ROOT / "seen" / "one", np.random.default_rng(3)
    R, t = POSES[1]
    X = np.column_stack([generator.uniform(-1, 1, (40, 2)), generator.uniform(3, 6, 40)])
    first, second = ((K @ (R @ X.T + t[:, None])).T for R, t in POSES[:2])
    points = np.column_stack([first[:, :2] / first[:, 2:], second[:, :2] / second[:, 2:]])
    points[:10, 3] += 30
    points[39] = points[38]
    write_scene(scene, matches=points, sizes=[2000, 2000, 2000, 2000], K1_K2=[[K, K]], R={"a": np.eye(3), "b": R}, T={"a": np.zeros(3), "b": t}, match_conf=np.full(40, 0.5))
    row = [line for line in convert("inspect", ROOT / "seen").splitlines() if line.startswith("one ")][0]
    assert row.split()[:3] == ["one", "1", "40/40/40"] and row.endswith("1  ok       ratio sizes K pose E F") and 70 <= float(row.split()[3]) <= 80, row
    write_scene(scene, match_conf=np.full(40, 1.5), Egt=np.eye(3), labels=np.arange(40) % 2)
    said = convert("inspect", ROOT / "seen", expect=2)
    assert "one: a-b: a ratio is not in [0, 1]" in said and "one: a-b: E, F, the poses and K disagree" in said and " 50.0 " in said
    convert("inspect", scene, "--picture", ROOT / "p.png")
    assert Image.open(ROOT / "p.png").width == 2400
    assert "there is no pair c-d; the first is a-b" in convert("inspect", scene, "--picture", ROOT / "p.png", "--pair", "c-d", expect=2)
    assert "nowhere: no such folder" in convert("inspect", ROOT / "nowhere", expect=2) and "--picture" in convert("inspect", scene, "--pair", "a-b", expect=2)
    (scene / "Egt.h5").write_bytes(b"none")
    assert "Egt.h5: not a readable HDF5 file" in convert("inspect", scene, expect=2)


def test_sets():
    here = folder("sets")
    program = here / "program"
    program.write_text('#!/bin/sh\nshift\necho "ran $*"\n')
    program.chmod(0o755)
    folder("sets", "data", "views")

    def made(*entries, only=(), expect=0):
        (here / "sets.yaml").write_text("sets:\n" + "".join(f"  - {{{entry}}}\n" for entry in entries))
        return convert("sets", "--config", here / "sets.yaml", "--data", here / "data", "--program", program, *only, expect=expect)

    views = "name: views, input: [absent, views], format: images, output: runs/x/y, scenes: ['view*'], steps: [1, 2], max_pairs: 3, described: train, thumbnails: false"
    absent = "name: elsewhere, input: [nowhere], format: images, output: runs/z"
    said = made(views, absent)
    assert "ran --format images --input " + str(here / "data/views") + " --output runs/x/y --threads 0 --steps 1,2 --max-pairs 3 --no-thumbnails\n" in said
    assert "--output runs/descriptors/orb/train" in said and "--features orb --no-thumbnails --descriptors" in said and "left out: elsewhere" in said
    for only, count in (("views", 1), ("view*", 3), ("runs/x", 1), ("runs/x/y/view_1", 1), ("runs/descriptors", 2)):
        assert made(views, absent, only=("--only", only)).count("ran ") == count, only
    assert "none of the sets" in made(views, absent, only=("--only", "elsewhere"), expect=2)
    assert "views: there is no key max_pair: max_pairs is the nearest" in made("name: views, input: [views], format: images, max_pair: 3", expect=2)
    assert "expected input" in made("name: views, format: images", expect=2)
    program.write_text("#!/bin/sh\nexit 3\n")
    assert "failed (exit status 3)" in made(views, expect=2)


def test_images():
    """What needs OpenCV: a moved copy of an image, as a scene of the tutorial, and as a COLMAP model of a wall."""
    try:
        import cv2
    except ImportError:
        return print("without OpenCV:", end=" ")
    generator = np.random.default_rng(5)
    texture = cv2.GaussianBlur(generator.integers(0, 255, (300, 400)).astype("u1"), None, 2)
    texture = cv2.normalize(texture, None, 0, 255, cv2.NORM_MINMAX)
    scene = folder("val", "wall", "images").parent
    model = folder("wall", "images").parent
    for i in range(3):
        for where in (scene, model):
            cv2.imwrite(str(where / "images" / f"{'abc'[i]}.png"), texture[20:260, 20 + 10 * i:340 + 10 * i])
    keypoints = np.array([k.pt for k in cv2.SIFT_create(0, 3, 0.04).detect(texture[20:260, 20:340])])
    keypoints = keypoints[(keypoints[:, 0] > 40) & (keypoints[:, 0] < 300)]
    write_scene(scene, matches=np.hstack([keypoints, keypoints - [10, 0]]))
    said = convert("tutorial", scene)
    assert "1 pairs, 2 images" in said and "already there" in convert("tutorial", scene)
    with h5py.File(scene / "descriptors.h5") as file:
        rows = file["a-b"][()]
        assert rows.shape == (len(keypoints), 256) and rows.dtype == "f4" and np.allclose(np.linalg.norm(rows[:, :128], axis=1), 1, atol=1e-5)
        assert (np.linalg.norm(rows[:, :128] - rows[:, 128:], axis=1) < 0.3).mean() > 0.8
    others = folder("other_images")
    image(others / "x.png")
    assert "there is no image a" in convert("tutorial", scene, "--overwrite", "--images", others, expect=2)

    # The wall is at depth 3, so that a camera that moves by .1 moves its image by ten pixels.
    (model / "cameras.txt").write_text("1 PINHOLE 320 240 300 300 160.5 120.5\n")
    (model / "points3D.txt").write_text("".join(f"{i} {(x - 160) / 100!r} {(y - 120) / 100!r} 3 0 0 0 0\n" for i, (x, y) in enumerate(keypoints.tolist())))
    (model / "images.txt").write_text("".join(
        f"{i} 1 0 0 0 {-i / 10} 0 0 1 {'abc'[i]}.png\n" + " ".join(f"{x - 10 * i + 0.5!r} {y + 0.5!r} {k}" for k, (x, y) in enumerate(keypoints.tolist())) + "\n"
        for i in range(3)))
    convert("colmap_points", model, ROOT / "out")
    with h5py.File(ROOT / "out" / "wall" / "scene_points.h5") as file:
        for i in range(3):
            points = file["abc"[i] + "/points"][()]
            seen = points[:, :2] * 100 + [160 - 10 * i, 120]
            assert len(points) > 50 and (np.linalg.norm(points[:, 3:] - seen, axis=1) < 2).mean() > 0.8
            assert (file["abc"[i] + "/pose"][:, 3] == [-i / 10, 0, 0]).all() and (file["abc"[i] + "/ratios"][()] <= 1).all()
    (model / "points3D.txt").write_text("1 2 3\n")
    assert "points3D.txt:1: expected POINT3D_ID" in convert("colmap_points", model, ROOT / "out", expect=2)
    (model / "cameras.txt").write_text("1 FOV 320 240 300 300 160.5 120.5 1\n")
    (model / "points3D.txt").write_text("1 2 3 4 5 6 7 8\n")
    assert "cameras.txt:1: expected CAMERA_ID MODEL" in convert("colmap_points", model, ROOT / "out", expect=2)


def test_adelaidermf_matches():
    here = folder("matlab")
    data = np.array([[1.5, 2, 1, 3, 4, 1], [5, 6, 1, 7, 8, 1]]).T
    savemat(here / "a-b.mat", {"data": data, "label": [[0, 2]], "img1": np.zeros((4, 5, 3), "u1"), "img2": np.zeros((6, 7), "u1")})
    convert("adelaidermf_matches", here, ROOT / "out", "--scene", "motions")
    with h5py.File(ROOT / "out" / "motions" / "matches.h5") as file:
        assert file["a_bA-a_bB"][()].tolist() == [[1.5, 2, 3, 4], [5, 6, 7, 8]]
    with h5py.File(ROOT / "out" / "motions" / "labels.h5") as file:
        assert file["a_bA-a_bB"][()].tolist() == [0, 2] and file["a_bA-a_bB"].dtype == "i4"
    with h5py.File(ROOT / "out" / "motions" / "sizes.h5") as file:
        assert file["a_bA-a_bB"][()].tolist() == [4, 5, 6, 7]
    savemat(here / "c.mat", {"data": data[:5]})
    assert "c.mat: expected a variable data" in convert("adelaidermf_matches", here, ROOT / "out", expect=2)


def test_segments():
    here = folder("nyu")
    (here / "lsd_lines_0000.csv").write_text("point1_x point1_y point2_x point2_y other\n10.5 20.25 30 40 7\n")
    (here / "vps_0000.csv").write_text("X Y\n100 200\n")
    convert("nyu_vp", here, ROOT / "out")
    with h5py.File(ROOT / "out" / "nyu_vp_train" / "segments.h5") as file:
        assert file["0000/segments"][()].tolist() == [[10.5, 20.25, 30, 40]]
        assert file["0000/vanishing_points"][()].tolist() == [[100, 200, 1]] and file["0000/K"][0, 0] == 518.85790117450188
    (here / "vps_0000.csv").write_text("X Z\n100 200\n")
    assert "vps_0000.csv:1: there is no column Y" in convert("nyu_vp", here, ROOT / "out", expect=2)
    (here / "vps_0000.csv").write_text("X Y\n100\n")
    assert "vps_0000.csv:2: expected 2 numbers" in convert("nyu_vp", here, ROOT / "out", expect=2)
    lines, points = folder("yud", "lines"), folder("yud", "vps")
    (lines / "P1.txt").write_text("point1_x point1_y point2_x point2_y\n1 2 3 4\n")
    savemat(points / "P1GroundTruthVP_CamParams.mat", {"vp": np.array([[0.0, 1], [1, 0], [0, 0]])})
    convert("yud_plus", ROOT / "yud", ROOT / "out")
    with h5py.File(ROOT / "out" / "yud_plus_train" / "segments.h5") as file:
        assert np.allclose(file["P1/vanishing_points"][()], [[0, -6.05317058975369 / 0.00896875, 0], [6.05317058975369 / 0.00896875, 0, 0]])


def test_registration():
    R, t = POSES[1]
    motion = np.column_stack([R, t])
    first = np.random.default_rng(0).normal(size=(20, 3))
    points = np.column_stack([first, first @ R.T + t])
    tcf, turboreg, macpp = folder("tcf", "data", "KITTI", "09"), folder("turboreg", "demo_data"), folder("macpp", "demo")
    (tcf / "7_5_top3.match").write_text(text(points))
    (tcf / "7-5.pose").write_text(text(motion))
    (turboreg / "003_fpfh_kpts_src.txt").write_text(text(points[:, :3]))
    (turboreg / "003_fpfh_kpts_dst.txt").write_text(text(points[:, 3:]))
    (turboreg / "003_trans.txt").write_text(text(np.vstack([motion, [0, 0, 0, 1]])))
    (macpp / "corr.txt").write_text(text(points))
    (macpp / "GTmat.txt").write_text(text(motion))
    for source, scene, name, limits in (("tcf", "tcf_kitti", "7_5", [0.6, 5, 0.6]), ("turboreg", "turboreg_kitti", "003", [0.6, 5, 0.6]), ("macpp", "macpp", "demo", [0.1, 15, 0.3])):
        convert("registration", ROOT / source, ROOT / "out")
        with h5py.File(ROOT / "out" / scene / "cloud_matches.h5") as file:
            assert (file[name + "/points"][()] == points).all() and np.allclose(file[name + "/motion"][()], motion, atol=1e-15)
            assert file[name + "/limits"][()].tolist() == limits
    (turboreg / "003_fpfh_kpts_dst.txt").write_text(text(points[1:, 3:]))
    assert "003_fpfh_kpts_src.txt: expected as many rows as in" in convert("registration", ROOT / "turboreg", ROOT / "out", expect=2)
    (macpp / "GTmat.txt").write_text(text(2 * motion))
    assert "GTmat.txt: the pose holds no rotation" in convert("registration", ROOT / "macpp", ROOT / "out", expect=2)
    assert "neither data/*/*/*_top3.match nor" in convert("registration", ROOT / "out", ROOT / "out", expect=2)


def test_matrix():
    here = folder("matrix")
    for given in (K, np.asfortranarray(K), K.astype(np.float32)):
        np.save(here / "K.npy", given)
        convert("matrix", here / "K.npy", here / "K.txt")
        assert (np.loadtxt(here / "K.txt") == K).all()
    np.save(here / "K.npy", K[:2])
    assert "K.npy: expected one array of 3 x 3 numbers" in convert("matrix", here / "K.npy", here / "K.txt", expect=2)


for name, test in list(globals().items()):
    if name.startswith("test_"):
        test()
        print(name)
assert "no such folder" in convert("poses", ROOT / "nobody", ROOT / "out" / "x", "--focal", 1, "--center", "0,0", expect=2)
