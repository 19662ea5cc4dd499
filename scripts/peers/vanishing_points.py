#!/usr/bin/env python3
"""CONSAC's official weights (fkluger/consac, revision e0a4f69) on NYU-VP and YUD+, and its metric on our estimates.

Without --evaluate, CONSAC's own evaluation script runs as it is, with its defaults (32 x 32 hypotheses, six instances,
ten EM iterations, threshold .001), on the test split as its own readers give it, on one thread. Its 32 draws of an
instance are made by one call of its batched functions instead of 32 calls (--single: its calls as they are; the same
distribution). OUTPUT/seed_N.csv gets the six estimates of each image in the order in which they count:

    image,rank,x,y,z,dx,dy,dz    (x, y, z): homogeneous pixels of unit length; (dx, dy, dz): unit direction, camera frame

With --evaluate, such files (the first five columns; any length) are measured by CONSAC's functions. `image` is the
number in the name of NYU-VP's files, the stem of YUD+'s. As many estimates count as the image has labelled points, the
first ones by rank; each one that is missing is an error of 90 degrees.

    python3 scripts/peers/vanishing_points.py DATA CONSAC [--set nyu] [--seeds 1 2 3] [--output OUTPUT] [--single]
    python3 scripts/peers/vanishing_points.py DATA CONSAC [--set nyu] --evaluate FILE...

DATA is a checkout of fkluger/nyu_vp (revision 5dadc1c) or fkluger/yud_plus (a18c79c); neither needs its photographs,
and York Urban's camera is given here. Needs numpy, scipy, scikit-learn, matplotlib, torch. None of the three
repositories has a licence: nothing of them is kept here.
"""

import argparse
import collections
import csv
import importlib.util
import os
import pathlib
import runpy
import sys
import time
import types

import numpy as np
import scipy.io
import torch

# York Urban's cameraParameters.mat (Denis, Elder and Estrada, ECCV 2008).
YORK_CAMERA = {"focal": np.array([[6.05317058975369]]), "pixelSize": np.array([[0.00896875]]),
               "pp": np.array([[307.551305282635, 251.454244960136]])}
# From pixels to CONSAC's coordinates, both data sets' images being of 640 x 480.
NORMALISE = np.array([[1 / 320, 0, -1], [0, 1 / 320, -0.75], [0, 0, 1]])
HYPOTHESES = 32
SETS = {"nyu": "NYU", "yud_plus": "YUD+", "yud": "YUD"}
Image = collections.namedtuple("Image", "name labelled")


def stand_in_modules():
    """What the readers import or load and the segments and labels do not need: the detector and the photographs."""
    pylsd, imageio = types.ModuleType("pylsd"), types.ModuleType("imageio")
    pylsd.lsd = types.ModuleType("pylsd.lsd")
    pylsd.lsd.lsd = None
    imageio.v2 = types.SimpleNamespace(imread=lambda path: np.zeros((1, 1, 3), np.uint8))
    sys.modules.update({"pylsd": pylsd, "pylsd.lsd": pylsd.lsd, "imageio": imageio})
    load = scipy.io.loadmat

    def loadmat(path, **options):
        if options.get("variable_names") == ["images"]:
            return {"images": np.broadcast_to(np.uint8(0), (1, 1, 3, 1449))}
        return YORK_CAMERA if os.path.basename(path) == "cameraParameters.mat" else load(path, **options)

    scipy.io.loadmat = loadmat
    if not hasattr(np, "int"):
        np.int = int  # the program is of a time when numpy had it


def import_readers(data, which):
    """CONSAC keeps the data sets as submodules; here their readers come from where the data lie."""
    folder, module = ("nyu_vp", "nyu") if which == "nyu" else ("yud_plus", "yud")
    path = data / f"{module}.py"
    if not path.is_file():
        sys.exit(f"{path}: not found; DATA is a checkout of fkluger/{folder}")
    # The other reader's module is imported by the program, never used.
    for name in ("datasets.nyu_vp.nyu", "datasets.yud_plus.yud"):
        sys.modules[name] = types.ModuleType(name)
        sys.modules[name].NYUVP = sys.modules[name].YUDVP = None
    spec = importlib.util.spec_from_file_location(f"datasets.{folder}.{module}", path)
    sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules[spec.name])


