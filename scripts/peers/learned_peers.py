#!/usr/bin/env python3
"""Learned estimators with their authors' weights on the pairs of a run of diffsac_eval (docs/peers.md). Not part of the build:
needs torch, numpy, h5py and opencv of Python, poselib for `solve`, pymagsac for its ARS-MAGSAC, numba for CA-RANSAC. Each peer's
code and weights are those of a checkout that is given; nothing of them is part of this repository.

  learned_peers.py order --peer ars_magsac --checkout ARS --weights W.net --task essential --run RUN --scenes SCENE...
                         --images S=DIR... --output OUT
      writes OUT/{all,ratio}/SCENE: the same matches, the ratios handed out again in the order of the network's weights; with
      --weights-as-ratio minus the log weights instead, and OUT/network.safetensors, an NG-RANSAC network that says just these
  learned_peers.py solve --peer nefsac|ca_ransac|ars_magsac ... --output OUT.csv
      runs the peer's own estimator, or a loop with its filter
  learned_peers.py table --reference SOURCES NAME=SOURCES...    mAA@10 and differences with 95 % intervals; SOURCES are RUN/ROW or
      OUT.csv, several with commas between them: seeds, and runs of one regime each

RUN is a folder that diffsac_eval wrote, whose problems.csv says which pairs; SCENE a folder of pairs that it read.
"""
import os

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[threads] = "1"
import argparse
import csv
import time

import cv2
import numpy as np
import torch

from peer_estimators import ESTIMATORS
from peer_networks import NETWORKS, log_weights, ratios_by, weights_as_ratios, write_identity_network
from peer_pairs import affine_of_pair, errors_of_matrix, existing, fail, pair_ids, read_pair, read_problems, select, write_pair_files

REGIMES = {"all": ("all matches", 1.0), "ratio": ("ratio 0.85", 0.85)}


def pairs_of(arguments, regime):
    """(folder, scene, name, pair) of each pair of the run, filtered, with sizes and angles where images are given."""
    condition, max_ratio = REGIMES[regime]
    folders = {os.path.basename(os.path.normpath(f)): f for f in arguments.scenes}
    images = dict(item.split("=", 1) for item in arguments.images)
    for scene, name in pair_ids(arguments.run, condition)[:arguments.limit]:
        folder = folders.get(scene) or fail(f"{scene}/{name}: no folder {scene} among --scenes")
        pair = read_pair(existing(folder, "folder"), name)
        if arguments.peer in NETWORKS and arguments.weights:
            key = next((k for k in images if scene.startswith(k)), None) or fail(f"{scene}: no images (--images {scene}=FOLDER)")
            pair.affine = affine_of_pair(arguments, folder, existing(images[key], "folder of images"), name, pair)
        yield folder, scene, name, select(pair, pair.ratios <= max_ratio)


def loaded(build, arguments, *others):
    """What `build` makes of a checkout and weights, which may not belong together."""
    try:
        return build(*others)
    except (ImportError, KeyError, RuntimeError) as error:
        fail(f"{arguments.peer} cannot be loaded from {arguments.checkout} and {arguments.weights}: {str(error).splitlines()[0]}")


def order(arguments):
    network = loaded(NETWORKS[arguments.peer], arguments, arguments.checkout, arguments.weights)
    ratios_from = weights_as_ratios if arguments.weights_as_ratio else ratios_by
    for regime in REGIMES:
        scenes, milliseconds = {}, []
        for folder, scene, name, pair in pairs_of(arguments, regime):
            start = time.process_time()
            weights = log_weights(network, pair, arguments.task)
            milliseconds.append(1e3 * (time.process_time() - start))
            ratios, matches = scenes.setdefault(folder, ({}, {}))
            ratios[name], matches[name] = ratios_from(weights, pair), pair.matches
        for folder, files in scenes.items():
            write_pair_files(folder, os.path.join(arguments.output, regime, os.path.basename(os.path.normpath(folder))), *files)
        median, most = np.median(milliseconds), max(milliseconds)
        print(f"{regime}: {len(milliseconds)} pairs, network {median:.1f} ms (median), at most {most:.0f}")
    if arguments.weights_as_ratio:
        write_identity_network(os.path.join(arguments.output, "network.safetensors"), arguments.task)


