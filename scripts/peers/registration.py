#!/usr/bin/env python3
"""Motions between point clouds: matches of indoor fragments, and other people's estimators of the motion between matched clouds.

  PYTHON scripts/peers/registration.py fragments DIR/scenes/redkitchen/data DIR/scenes/fragment_pairs OUT
  PYTHON scripts/peers/registration.py record --clouds SCENE... --output FILE.csv [--seeds 3]
  PYTHON scripts/peers/registration.py compare SCENE... [--repetitions 10]
  PYTHON scripts/peers/registration.py scans registrations.csv DIR/scenes/fragment_pairs

fragments: 1000 frames of 7-Scenes' redkitchen (andyzeng/tsdf-fusion-python) and the lists of pairs of 3DMatch and 3DLoMatch with their
motions (in qinzheng93/GeoTransformer; scripts/scenes.sh fetches both). Each 50 frames become a fragment: depths of every second frame
averaged in cubes of 2.5 cm (OUT/fragments/NN.ply). 5000 points of a fragment, drawn at random, have FPFH descriptors of 12.5 cm (Open3D);
each is matched with the nearest of the other fragment, with the ratio to the second one. The first half of the pairs of each list goes to
OUT/tuning, the second to OUT/test, for `type: cloud_matches`; inliers are within .1 m, a motion is right within 15 degrees and .3 m.

record: models of Open3D (RANSAC with its checkers of edges and distances; fast global registration) and KISS-Matcher as a CSV file of
which diffsac_eval makes rows of type `recorded`. ms is the processor time of the call alone, that of all its threads. What a killed
program has finished is in FILE.csv.part[.gz], where the same command goes on.

compare: the same calls of Open3D and of diffsac.open3d, by all threads: right ones, time, and whether repetitions have the same digits.
scans: counts of `python -m diffsac.register OUT/fragments`: right motions, and which of them the pose graph has.

PYTHON has open3d==0.20.0, kiss-matcher==1.0.2, numpy, h5py and opencv-python-headless; compare needs diffsac too.
"""
import argparse
import csv
import os
import sys
import time

if sys.argv[1:2] != ["compare"]:
    for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[threads] = "1"
import cv2
import h5py
import numpy as np
import open3d

from two_view import read_rows, write_rows

FRAMES, STEP, CUBE, KEYPOINTS, LIMITS = 50, 2, 0.025, 5000, (0.1, 15.0, 0.3)
NEAREST, FARTHEST = 0.4, 4.0       # metres that the sensor tells


def fragment(folder, first):
    """Points in the camera of the first frame."""
    K = np.loadtxt(f"{folder}/camera-intrinsics.txt")
    pose = [np.loadtxt(f"{folder}/frame-{i:06d}.pose.txt") for i in range(first, first + FRAMES)]
    rows, columns = np.mgrid[0:480:2, 0:640:2]
    clouds = []
    for i in range(0, FRAMES, STEP):
        depth = cv2.imread(f"{folder}/frame-{first + i:06d}.depth.png", cv2.IMREAD_UNCHANGED)[::2, ::2] / 1000.0
        seen = (depth > NEAREST) & (depth < FARTHEST)
        z = depth[seen]
        points = np.stack([(columns[seen] - K[0, 2]) / K[0, 0] * z, (rows[seen] - K[1, 2]) / K[1, 1] * z, z], 1)
        motion = np.linalg.inv(pose[0]) @ pose[i]
        clouds.append(points @ motion[:3, :3].T + motion[:3, 3])
    points = np.concatenate(clouds)
    cube = np.floor(points / CUBE).astype(np.int64)
    cube -= cube.min(0)
    _, place, count = np.unique((cube[:, 0] * 4096 + cube[:, 1]) * 4096 + cube[:, 2], return_inverse=True, return_counts=True)
    means = np.stack([np.bincount(place.ravel(), points[:, k]) for k in range(3)], 1) / count[:, None]
    return means[count >= 4]       # fewer: what flies between edges