def image_name(dataset, index):
    """Of the index-th image of the split: NYU-VP's number, YUD+'s stem."""
    if hasattr(dataset, "nyuvp"):
        return str(dataset.nyuvp.set_ids[index])
    return dataset.dataset.image_ids[dataset.dataset.set_ids[index]]


def inverse_calibration(dataset):
    """From CONSAC's coordinates to directions in the camera frame."""
    return np.asarray(dataset.Kinv if hasattr(dataset, "nyuvp") else dataset.dataset.K_inv, float)


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


class Draws:
    """sampling.sample_model, asked HYPOTHESES times for each instance, that draws them all at the first time."""

    def __init__(self, sampling):
        self.sampling = sampling
        self.drawn = iter(())

    def __call__(self, data, num_data, inlier_fun, cardinality, probs, model_fun, consistency_fun, device=None):
        draw = next(self.drawn, None)
        if draw is None:
            self.drawn = self.draw(data, num_data, inlier_fun, cardinality, probs, device)
            draw = next(self.drawn)
        return draw

    def draw(self, data, num_data, inlier_fun, cardinality, probs, device):
        drawn = self.sampling.sample_models_parallel(
            data, num_data, inlier_fun, cardinality, HYPOTHESES, probs.view(1, 1, 1, -1).expand(1, HYPOTHESES, 1, -1),
            self.sampling.vp_from_lines_batched, self.sampling.vp_consistency_measure_angle_batched, device)
        return zip(*(part[0, :, 0] for part in drawn))


class Recorder:
    """Stands between the program and its evaluation, which it calls twice an image: before EM and after it."""

    def __init__(self, evaluation, em):
        self.evaluate = {name: getattr(evaluation, name) for name in ("single_eval_nyu", "single_eval_yud")}
        self.fit = em.em_for_vp
        self.errors = ([], [])
        self.rows = []
        self.calls = 0
        for name in self.evaluate:
            setattr(evaluation, name, lambda *inputs, name=name, **options: self.measured(name, inputs, options))
        em.em_for_vp = self.fitted

    def fitted(self, *inputs, **options):
        result = self.fit(*inputs, **options)
        self.refined = result[0].detach().numpy()[0]
        return result

    def measured(self, name, inputs, options):
        result = self.evaluate[name](*inputs, **options)
        after = self.calls % 2
        self.errors[after].extend(result[0])
        if after:
            program = sys._getframe(2).f_globals  # the measured estimates are cut; these are all, in their order
            self.keep(program["dataset"], program["idx"], self.refined[np.array(program["refined_model_sort"], int)])
        self.calls += 1
        return result

    def keep(self, dataset, index, models):
        pixels = unit(models.astype(float) @ np.linalg.inv(NORMALISE).T)
        directions = unit(models.astype(float) @ inverse_calibration(dataset).T)
        for rank, row in enumerate(np.hstack([pixels, directions])):
            self.rows.append([image_name(dataset, index), rank, *(f"{value:.9g}" for value in row)])


def areas_under_curve(errors):
    """Per cent, up to 5 and 10 degrees; CONSAC's function raises where no error is that small."""
    from util import auc

    return [100 * auc.calc_auc(np.array(errors), cutoff)[0] if min(errors) < cutoff else 0.0 for cutoff in (5, 10)]


def write_estimates(path, rows):
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow("image rank x y z dx dy dz".split())
        writer.writerows(rows)


def run(options, data):
    from util import em_algorithm, evaluation, sampling

    if not options.single:
        sampling.sample_model = Draws(sampling)
    torch.autograd.set_detect_anomaly = lambda mode: None  # a stack trace for each operation of EM; nothing is derived
    loader = torch.utils.data.DataLoader  # without its six processes
    torch.utils.data.DataLoader = lambda dataset, **given: loader(dataset, **{**given, "num_workers": 0})
    areas = []
    for seed in options.seeds:
        recorder = Recorder(evaluation, em_algorithm)
        sys.argv = ["evaluate_vp.py", "--dataset", SETS[options.set], "--dataset_path", str(data / "data"), "--cpu",
                    "--hyps", str(HYPOTHESES), "--seed", str(seed)]
        start = time.process_time()
        runpy.run_path("evaluate_vp.py", run_name="__main__")
        seconds = (time.process_time() - start) / (recorder.calls / 2)
        evaluation.single_eval_nyu, evaluation.single_eval_yud = recorder.evaluate.values()
        em_algorithm.em_for_vp = recorder.fit
        if options.output:
            write_estimates(options.output / f"seed_{seed}.csv", recorder.rows)
        areas.append([areas_under_curve(errors) for errors in recorder.errors])
        print(f"seed {seed}: before EM AUC@5 {areas[-1][0][0]:.3f} AUC@10 {areas[-1][0][1]:.3f}, after it "
              f"AUC@5 {areas[-1][1][0]:.3f} AUC@10 {areas[-1][1][1]:.3f}; {seconds:.2f} s of processor time an image",
              flush=True)
    for when, values in zip(("before EM", "after EM"), np.array(areas).transpose(1, 2, 0)):
        print("{}: AUC@5 {:.2f} ± {:.2f}, AUC@10 {:.2f} ± {:.2f}".format(
            when, *(statistic for value in values for statistic in (value.mean(), value.std()))))