def solve(arguments):
    estimate = loaded(ESTIMATORS[arguments.peer], arguments, arguments)
    with open(arguments.output, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["id", "condition", "method", "rotation_deg", "translation_deg", "ms_network", "ms_total"])
        for regime, (condition, _) in REGIMES.items():
            times = []
            for i, (_, scene, name, pair) in enumerate(pairs_of(arguments, regime)):
                start = time.process_time()
                model, network = estimate(pair, np.random.default_rng([arguments.seed, i]))
                times.append((network, 1e3 * (time.process_time() - start)))
                errors = errors_of_matrix(model, pair, arguments.task)
                writer.writerow([f"{scene}/{name}", condition, arguments.peer, *errors, *times[-1]])
            print(f"{regime}: {len(times)} pairs, medians: network %.1f ms, all %.1f ms" % tuple(np.median(times, 0)), flush=True)


def errors_of_row(sources, condition):
    """By the pair's id the larger of both errors in degrees, one of each source that has the condition: of each seed."""
    errors = {}
    for source in sources.split(","):
        run, _, method = (source, "", "") if source.endswith(".csv") else source.rpartition("/")
        for row in read_problems(run):
            if row["condition"] == condition and method in ("", row["method"]):
                errors.setdefault(row["id"], []).append(max(float(row["rotation_deg"] or 180), float(row["translation_deg"] or 90)))
    return errors or fail(f"{sources}: no problems of condition '{condition}'")


def scene_of(problem):
    scene = problem.split("/")[0]
    return "kitti" if scene.startswith("kitti") else scene


def mean_accuracy(errors, groups):
    return np.mean([(errors[group][..., None] <= np.arange(1, 11)).mean() for group in groups])


def compared(reference, row, without):
    """The row's accuracy, and the difference with its 95 % interval: pairs drawn again within their scene, with all their seeds."""
    ids = [i for i in reference if i in row and scene_of(i) not in without]
    groups = [np.array([k for k, i in enumerate(ids) if scene_of(i) == s]) for s in dict.fromkeys(map(scene_of, ids))]
    mine, theirs = np.array([row[i] for i in ids]), np.array([reference[i] for i in ids])
    generator = np.random.default_rng(0)
    rounds = [[generator.choice(group, len(group)) for group in groups] for _ in range(1000)]
    low, high = np.percentile([mean_accuracy(mine, r) - mean_accuracy(theirs, r) for r in rounds], [2.5, 97.5])
    accuracy = mean_accuracy(mine, groups)
    return f"{accuracy:.3f}", f"{accuracy - mean_accuracy(theirs, groups):+.3f} [{low:+.3f}, {high:+.3f}]", len(ids)


def table(arguments):
    print("| row | pairs | " + " | ".join(REGIMES) + " | minus the reference, 95 % interval |\n|---|---|---|---|---|")
    for item in arguments.rows:
        name, separator, sources = item.partition("=")
        if not separator:
            fail(f"{item}: expected NAME=SOURCE,... with RUN/ROW or FILE.csv as sources")
        results = [compared(*(errors_of_row(s, condition) for s in (arguments.reference, sources)), arguments.without)
                   for condition, _ in REGIMES.values()]
        accuracies, differences, counts = zip(*results)
        print(f"| {name} | {max(counts)} | {' | '.join(accuracies)} | {'; '.join(differences)} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    for name in ("order", "solve"):
        command = commands.add_parser(name)
        command.add_argument("--peer", required=True, choices=sorted(NETWORKS if name == "order" else ESTIMATORS))
        command.add_argument("--checkout", help="of the peer's repository")
        command.add_argument("--weights", help="the authors' file; without it, where a peer has a loop of its own, that loop alone")
        command.add_argument("--task", required=True, choices=["essential", "fundamental"])
        command.add_argument("--run", required=True)
        command.add_argument("--scenes", required=True, nargs="+")
        command.add_argument("--images", nargs="*", default=[], metavar="SCENE=FOLDER", help="SCENE may be the beginning of names")
        command.add_argument("--cache", help="HDF5 file that keeps sizes and angles of keypoints between calls")
        command.add_argument("--limit", type=int, help="at most so many pairs")
        command.add_argument("--weights-as-ratio", action="store_true")
        command.add_argument("--source", default="uniform", choices=["uniform", "prosac"], help="of NeFSAC's sets")
        command.add_argument("--draws", type=int, default=1000)
        command.add_argument("--rounds", type=int, default=4, help="of CA-RANSAC, which share 1024 sets")
        command.add_argument("--seed", type=int, default=1)
        command.add_argument("--output", required=True, help="order: a folder; solve: a CSV file")
    command = commands.add_parser("table")
    command.add_argument("--reference", required=True)
    command.add_argument("--without", action="append", default=[], metavar="SCENE", help="that a peer was trained on")
    command.add_argument("rows", nargs="+", metavar="NAME=ROW")
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    cv2.setNumThreads(1)
    {"order": order, "solve": solve, "table": table}[arguments.command](arguments)


if __name__ == "__main__":
    main()
