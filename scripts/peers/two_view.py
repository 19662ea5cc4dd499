#!/usr/bin/env python3
"""Other people's estimators of essential and fundamental matrices, and of two unknown focal lengths, on the pairs of a run of
diffsac_eval: their models as a CSV file, from which diffsac_eval makes rows of type `recorded`. Not part of the build;
scripts/peers/environment.sh makes the environment of it.

  P=.deps/peers/bin/python
  $P scripts/peers/two_view.py --task fundamental --run RUN --scenes SCENE... --output FILE.csv [--seeds 5] [--peers poselib,magsac]
  $P scripts/peers/two_view.py --summary FILE.csv --scenes SCENE...

RUN is a folder that diffsac_eval wrote, whose problems.csv says which pairs of which condition; SCENE a folder of pairs that it read.
The CSV's first lines tell versions and options of every row; then row,condition,id,seed,ms,model. `model` is nine numbers row by row,
of norm 1: E in coordinates of the cameras (K^-1 pixel), F in pixels, (0, 0) the centre of the first one; of two_focals E and then both
focal lengths in pixels, about the middles of the images. It is empty where there is no estimate. `ms` is processor time of the
library's call alone. What a killed program has finished is in FILE.csv.part[.gz], where the same command goes on. --summary prints
mAA@10deg as docs/metrics.md has it, F decomposed with the true cameras.
"""
import os

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[threads] = "1"
import argparse
import collections
import csv
import functools
import gzip
import importlib
import importlib.metadata
import platform
import shlex
import signal
import sys
import time
import types

LIBRARIES = {"numpy": "numpy", "h5py": "h5py", "cv2": "opencv-python-headless", "poselib": "poselib", "pysuperansac": "pysuperansac",
             "pymagsac": "pymagsac", "pydegensac": "pydegensac", "pycolmap": "pycolmap"}


def need(module):
    try:
        importlib.import_module(module)
    except ImportError:
        print(f"two_view.py: no library '{module}' of Python; scripts/peers/environment.sh makes .deps/peers with it", file=sys.stderr)
        sys.exit(2)


for module in ("numpy", "h5py", "cv2"):
    need(module)
import cv2
import numpy as np

from peer_pairs import accuracy, conditions_of, errors_of_matrix, existing, fail, matrix_of, normalized, pair_ids, read_pair, select

EPSILON_PX, ITERATIONS, FEWEST_ITERATIONS, CONFIDENCE = 1.0, 1000, 100, 0.9999
SUPERANSAC_PX = {"essential": 4.0, "fundamental": 2.0}     # of its examples: with 1 px it is worse
CONDITIONS = {"all matches": 1.0, "ratio 0.85": 0.85, **{  # the greatest ratio; 1 - score where matches have scores
    name + cut: greatest for name in ("ALIKED + LightGlue", "XFeat + LighterGlue") for cut, greatest in (("", 1.0), (", score .1 or more", 0.9))}}
FEWEST_POINTS = 8
COLUMNS = ["row", "condition", "id", "seed", "ms", "model"]


def sides(pair):
    return np.ascontiguousarray(pair.matches[:, :2]), np.ascontiguousarray(pair.matches[:, 2:])


# Each takes a task, a pair whose matches are in the order of their ratio, and a seed; it gives the call that is timed, and a function
# that makes a matrix, or None, of what the call gives.

def poselib_options(seed, pixels=EPSILON_PX):
    return {"max_epipolar_error": pixels, "max_iterations": ITERATIONS, "min_iterations": FEWEST_ITERATIONS,
            "success_prob": CONFIDENCE, "progressive_sampling": True, "seed": seed}