def labelled_images(options, data):
    """The data set of CONSAC's class, and the labelled vanishing points of each image, in CONSAC's coordinates."""
    from datasets.vanishing_points import nyu, yud

    dataset = (nyu.NYUVPDataset(str(data / "data"), None, 8, split="test") if options.set == "nyu" else
               yud.YUDVPDataset(str(data / "data"), None, 8 if options.set == "yud_plus" else 3, split="test",
                                yudplus=options.set == "yud_plus"))
    images = []
    for index in range(len(dataset)):
        _, points, _, count, _ = dataset[index]
        images.append(Image(image_name(dataset, index), np.matrix(points[:count])))
    return dataset, images


def read_estimates(path, names):
    """{image: estimates in the order of their ranks, in CONSAC's coordinates, n x 3}"""
    found = collections.defaultdict(list)
    with open(path, newline="") as file:
        for number, row in enumerate(csv.DictReader(file), 2):
            try:
                rank, point = int(row["rank"]), np.array([float(row[axis]) for axis in "xyz"])
            except (KeyError, TypeError, ValueError):
                sys.exit(f"{path}:{number}: expected the columns image,rank,x,y,z")
            if not np.all(np.isfinite(point)) or not np.any(point):
                sys.exit(f"{path}:{number}: expected a homogeneous point, got {point}")
            if row["image"] not in names:
                sys.exit(f"{path}:{number}: no image {row['image']} in the test split")
            found[row["image"]].append((rank, unit(NORMALISE @ point)))
    return {name: np.array([point for _, point in sorted(pairs, key=lambda pair: pair[0])])
            for name, pairs in found.items()}


def evaluate(options, data):
    from util import evaluation

    dataset, images = labelled_images(options, data)
    print("| estimates | AUC@5 | AUC@10 | images | labelled | missing |\n|---|---|---|---|---|---|")
    for path in options.evaluate:
        estimates = read_estimates(path, {image.name for image in images})
        errors, missing = [], 0
        for name, labelled in images:
            points = estimates.get(name, np.zeros((0, 3)))[: len(labelled)]
            missing += len(labelled) - len(points)
            errors += (evaluation.single_eval_nyu(labelled, points)[0] if options.set == "nyu" else
                       evaluation.single_eval_yud(dataset.dataset.K_inv, labelled, points)[0])
        areas = areas_under_curve(errors)
        print(f"| {path} | {areas[0]:.4f} | {areas[1]:.4f} | {len(images)} | {len(errors)} | {missing} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=pathlib.Path)
    parser.add_argument("consac", type=pathlib.Path)
    parser.add_argument("--set", choices=list(SETS), default="nyu")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3, 4, 5])
    parser.add_argument("--output", type=pathlib.Path)
    parser.add_argument("--single", action="store_true", help="its draws one by one")
    parser.add_argument("--evaluate", type=pathlib.Path, nargs="+", metavar="FILE", help="estimates to measure")
    options = parser.parse_args()
    for path in (options.consac / "evaluate_vp.py", *(options.evaluate or ())):
        if not path.is_file():
            sys.exit(f"{path}: not found")
    data = options.data.resolve()
    options.output = options.output and options.output.resolve()
    options.evaluate = options.evaluate and [path.resolve() for path in options.evaluate]
    os.chdir(options.consac)
    sys.path.insert(0, os.getcwd())
    torch.set_num_threads(1)
    stand_in_modules()
    import_readers(data, options.set)
    if options.evaluate:
        evaluate(options, data)
    else:
        run(options, data)


if __name__ == "__main__":
    main()
