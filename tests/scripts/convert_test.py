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