def poselib(task, pair, seed, pixels=EPSILON_PX):
    import poselib as library
    options = poselib_options(seed, pixels)
    first, second = sides(pair)
    if task == "fundamental":
        def matrix(found):
            return found[0] if found[1]["num_inliers"] >= 7 else None
        return lambda: library.estimate_fundamental(first, second, options, {}), matrix
    cameras = [{"model": "PINHOLE", "width": int(width), "height": int(height), "params": [k[0, 0], k[1, 1], k[0, 2], k[1, 2]]}
               for k, (width, height) in ((pair.k1, pair.sizes[:2]), (pair.k2, pair.sizes[2:]))]
    def matrix(found):
        return matrix_of(found[0]) if found[1]["num_inliers"] >= 5 else None
    return lambda: library.estimate_relative_pose(first, second, *cameras, options, {}), matrix


def superansac(task, pair, seed):
    import pysuperansac as library
    settings = library.RANSACSettings()          # new ones for every call: the library scales the threshold in them
    settings.inlier_threshold = SUPERANSAC_PX[task]
    settings.min_iterations, settings.max_iterations, settings.confidence = FEWEST_ITERATIONS, ITERATIONS, CONFIDENCE
    matches = np.ascontiguousarray(pair.matches)
    if task == "fundamental":
        return lambda: library.estimateFundamentalMatrix(matches, list(pair.sizes), config=settings), lambda found: found[0]
    return lambda: library.estimateEssentialMatrix(matches, pair.k1, pair.k2, list(pair.sizes), config=settings), lambda found: found[0]


def magsac(task, pair, seed):
    import pymagsac as library
    options = dict(probabilities=[], sampler=1, use_magsac_plus_plus=True, sigma_th=EPSILON_PX, conf=CONFIDENCE,
                   min_iters=FEWEST_ITERATIONS, max_iters=ITERATIONS)
    matches = np.ascontiguousarray(pair.matches)
    if task == "fundamental":
        return lambda: library.findFundamentalMatrix(matches, *pair.sizes, **options), lambda found: found[0]
    return lambda: library.findEssentialMatrix(matches, pair.k1, pair.k2, *pair.sizes, **options), lambda found: found[0]


def degensac(task, pair, seed):
    import pydegensac as library
    first, second = sides(pair)
    return (lambda: library.findFundamentalMatrix(first, second, EPSILON_PX, CONFIDENCE, ITERATIONS, seed=seed),
            lambda found: found[0])


def colmap(task, pair, seed):
    import pycolmap as library
    options = library.RANSACOptions()
    options.max_error, options.confidence, options.random_seed = EPSILON_PX, CONFIDENCE, seed
    options.min_num_trials, options.max_num_trials = FEWEST_ITERATIONS, ITERATIONS
    first, second = (side + 0.5 for side in sides(pair))     # its pixels begin at the corner
    if task == "fundamental":
        shift = np.array([[1, 0, 0.5], [0, 1, 0.5], [0, 0, 1]])
        return (lambda: library.estimate_fundamental_matrix(first, second, options),
                lambda found: shift.T @ found["F"] @ shift if found else None)
    cameras = [library.Camera(model="PINHOLE", width=int(width), height=int(height),
                              params=[k[0, 0], k[1, 1], k[0, 2] + 0.5, k[1, 2] + 0.5])
               for k, (width, height) in ((pair.k1, pair.sizes[:2]), (pair.k2, pair.sizes[2:]))]
    return (lambda: library.estimate_essential_matrix(first, second, *cameras, options),
            lambda found: found["E"] if found else None)


def opencv_accurate(task, pair, seed):
    order = np.random.default_rng(seed).permutation(len(pair.matches))
    if task == "fundamental":
        first, second = (side[order] for side in sides(pair))
        return (lambda: cv2.findFundamentalMat(first, second, cv2.USAC_ACCURATE, EPSILON_PX, CONFIDENCE, ITERATIONS),
                lambda found: found[0])
    points = normalized(pair)[order]
    first, second = points[:, :2].copy(), points[:, 2:].copy()
    threshold = EPSILON_PX / np.mean([pair.k1[0, 0], pair.k1[1, 1], pair.k2[0, 0], pair.k2[1, 1]])
    return (lambda: cv2.findEssentialMat(first, second, np.eye(3), cv2.USAC_ACCURATE, CONFIDENCE, threshold, ITERATIONS),
            lambda found: found[0])


