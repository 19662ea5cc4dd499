"""Estimators around networks of other authors: a loop with NeFSAC's filter, CA-RANSAC, MAGSAC++ with the adaptive sampler."""
import os
import sys
import time
import types

import cv2
import numpy as np
import torch

from peer_networks import NETWORKS, checkout_on_path, load_state, log_weights
from peer_pairs import existing, matrix_of, normalized, select

EPSILON_PX = 1.0        # of the loop


def sampson(models, points):
    """Squared Sampson distances, models x points."""
    one = torch.ones(len(points), 1, dtype=points.dtype)
    first, second = torch.cat([points[:, :2], one], 1), torch.cat([points[:, 2:], one], 1)
    products = torch.einsum("ni,nj->nij", second, first).reshape(len(points), 9)
    residuals = models.reshape(-1, 9) @ products.T
    gradient = sum((models[:, i] @ first.T).square() + (models[:, :, i] @ second.T).square() for i in (0, 1))
    return residuals.square() / gradient.clamp_min(1e-30)


def msac(models, points, epsilon):
    models, points = torch.as_tensor(np.asarray(models)).float(), torch.as_tensor(points).float()
    blocks = [(1 - sampson(block, points) / epsilon ** 2).clamp_min(0).sum(1) for block in models.split(256)]
    return torch.cat(blocks).numpy()


def uniform_sets(count, size, points, generator):
    sets = generator.integers(points, size=(count, size))
    while len(again := np.flatnonzero((np.diff(np.sort(sets, 1), axis=1) == 0).any(1))):
        sets[again] = generator.integers(points, size=(len(again), size))
    return sets


def prosac_sets(count, size, points, generator, total=200000.0):
    """Chum and Matas, CVPR 2005: the rows of points that come best first."""
    subset, mean, whole, sets = size, total * np.prod([(size - i) / (points - i) for i in range(size)]), 1.0, []
    for draw in range(1, count + 1):
        while draw > whole and subset < points:
            following = mean * (subset + 1) / (subset + 1 - size)
            whole, mean, subset = whole + np.ceil(following - mean), following, subset + 1
        grown = int(draw <= whole)          # then the newest point is one of the set
        sets.append([*generator.choice(subset - grown, size - grown, replace=False), *[subset - 1] * grown])
    return np.array(sets)


def solve_sets(task, pair, sets):
    """Models of minimal sets: [R | t], or F."""
    if task == "fundamental":
        found = [cv2.findFundamentalMat(pair.matches[s, :2].copy(), pair.matches[s, 2:].copy(), cv2.FM_7POINT)[0] for s in sets]
        return [f for models in found if models is not None for f in models.reshape(-1, 3, 3)]
    import poselib
    points = normalized(pair)
    one = np.ones((sets.shape[1], 1))
    def rays(rows):
        rows = np.hstack([rows, one])
        return rows / np.linalg.norm(rows, axis=1, keepdims=True)
    return [pose for s in sets for pose in poselib.relpose_5pt(rays(points[s, :2]), rays(points[s, 2:]))]


def refine(task, pair, models, epsilon):
    """Levenberg-Marquardt on the truncated loss, by PoseLib."""
    import poselib
    options = {"loss_type": "TRUNCATED", "loss_scale": epsilon, "max_iterations": 25}
    if task == "fundamental":
        return [poselib.refine_fundamental(pair.matches[:, :2], pair.matches[:, 2:], model, options)[0] for model in models]
    camera, points = {"model": "PINHOLE", "width": 2, "height": 2, "params": [1.0, 1.0, 0.0, 0.0]}, normalized(pair)
    return [poselib.refine_relative_pose(points[:, :2], points[:, 2:], model, camera, camera, options)[0] for model in models]


class NefsacLoop:
    """Ten times as many sets as are solved, of which the network's best stay; MSAC, then refinement of the ten best models."""
    def __init__(self, arguments):
        weights = arguments.weights and existing(arguments.weights, "TorchScript network")
        self.network = torch.jit.load(weights, map_location="cpu").eval() if weights else None
        self.sets = {"uniform": uniform_sets, "prosac": prosac_sets}[arguments.source]
        self.task, self.draws = arguments.task, arguments.draws

    def chosen_sets(self, pair, generator):
        size = 5 if self.task == "essential" else 7
        sets = self.sets(self.draws * (10 if self.network else 1), size, len(pair.matches), generator)
        if self.network is None:
            return sets, 0.0
        points = normalized(pair) if self.task == "essential" else pair.matches / np.array(pair.sizes) * 2 - 1
        start = time.process_time()
        with torch.inference_mode():
            scores = self.network(torch.tensor(points[sets]).float()).reshape(-1).numpy()
        return sets[np.argsort(-scores, kind="stable")[:self.draws]], 1e3 * (time.process_time() - start)

    def __call__(self, pair, generator):
        pair = select(pair, np.argsort(pair.ratios, kind="stable"))
        focal = np.mean([pair.k1[0, 0], pair.k1[1, 1], pair.k2[0, 0], pair.k2[1, 1]])
        essential = self.task == "essential"
        points, epsilon = (normalized(pair), EPSILON_PX / focal) if essential else (pair.matches, EPSILON_PX)
        matrices = (lambda models: [matrix_of(m) for m in models]) if essential else (lambda models: models)
        sets, milliseconds = self.chosen_sets(pair, generator)
        models = solve_sets(self.task, pair, sets)
        if not models:
            return None, milliseconds
        scores = msac(matrices(models), points, epsilon)
        best = refine(self.task, pair, [models[i] for i in np.argsort(-scores)[:10]], epsilon)
        return matrices(best)[np.argmax(msac(matrices(best), points, epsilon))], milliseconds


