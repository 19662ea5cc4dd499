#!/usr/bin/env python3
"""Motions between point clouds: matches of indoor fragments, and other people's estimators of the motion between matched clouds.

  PYTHON scripts/peers/registration.py fragments DIR/scenes/redkitchen/data DIR/scenes/fragment_pairs OUT
  PYTHON scripts/peers/registration.py record --clouds SCENE... --output FILE.csv [--seeds 3]
  PYTHON scripts/peers/registration.py judge DIR/scenes/redkitchen/data DIR/clouds --output FILE.json [--seeds 2]

fragments: 1000 frames of 7-Scenes' redkitchen (andyzeng/tsdf-fusion-python) and the lists of pairs of 3DMatch and 3DLoMatch with their
motions (in qinzheng93/GeoTransformer; scripts/scenes.sh fetches both). Each 50 frames become a fragment: depths of every second frame
averaged in cubes of 2.5 cm. 5000 points of a fragment, drawn at random, have FPFH descriptors of 12.5 cm (Open3D); each is matched with
the nearest of the other fragment, with the ratio to the second one. The first half of the pairs of each list goes to OUT/tuning, the
second to OUT/test, for `type: cloud_matches`; inliers are within .1 m, a motion is right within 15 degrees and .3 m.

record: models of Open3D (RANSAC with its checkers of edges and distances; fast global registration) and KISS-Matcher as a CSV file of
which diffsac_eval makes rows of type `recorded`. ms is the processor time of the call alone, that of all its threads. What a killed
program has finished is in FILE.csv.part[.gz], where the same command goes on.

judge: about ten motions of each pair that estimates of parts of the matches find, and whether what the clouds and depth images say of them
(overlap, normals, points in front of what is seen) chooses better than the score. FILE.json keeps what was measured. Needs the module diffsac.

PYTHON has open3d==0.20.0, kiss-matcher==1.0.2, numpy, h5py and opencv-python-headless.
"""
import argparse
import functools
import itertools
import json
import os
import sys
import time

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
    sides = [described(fragment(folder, FRAMES * i), i) for i in range(count)]
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


def is_right(motion, truth):
    return bool(np.all(np.less(rigid_error(motion, truth), LIMITS[1:])))


def moved(motion, points):
    return points @ motion[:, :3].T + motion[:, 3]


def inverse(motion):
    return np.column_stack([motion[:, :3].T, -motion[:, :3].T @ motion[:, 3]])


def score(motion, points):
    """As the estimator's: MSAC over noise scales from a quarter of the threshold to half as much again."""
    squared = ((moved(motion, points[:, :3]) - points[:, 3:]) ** 2).sum(1)
    scales = LIMITS[0] * np.geomspace(0.25, 1.5, 10)
    return np.mean([np.maximum(0, 1 - squared / s ** 2).sum() for s in scales])