def middles(pair):
    return [np.array([width - 1, height - 1]) / 2 for width, height in (pair.sizes[:2], pair.sizes[2:])]


def calibration(focal, middle):
    return np.array([[focal, 0, middle[0]], [0, focal, middle[1]], [0, 0, 1]])


def likely_focals(pair):
    """COLMAP's guess."""
    return [1.2 * max(size) for size in (pair.sizes[:2], pair.sizes[2:])]


def two_focals(matrix, focals):
    """E of norm 1 and the focal lengths as one row; None where one is none."""
    if not all(np.isfinite(focals)) or min(focals) <= 0 or not np.isfinite(matrix).all() or not np.any(matrix):
        return None
    return np.array([*(matrix / np.linalg.norm(matrix)).reshape(-1), *focals])


def poselib_focals(task, pair, seed, iterative=False):
    """F, and the focal lengths that it says: by Bougnoux' formula, or those nearest to a prior (Kocur and others, CVPR 2024)."""
    import poselib as library
    estimate, read = poselib("fundamental", pair, seed)
    def call():
        f = read(estimate())
        if f is None:
            return None
        if iterative:
            cameras = [library.Camera("SIMPLE_PINHOLE", [focal, *middle], int(width), int(height))
                       for focal, middle, (width, height) in zip(likely_focals(pair), middles(pair), (pair.sizes[:2], pair.sizes[2:]))]
            first, second, _ = library.focals_from_fundamental_iterative(f, *cameras)
        else:
            first, second = library.focals_from_fundamental(f, *middles(pair))
        return f, (first.params[0], second.params[0])
    def model(found):
        k1, k2 = (calibration(focal, middle) for focal, middle in zip(found[1], middles(pair)))
        return two_focals(k2.T @ found[0] @ k1, found[1])
    return call, model


def poselib_iterative(task, pair, seed):
    return poselib_focals(task, pair, seed, iterative=True)


def poselib_shared_focal(task, pair, seed):
    """One unknown focal length of both images, about their middles."""
    import poselib as library
    first, second = (np.ascontiguousarray(side - middle) for side, middle in zip(sides(pair), middles(pair)))
    options = poselib_options(seed)
    def model(found):
        estimated, report = found
        if report["num_inliers"] < 6:
            return None
        focals, essential = [estimated.camera1.params[0]] * 2, matrix_of(estimated.pose)
        if task in TWO_FOCALS:
            return two_focals(essential, focals)
        k1, k2 = (np.linalg.inv(calibration(focal, middle)) for focal, middle in zip(focals, middles(pair)))
        return k2.T @ essential @ k1
    return lambda: library.estimate_shared_focal_relative_pose(first, second, np.zeros(2), options, {}), model


def colmap_focals(task, pair, seed):
    """Its two-view geometry of cameras without a focal length, and the motion that it makes of it with its guess of them."""
    import pycolmap as library
    options = library.TwoViewGeometryOptions()
    options.ransac.random_seed = seed
    first, second = (side + 0.5 for side in sides(pair))
    cameras = [library.Camera(model="SIMPLE_PINHOLE", width=int(width), height=int(height), params=[focal, width / 2, height / 2],
                              has_prior_focal_length=False)
               for focal, (width, height) in zip(likely_focals(pair), (pair.sizes[:2], pair.sizes[2:]))]
    every = np.repeat(np.arange(len(pair.ratios), dtype=np.uint32)[:, None], 2, axis=1)
    def call():
        geometry = library.estimate_two_view_geometry(cameras[0], first, cameras[1], second, every, options)
        there = library.estimate_two_view_geometry_pose(cameras[0], first, cameras[1], second, geometry)
        return geometry.cam2_from_cam1 if there else None
    def model(pose):
        found = types.SimpleNamespace(R=pose.rotation.matrix(), t=pose.translation)
        return two_focals(matrix_of(found), likely_focals(pair))
    return call, model