def weighted_refinement(refine_by_poselib):
    """PoseLib as it is released takes no weights, which CA-RANSAC's last refinement gives; its own torch code does the same."""
    from optim.lm import sparse_lm_loop
    def refined(points, models, k1, k2, weights, loss_type, loss_scale):
        if loss_type != "CAUCHY":
            return refine_by_poselib(points, models, k1, k2, weights, loss_type, loss_scale)
        model, point = torch.where(weights > 0)
        sides = [torch.nn.functional.pad(points[point, i:i + 2], (0, 1), value=1.0) for i in (0, 2)]
        turn, shift = sparse_lm_loop(models[:, :3, :3], models[:, :3, 3], *sides, weights[model, point], model, loss_scale,
                                     torch.tensor(0.1).double(), "CAUCHY", 20, 1e-6)
        return torch.cat([turn, shift[..., None]], -1)
    return refined


class ConsensusAdaptive:
    """CA-RANSAC; as it is released it draws in four rounds of 256 sets."""
    def __init__(self, arguments):
        source = os.path.abspath(os.path.join(existing(arguments.checkout, "checkout"), "source"))
        checkout_on_path(source)
        package = types.ModuleType("ransac")       # its __init__ imports a file that the repository lacks
        package.__path__ = [os.path.join(source, "ransac")]
        sys.modules["ransac"] = package
        from models.arch import CA_RANSAC
        from ransac import fundamental_matrix_estimator, refinement, scoring
        refinement.refine_poselib = weighted_refinement(refinement.refine_poselib)
        scoring.check_cheirality_fmat = fundamental_matrix_estimator.cheirality_check     # which it forgets to import
        from ransac.problem_def import EssentialMatrixEstimationProblem, FundamentalMatrixEstimationProblem
        problem = EssentialMatrixEstimationProblem() if arguments.task == "essential" else FundamentalMatrixEstimationProblem()
        start = os.getcwd()
        os.chdir(source)                           # it reads a network by a relative path
        self.network = CA_RANSAC(problem_definition=problem)
        os.chdir(start)
        stub = (str, "pytorch_lightning.callbacks.model_checkpoint.ModelCheckpoint")
        state = load_state(arguments.weights, [stub])["state_dict"]
        self.network.load_state_dict({name.removeprefix("model."): value for name, value in state.items()})
        self.network.eval()
        self.network.n_iterations, self.network.n_minimal_samples = arguments.rounds, 1024 // arguments.rounds
        self.task = arguments.task

    def drawn_again(self, inputs, attempts=10):
        """Its solver raises where none of the first four sets has a model, though the loop around it would draw others."""
        for _ in range(attempts):
            try:
                with torch.no_grad():
                    return self.network(dict(inputs))[-1]["best_models"][0].double().numpy()
            except ValueError as error:
                if "at least one array" not in str(error):
                    raise
        return None

    def __call__(self, pair, generator):
        torch.manual_seed(int(generator.integers(2 ** 31)))
        points = normalized(pair) if self.task == "essential" else pair.matches
        inputs = {"points": points, "sides": pair.ratios[:, None], "K1": pair.k1, "K2": pair.k2}
        start = time.process_time()
        model = self.drawn_again({name: torch.tensor(value).float() for name, value in inputs.items()})
        if model is not None and self.task == "essential":
            model = matrix_of(types.SimpleNamespace(R=model[:, :3], t=model[:, 3]))
        return model, 1e3 * (time.process_time() - start)


class ArsMagsac:
    """MAGSAC++ with the adaptive sampler, by `pymagsac`: thresholds are those of the authors' command and of the weights' name."""
    def __init__(self, arguments):
        self.network = NETWORKS["ars_magsac"](arguments.checkout, arguments.weights) if arguments.weights else None
        self.task, self.draws = arguments.task, arguments.draws
        self.threshold = 2.0 if arguments.task == "essential" else 0.75

    def __call__(self, pair, generator):
        import pymagsac
        start = time.process_time()
        rank = np.argsort(np.argsort(pair.ratios))
        weights = np.exp(log_weights(self.network, pair, self.task)) if self.network else 1 - rank / len(rank)
        milliseconds = 1e3 * (time.process_time() - start)
        best_first = np.argsort(-weights, kind="stable")
        options = dict(probabilities=weights[best_first], sampler=4, sigma_th=self.threshold, conf=0.9999, min_iters=50,
                       max_iters=self.draws)
        matches, sizes = np.ascontiguousarray(pair.matches[best_first]), pair.sizes
        if self.task == "essential":
            return pymagsac.findEssentialMatrix(matches, pair.k1, pair.k2, *sizes, **options)[0], milliseconds
        return pymagsac.findFundamentalMatrix(matches, *sizes, **options)[0], milliseconds


ESTIMATORS = {"nefsac": NefsacLoop, "ca_ransac": ConsensusAdaptive, "ars_magsac": ArsMagsac}