def described(points, seed):
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    cloud.estimate_normals(open3d.geometry.KDTreeSearchParamHybrid(2 * CUBE, 30))
    cloud.orient_normals_towards_camera_location(np.zeros(3))
    search = open3d.geometry.KDTreeSearchParamHybrid(5 * CUBE, 100)
    features = open3d.pipelines.registration.compute_fpfh_feature(cloud, search).data.T
    kept = np.random.default_rng(seed).permutation(len(points))[:KEYPOINTS]
    return points[kept], features[kept].astype(np.float32)


def listed(path, fragments):
    """(i, j, motion from j to i) of fragments that are not neighbours."""
    with open(path) as file:
        lines = file.read().splitlines()
    for k in range(0, len(lines) - 4, 5):
        i, j = (int(word) for word in lines[k].split()[:2])
        if max(i, j) < fragments and abs(i - j) > 1:
            yield i, j, np.array([[float(word) for word in line.split()] for line in lines[k + 1:k + 4]])


def fragments(folder, lists, output):
    count = len([name for name in os.listdir(folder) if name.endswith(".depth.png")]) // FRAMES
    sides = []
    os.makedirs(f"{output}/fragments", exist_ok=True)
    for i in range(count):
        points = fragment(folder, FRAMES * i)
        cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
        open3d.io.write_point_cloud(f"{output}/fragments/{i:02d}.ply", cloud)
        sides.append(described(points, i))
    for overlap, benchmark in (("high", "3DMatch"), ("low", "3DLoMatch")):
        pairs = list(listed(f"{lists}/data/3DMatch/metadata/benchmarks/{benchmark}/7-scenes-redkitchen/gt.log", count))
        for use, part in (("tuning", pairs[:len(pairs) // 2]), ("test", pairs[len(pairs) // 2:])):
            scene = f"{output}/{use}/redkitchen_{overlap}"
            os.makedirs(scene, exist_ok=True)
            with h5py.File(f"{scene}/cloud_matches.h5", "w") as file:
                for i, j, motion in part:
                    found = cv2.BFMatcher(cv2.NORM_L2).knnMatch(sides[j][1], sides[i][1], k=2)
                    rows = [(a.queryIdx, a.trainIdx) for a, _ in found]
                    own, other = np.transpose(rows)
                    group = file.create_group(f"{i:02d}_{j:02d}")
                    group["points"] = np.hstack([sides[j][0][own], sides[i][0][other]])
                    group["ratios"] = [a.distance / max(b.distance, 1e-12) for a, b in found]
                    group["motion"], group["limits"] = motion, LIMITS
            print(f"{scene}: {len(part)} pairs")


def matched_clouds(first, second, seed):
    open3d.utility.random.seed(seed)
    clouds = [open3d.geometry.PointCloud(open3d.utility.Vector3dVector(side)) for side in (first, second)]
    return *clouds, open3d.utility.Vector2iVector(np.repeat(np.arange(len(first), dtype=np.int32)[:, None], 2, 1))


def open3d_ransac(first, second, epsilon, seed):
    registration = open3d.pipelines.registration
    matches = matched_clouds(first, second, seed)
    checkers = [registration.CorrespondenceCheckerBasedOnEdgeLength(0.9), registration.CorrespondenceCheckerBasedOnDistance(epsilon)]
    return lambda: registration.registration_ransac_based_on_correspondence(
        *matches, epsilon, registration.TransformationEstimationPointToPoint(False), 3, checkers,
        registration.RANSACConvergenceCriteria(100_000, 0.9999)).transformation


def open3d_fgr(first, second, epsilon, seed):
    registration = open3d.pipelines.registration
    matches = matched_clouds(first, second, seed)
    option = registration.FastGlobalRegistrationOption(maximum_correspondence_distance=epsilon, use_absolute_scale=True)
    return lambda: registration.registration_fgr_based_on_correspondence(*matches, option).transformation


def kiss(first, second, epsilon, seed):
    import kiss_matcher
    matcher = kiss_matcher.KISSMatcher(kiss_matcher.KISSMatcherConfig(voxel_size=epsilon / 2))
    sides = [list(np.asarray(side, np.float32)) for side in (first, second)]

    def call():
        found = matcher.prune_and_solve(*sides)
        return np.vstack([np.column_stack([found.rotation, found.translation]), [0, 0, 0, 1]]) if found.valid else None
    return call


PEERS = {"open3d_ransac": open3d_ransac, "open3d_fgr": open3d_fgr, "kiss_matcher": kiss}


def rows_of(identity, points, epsilon, seeds):
    for peer, make in PEERS.items():
        for seed in range(1, seeds + 1):
            call = make(points[:, :3], points[:, 3:], epsilon, seed)
            start = time.process_time()
            motion = call()
            ms = 1000 * (time.process_time() - start)
            model = "" if motion is None else " ".join(repr(float(v)) for v in np.asarray(motion)[:3].reshape(-1))
            yield [peer, "all", identity, str(seed), f"{ms:.3f}", model]


def record(arguments):
    packed = ".gz" if arguments.output.endswith(".gz") else ""
    part, blocks = f"{arguments.output.removesuffix('.gz')}.part{packed}", {}
    first = [f"# scripts/peers/registration.py record; open3d {open3d.__version__}, kiss-matcher 1.0.2; ms: processor time; "
             f"{arguments.seeds} seeds of {' '.join(arguments.clouds)}\n"]
    if os.path.exists(part):
        made_by, rows = read_rows(part)
        for row in rows if made_by == first else []:
            blocks.setdefault(row[2], []).append(row)
    for scene in arguments.clouds:
        with h5py.File(f"{scene}/cloud_matches.h5") as pairs:
            for name in pairs:
                identity = f"{os.path.basename(os.path.normpath(scene))}/{name}"
                if identity not in blocks:
                    points, epsilon = pairs[f"{name}/points"][()], float(pairs[f"{name}/limits"][0])
                    blocks[identity] = list(rows_of(identity, points, epsilon, arguments.seeds))
                    write_rows(part, first, blocks)
        print(f"{scene}: done", flush=True)
    os.replace(part, arguments.output)


def rigid_error(motion, truth):
    """Degrees and metres, as docs/registration.md counts."""
    cosine = 0.5 * (np.trace(truth[:, :3].T @ motion[:, :3]) - 1.0)
    return np.degrees(np.arccos(np.clip(cosine, -1, 1))), np.linalg.norm(motion[:, 3] - truth[:, 3])


def calls(ours, theirs, epsilon):
    """Each of the two ways of both, of (two clouds, correspondences, seed), in calls that differ by the module alone."""
    checkers = [theirs.CorrespondenceCheckerBasedOnEdgeLength(0.9), theirs.CorrespondenceCheckerBasedOnDistance(epsilon)]
    option = theirs.FastGlobalRegistrationOption(maximum_correspondence_distance=epsilon, use_absolute_scale=True)
    ransac = (epsilon, theirs.TransformationEstimationPointToPoint(False), 3, checkers, theirs.RANSACConvergenceCriteria(100_000, 0.999))

    def seeded(function, *more):
        def call(first, second, matches, seed):
            open3d.utility.random.seed(seed)
            return function(first, second, matches, *more, **({"seed": seed} if function.__module__.startswith("diffsac") else {}))
        return call
    return {f"{name}, {way}": seeded(getattr(module, f"registration_{way}_based_on_correspondence"), *more)
            for way, more in (("ransac", ransac), ("fgr", (option,))) for name, module in (("Open3D", theirs), ("diffsac.open3d", ours))}


def compare(arguments):
    """A line a set and call: right ones, milliseconds, and pairs whose repetitions of one seed give the same digits."""
    import diffsac.open3d
    cores = open3d.utility.get_max_threads()
    print(f"open3d {open3d.__version__}, {cores} threads; right of seeds 1 to {arguments.repetitions}, wall ms; seed 1 as often, with 1, 2 and 8 threads")
    for scene in arguments.scenes:
        totals = {}
        with h5py.File(f"{scene}/cloud_matches.h5") as pairs:
            for name in pairs:
                points, truth, limits = (pairs[f"{name}/{key}"][()] for key in ("points", "motion", "limits"))
                given = matched_clouds(points[:, :3], points[:, 3:], 1)
                for way, call in calls(diffsac.open3d, open3d.pipelines.registration, float(limits[0])).items():
                    total, same = totals.setdefault(way, [0, 0, 0.0, 0, 0]), []
                    for seed in range(1, arguments.repetitions + 1):
                        start = time.perf_counter()
                        motion = call(*given, seed).transformation[:3]
                        total[2] += 1000 * (time.perf_counter() - start)
                        total[0] += bool(np.all(np.less(rigid_error(motion, truth), limits[1:])))
                        total[1] += 1
                        open3d.utility.set_max_threads((1, 2, 8)[seed % 3])
                        same.append(np.asarray(call(*given, 1).transformation).tobytes())
                        open3d.utility.set_max_threads(cores)
                    total[3] += len(set(same)) == 1
                    total[4] += 1
        for way, (right, runs, ms, same, count) in totals.items():
            print(f"| {os.path.basename(os.path.normpath(scene))} | {way} | {right} of {runs} | {ms / runs:.1f} | {same} of {count} |", flush=True)


def scans(arguments):
    """Of registrations.csv of pairs of the fragments: how many of each list are right, and how many are no edges of the pose graph."""
    with open(arguments.registrations) as file:
        rows = {(row["second"], row["first"]): row for row in csv.DictReader(file)}
    for benchmark in ("3DMatch", "3DLoMatch"):
        told = {True: [], False: []}
        for i, j, truth in listed(f"{arguments.lists}/data/3DMatch/metadata/benchmarks/{benchmark}/7-scenes-redkitchen/gt.log", 20):
            row = rows.get((f"{j:02d}.ply", f"{i:02d}.ply"))
            if row is None:
                continue
            x, y, z, w = (float(row[name] or 0) for name in ("qx", "qy", "qz", "qw"))
            motion = np.zeros((3, 4))
            motion[:, :3] = np.eye(3) + 2 * np.array([[-y * y - z * z, x * y - z * w, x * z + y * w], [x * y + z * w, -x * x - z * z, y * z - x * w],
                                                      [x * z - y * w, y * z + x * w, -x * x - y * y]])
            motion[:, 3] = [float(row[name] or 0) for name in "xyz"]
            right = row["status"] == "ok" and bool(np.all(np.less(rigid_error(inverse(motion), truth), LIMITS[1:])))
            told[right].append(row["edge"] == "1")
        print(f"{benchmark}: {len(told[True])} of {len(told[True]) + len(told[False])} right, {told[True].count(False)} of them no edge; "
              f"{sum(told[False])} of {len(told[False])} wrong ones are an edge")


def inverse(motion):
    return np.column_stack([motion[:, :3].T, -motion[:, :3].T @ motion[:, 3]])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    making = commands.add_parser("fragments")
    for name in ("folder", "lists", "output"):
        making.add_argument(name)
    recording = commands.add_parser("record")
    recording.add_argument("--clouds", nargs="+", required=True)
    recording.add_argument("--output", required=True)
    recording.add_argument("--seeds", type=int, default=3)
    comparing = commands.add_parser("compare")
    comparing.add_argument("scenes", nargs="+")
    comparing.add_argument("--repetitions", type=int, default=10)
    counting = commands.add_parser("scans")
    for name in ("registrations", "lists"):
        counting.add_argument(name)
    arguments = parser.parse_args()
    try:
        if arguments.command == "fragments":
            fragments(arguments.folder, arguments.lists, arguments.output)
        else:
            {"record": record, "compare": compare, "scans": scans}[arguments.command](arguments)
    except OSError as error:
        sys.exit(f"registration.py: {error}")


if __name__ == "__main__":
    main()