Peer = collections.namedtuple("Peer", "estimate module tasks options")
BOTH, TWO_FOCALS, BEST_FIRST = ("essential", "fundamental"), ("two_focals",), "matches in the order of their ratio, PROSAC"
SEEDLESS = "it takes no seed and is random: the seed numbers repetitions"
PEERS = {
    **{name: Peer(functools.partial(poselib, pixels=pixels), "poselib", BOTH, f"{BEST_FIRST}, max_epipolar_error {pixels:g} px, random by its seed")
       for name, pixels in (("poselib", EPSILON_PX), ("poselib_0.5px", 0.5), ("poselib_2px", 2))},
    "degensac": Peer(degensac, "pydegensac", ("fundamental",), f"uniform, px_th {EPSILON_PX:g} px of Sampson's error, check of "
                     "degeneracy, random by its seed; it has no minimum of iterations"),
    "colmap": Peer(colmap, "pycolmap", BOTH, f"estimate_TASK_matrix (LO-RANSAC, uniform), max_error {EPSILON_PX:g} px, random by its seed"),
    "superansac": Peer(superansac, "pysuperansac", BOTH, f"{BEST_FIRST}, inlier_threshold {SUPERANSAC_PX['essential']:g} px (E) and "
                       f"{SUPERANSAC_PX['fundamental']:g} px (F) as in its examples, MAGSAC++ score and the other settings its own; "
                       f"{SEEDLESS}"),
    "magsac": Peer(magsac, "pymagsac", BOTH, f"{BEST_FIRST}, MAGSAC++, sigma_th {EPSILON_PX:g} px: the library's default, where its "
                   f"score ends; {SEEDLESS}"),
    "opencv_accurate": Peer(opencv_accurate, "cv2", BOTH, f"USAC_ACCURATE (uniform), threshold {EPSILON_PX:g} px, E from points in "
                            "coordinates of the cameras; its seed is fixed: ours permutes the matches; it has no minimum of iterations"),
    "poselib_bougnoux": Peer(poselib_focals, "poselib", TWO_FOCALS, f"F, {BEST_FIRST}, max_epipolar_error {EPSILON_PX:g} px; then "
                             "focals_from_fundamental"),
    "poselib_iterative": Peer(poselib_iterative, "poselib", TWO_FOCALS, f"F, {BEST_FIRST}, max_epipolar_error {EPSILON_PX:g} px; then "
                              "focals_from_fundamental_iterative with a prior of 1.2 longer sides and its own weights"),
    "poselib_shared_focal": Peer(poselib_shared_focal, "poselib", ("fundamental", *TWO_FOCALS), "estimate_shared_focal_relative_pose about the "
                                 f"images' middles, {BEST_FIRST}, max_epipolar_error {EPSILON_PX:g} px, random by its seed; F of what it finds"),
    "colmap_guess": Peer(colmap_focals, "pycolmap", TWO_FOCALS, "estimate_two_view_geometry (F or H) with its own options (4 px, at most 10000 iterations); the motion by "
                         "its guess of 1.2 longer sides"),
}


def measure(peer, task, pair, seed):
    """The matrix of norm 1, or the row of two_focals, or None; milliseconds."""
    if len(pair.matches) < FEWEST_POINTS:
        return None, 0.0
    call, read = PEERS[peer].estimate(task, pair, seed)
    start, found = time.process_time(), None
    try:
        found = call()
    except (cv2.error, RuntimeError, ValueError):          # points that a library refuses
        pass
    ms = 1e3 * (time.process_time() - start)
    matrix = None if found is None else read(found)
    if task in TWO_FOCALS:
        return matrix, ms
    if matrix is None or np.shape(matrix) != (3, 3) or not np.isfinite(matrix).all() or not np.any(matrix):
        return None, ms
    return np.asarray(matrix) / np.linalg.norm(matrix), ms