def candidates(points, ratios, seed):
    """About ten motions that the estimator finds by itself, the first with all matches; the best by score come first, no two alike."""
    from diffsac import estimate_rigid_motion
    rng, n = np.random.default_rng(seed), len(points)
    by_ratio = np.argsort(ratios)
    single = by_ratio[np.unique(points[by_ratio, 3:], axis=0, return_index=True)[1]]      # the best match of each point of the other
    parts = [np.arange(n), *(rng.permutation(n)[:n // k] for k in (2, 2, 2, 3, 3, 3, 3)), single, by_ratio[:n // 2]]
    found = []
    for k, part in enumerate(parts):
        e = estimate_rigid_motion(points[part, :3], points[part, 3:], ratios[part], max_distance=LIMITS[0], seed=100 * seed + k)
        found += [np.column_stack([m.rotation, m.translation]) for m in (e.motion, e.ambiguous_motion) if e.ok and m is not None]
    usual, kept = (found[0] if found else None), []
    for motion in sorted(found, key=lambda m: -score(m, points)):
        if all(a > 5 or b > 0.1 for a, b in (rigid_error(motion, other) for other in kept)):
            kept.append(motion)
    return usual, kept


def views(folder, first):
    """K, and five depth images of a fragment with the motions from its frame into each camera."""
    K = np.loadtxt(f"{folder}/camera-intrinsics.txt")
    pose = [np.loadtxt(f"{folder}/frame-{i:06d}.pose.txt") for i in range(first, first + FRAMES)]
    return K, [((np.linalg.inv(pose[i]) @ pose[0])[:3], cv2.imread(f"{folder}/frame-{first + i:06d}.depth.png", cv2.IMREAD_UNCHANGED) / 1000.0)
               for i in range(0, FRAMES, FRAMES // 5)]


def seen_through(points, K, images):
    """Of points that the images would see or do see, the share that lies more than .1 m in front of what is seen there."""
    before, agree = np.zeros(len(points), bool), np.zeros(len(points), bool)
    for motion, depth in images:
        x = moved(motion, points)
        with np.errstate(divide="ignore", invalid="ignore"):
            u, v = (np.nan_to_num(x[:, k] / x[:, 2] * K[k, k] + K[k, 2], nan=-1, posinf=-1, neginf=-1) for k in (0, 1))
        inside = (x[:, 2] > NEAREST) & (u >= 0) & (u < 639) & (v >= 0) & (v < 479)
        seen = np.where(inside, depth[np.where(inside, v + 0.5, 0).astype(int), np.where(inside, u + 0.5, 0).astype(int)], 0)
        valid = (seen > NEAREST) & (seen < FARTHEST)
        before |= valid & (x[:, 2] < seen - 0.1)
        agree |= valid & (abs(x[:, 2] - seen) <= 0.1)
    return (before & ~agree).sum() / max(1, (before | agree).sum())


NAMES = ["log score", "log overlap", "normals", "seen through", "moved by ICP"]


def features(motion, points, side, other):
    """side, other: (some points, cloud, views). What NAMES says, but for the score after five steps of ICP from the motion."""
    registration = open3d.pipelines.registration
    refined = registration.registration_icp(side[0], other[1], LIMITS[0], np.vstack([motion, [0, 0, 0, 1]]),
                                            registration.TransformationEstimationPointToPlane(),
                                            registration.ICPConvergenceCriteria(0, 0, 5)).transformation[:3]
    both = []
    for (some, _, _), (_, cloud, images), way in ((side, other, refined), (other, side, inverse(refined))):
        found = registration.evaluate_registration(some, cloud, 2 * CUBE, np.vstack([way, [0, 0, 0, 1]]))
        a, b = np.asarray(found.correspondence_set).reshape(-1, 2).T
        cosine = (np.asarray(some.normals)[a] @ way[:, :3].T * np.asarray(cloud.normals)[b]).sum(1)
        both.append([found.fitness, cosine.mean() if len(a) else 0.0, seen_through(moved(way, np.asarray(some.points)), *images)])
    overlap, normals, through = np.mean(both, 0)
    return [np.log1p(score(motion, points)), np.log(overlap + 1e-3), normals, through, rigid_error(refined, motion)[1]]


def judged_pairs(folder, clouds, output, seeds):
    """Candidates and features of all pairs, in a file that later calls read."""
    @functools.cache
    def side(number):
        cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(fragment(folder, FRAMES * number)))
        cloud.estimate_normals(open3d.geometry.KDTreeSearchParamHybrid(2 * CUBE, 30))
        cloud.orient_normals_towards_camera_location(np.zeros(3))
        thin = cloud.voxel_down_sample(2 * CUBE).normalize_normals()
        some = thin.select_by_index(np.random.default_rng(number).permutation(len(thin.points))[:1000])
        return some, thin, views(folder, FRAMES * number)

    rows = []
    for seed, half, overlap in itertools.product(range(1, seeds + 1), ("tuning", "test"), ("low", "high")):
        with h5py.File(f"{clouds}/{half}/redkitchen_{overlap}/cloud_matches.h5") as pairs:
            for name in pairs:
                other, own = (side(int(number)) for number in name.split("_"))
                points, ratios, truth = (pairs[f"{name}/{key}"][()] for key in ("points", "ratios", "motion"))
                usual, found = candidates(points, ratios, seed)
                rows.append({"half": half, "overlap": overlap, "pair": name, "seed": seed, "right": [is_right(m, truth) for m in found],
                             "usual": usual is not None and is_right(usual, truth), "features": [features(m, points, own, other) for m in found]})
        print(f"seed {seed}, {half}, {overlap} overlap: done", flush=True)
    with open(output, "w") as file:
        json.dump(rows, file)


def fitted(rows, columns):
    """Logistic regression with a ridge of 1 on standardised features: candidates of the tuning half. The function that judges."""
    X = np.vstack([r["features"] for r in rows if r["right"]])[:, columns]
    y = np.concatenate([r["right"] for r in rows if r["right"]]).astype(float)
    mean, spread = X.mean(0), X.std(0) + 1e-9
    Z, w = np.column_stack([(X - mean) / spread, np.ones(len(X))]), np.zeros(len(columns) + 1)
    ridge = np.diag([1.0] * len(columns) + [0.0])
    for _ in range(30):
        p = 1 / (1 + np.exp(-Z @ w))
        w -= np.linalg.solve(Z.T @ (Z * (p * (1 - p))[:, None]) + ridge, Z.T @ (p - y) + ridge @ w)
    print("logistic:", ", ".join(f"{NAMES[c]} {v:+.2f}" for c, v in zip(columns, w)))
    return lambda features: ((features[:, columns] - mean) / spread) @ w[:-1] + w[-1]


def judge(arguments):
    if not os.path.exists(arguments.output):
        judged_pairs(arguments.folder, arguments.clouds, arguments.output, arguments.seeds)
    with open(arguments.output) as file:
        rows = json.load(file)
    tuning = [r for r in rows if r["half"] == "tuning"]
    ways = {"score": lambda f: f[:, 0], "overlap": lambda f: f[:, 1], "least seen through": lambda f: -f[:, 3],
            "logistic, score and overlap": fitted(tuning, [0, 1]), "logistic, all but seen through": fitted(tuning, [0, 1, 2, 4]),
            "logistic, all": fitted(tuning, list(range(len(NAMES))))}
    values = {"one estimate": lambda r: r["usual"],
              **{name: lambda r, way=way: bool(r["right"]) and r["right"][np.argmax(way(np.array(r["features"])))] for name, way in ways.items()},
              "best of the candidates": lambda r: any(r["right"])}
    for half, overlap in itertools.product(("tuning", "test"), ("high", "low")):
        part = [r for r in rows if r["half"] == half and r["overlap"] == overlap]
        names = sorted({r["pair"] for r in part})
        table = {name: np.array([np.mean([value(r) for r in part if r["pair"] == pair]) for pair in names]) for name, value in values.items()}
        draws = np.random.default_rng(1).integers(0, len(names), (2000, len(names)))
        print(f"\n{half}, {overlap} overlap: {len(names)} pairs, {np.mean([len(r['right']) for r in part]):.1f} candidates a pair")
        pools = [{key: np.concatenate([r[key] for r in part if r["pair"] == pair and r["right"]] or [[]]) for key in ("features", "right")} for pair in names]
        pools = [pool for pool in pools if len(pool["right"])]
        print("of all seeds' motions:", ", ".join(f"{name} {sum(int(p['right'][np.argmax(way(p['features']))]) for p in pools)}" for name, way in ways.items()))
        told = [(values["logistic, all"](r), max(ways["logistic, all"](np.array(r["features"]))) > 0) for r in part if r["right"]]
        for kind in (True, False):
            sure = [above for right, above in told if right == kind]
            print(f"{'right' if kind else 'wrong'} by all features: {len(sure)}, {sum(sure)} of them of probability above .5")
        for name, right in table.items():
            cells = ([column.mean(), *np.percentile(column[draws].mean(1), [2.5, 97.5])] for column in (right, right - table["score"]))
            print("| {} | {:.3f} [{:.3f}, {:.3f}] | {:+.3f} [{:+.3f}, {:+.3f}] |".format(name, *itertools.chain(*cells)))


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
    judging = commands.add_parser("judge")
    for name in ("folder", "clouds"):
        judging.add_argument(name)
    judging.add_argument("--output", required=True)
    judging.add_argument("--seeds", type=int, default=2)
    arguments = parser.parse_args()
    try:
        if arguments.command == "fragments":
            fragments(arguments.folder, arguments.lists, arguments.output)
        elif arguments.command == "judge":
            judge(arguments)
        else:
            record(arguments)
    except OSError as error:
        sys.exit(f"registration.py: {error}")


if __name__ == "__main__":
    main()