def folders_of(scenes):
    return {os.path.basename(os.path.normpath(existing(folder, "folder of pairs"))): folder for folder in scenes}


def pair_of(folders, scene, name):
    return read_pair(folders.get(scene) or fail(f"{scene}/{name}: no folder {scene} among --scenes"), name)


def pairs_of(arguments, folders, condition):
    pairs = []
    for scene, name in pair_ids(arguments.run, condition)[:arguments.limit]:
        pair = pair_of(folders, scene, name)
        order = np.argsort(pair.ratios, kind="stable")[:np.count_nonzero(pair.ratios <= CONDITIONS[condition])]
        pairs.append((f"{scene}/{name}", select(pair, order)))
    return pairs


def rows_of(peer, task, condition, pairs, seeds):
    for name, pair in pairs:
        for seed in range(1, seeds + 1):
            matrix, ms = measure(peer, task, pair, seed)
            model = "" if matrix is None else " ".join(f"{value:.7g}" for value in matrix.reshape(-1))
            yield [peer, condition, name, str(seed), f"{ms:.3f}", model]


def processor():
    if os.path.exists("/proc/cpuinfo"):
        with open("/proc/cpuinfo") as file:
            for line in file:
                if line.startswith("model name"):
                    return line.split(":", 1)[1].strip()
    return platform.machine()


def comments(arguments, peers):
    versions = [f"{package} {importlib.metadata.version(package)}" for module, package in LIBRARIES.items()
                if module in ("numpy", "h5py", "cv2", *(PEERS[peer].module for peer in peers))]
    command = shlex.join([os.path.relpath(sys.argv[0]), *sys.argv[1:]])
    return [f"# {line}\n" for line in [
        command, f"task: {arguments.task}", f"Python {platform.python_version()}, {', '.join(versions)}", f"{processor()}, one thread",
        f"all rows: at most {ITERATIONS} iterations and at least {FEWEST_ITERATIONS}, confidence {CONFIDENCE:g}",
        *(f"{peer}: {PEERS[peer].options}" for peer in peers)]]


def opened(path, mode, compressed=None):
    """A text file, compressed where it is called .gz."""
    compressed = str(path).endswith(".gz") if compressed is None else compressed
    return gzip.open(path, mode, newline="") if compressed else open(path, mode, newline="")


def read_rows(path):
    """Its comments and its rows."""
    with opened(existing(path, "file"), "rt") as file:
        lines = file.readlines()
    first = [line for line in lines if line.startswith("#")]
    rows = list(csv.reader(lines[len(first):]))
    return first, rows[1:] if rows and rows[0] == COLUMNS else fail(f"{path}: expected the columns {','.join(COLUMNS)}")


def write_rows(path, first, blocks):
    """The file is there whole or not at all."""
    with opened(f"{path}.new", "wt", path.endswith(".gz")) as file:
        file.writelines(first)
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *(row for key in sorted(blocks) for row in blocks[key])])
    os.replace(f"{path}.new", path)


def record(arguments):
    folders, packed = folders_of(arguments.scenes), ".gz" if arguments.output.endswith(".gz") else ""
    part = f"{arguments.output.removesuffix('.gz')}.part{packed}"
    able = [name for name, peer in PEERS.items() if arguments.task in peer.tasks]
    peers = arguments.peers.split(",") if arguments.peers else able
    once = arguments.once.split(",") if arguments.once else []
    for peer in peers + once:
        need(PEERS[peer].module if peer in able else fail(f"no peer '{peer}' of this task; expected some of {','.join(able)}"))
    signal.signal(signal.SIGTERM, signal.SIG_DFL)         # pycolmap's prints a stack
    existing(os.path.dirname(arguments.output) or ".", "folder for --output")
    first, blocks = comments(arguments, peers), collections.defaultdict(list)
    if os.path.exists(part):
        made_by, rows = read_rows(part)
        for row in rows if made_by == first else []:
            blocks[row[0], row[1]].append(row)
    cv2.setNumThreads(1)
    conditions = [name for name in CONDITIONS if name in conditions_of(arguments.run)]
    missing = [(peer, condition) for peer in peers for condition in conditions if (peer, condition) not in blocks]
    pairs = {condition: pairs_of(arguments, folders, condition) for condition in {condition for _, condition in missing}}
    for peer, condition in missing:
        start = time.monotonic()
        rows = list(rows_of(peer, arguments.task, condition, pairs[condition], 1 if peer in once else arguments.seeds))
        blocks[peer, condition] = rows
        write_rows(part, first, blocks)
        print(f"{peer}, {condition}: {len(rows)} runs, {sum(not row[-1] for row in rows)} without an estimate, "
              f"{time.monotonic() - start:.0f} s", flush=True)
    os.replace(part, arguments.output)


def summarize(arguments):
    """Scenes of KITTI count as one."""
    cv2.setNumThreads(1)
    first, rows = read_rows(arguments.summary)
    task = next((line[len("# task: "):].strip() for line in first if line.startswith("# task: ")), None)
    folders, pairs, errors, times = folders_of(arguments.scenes), {}, collections.defaultdict(list), collections.defaultdict(list)
    if task not in BOTH + TWO_FOCALS:
        fail(f"{arguments.summary}: expected a line '# task: {'|'.join(BOTH + TWO_FOCALS)}'")
    for row, condition, name, seed, ms, model in rows:
        scene = name.split("/")[0]
        if (name, condition) not in pairs:
            pair = pair_of(folders, *name.split("/"))
            pairs[name, condition] = select(pair, pair.ratios <= CONDITIONS[condition])
        numbers, pair = np.array(model.split(), float), pairs[name, condition]
        if task in TWO_FOCALS and model:
            pair = types.SimpleNamespace(**vars(pair))
            pair.k1, pair.k2 = (calibration(focal, middle) for focal, middle in zip(numbers[9:], middles(pair)))
        error = max(errors_of_matrix(numbers[:9].reshape(3, 3) if model else None, pair, task))
        errors[row, condition, seed, "kitti" if scene.startswith("kitti_") else scene].append(error)
        times[row, condition].append(float(ms))
    for (row, condition), ms in times.items():
        by_seed, by_scene = collections.defaultdict(list), collections.defaultdict(list)
        for (other, its, seed, scene), values in errors.items():
            if (other, its) == (row, condition):
                by_seed[seed].append(accuracy(values))
                by_scene[scene].append(accuracy(values))
        scores = [np.mean(values) for values in by_seed.values()]
        print(f"{row}, {condition}: mAA@10deg {np.mean(scores):.3f} ({len(scores)} seeds, {min(scores):.3f} to {max(scores):.3f}), "
              f"{np.median(ms):.1f} ms; " + ", ".join(f"{scene} {np.mean(values):.3f}" for scene, values in sorted(by_scene.items())))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", choices=BOTH + TWO_FOCALS)
    parser.add_argument("--run")
    parser.add_argument("--scenes", nargs="+", required=True)
    parser.add_argument("--output")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--peers", help=f"some of {','.join(PEERS)}; without it, all that have the task")
    parser.add_argument("--once", metavar="PEERS", help="those of them that run with seed 1 alone, because they are slow")
    parser.add_argument("--limit", type=int, help="so many pairs of each condition")
    parser.add_argument("--summary", metavar="FILE")
    arguments = parser.parse_args()
    if arguments.seeds < 1:
        parser.error("expected one seed or more")
    if arguments.summary:
        summarize(arguments)
    elif arguments.task and arguments.run and arguments.output:
        record(arguments)
    else:
        parser.error("expected --task, --run and --output, or --summary")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit(130)
