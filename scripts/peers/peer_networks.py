"""Networks of other authors that weigh matches, loaded from checkouts of their repositories."""
import sys

import numpy as np
import torch

from import_ng_ransac import RATIO_MEAN, RATIO_SPREAD, write_safetensors
from peer_pairs import existing, normalized

LOG_RANGE = 20.0        # log weights from -LOG_RANGE to 0 are told apart


def load_state(path, allowed=()):
    with torch.serialization.safe_globals(list(allowed)):
        return torch.load(existing(path, "file of weights"), map_location="cpu", weights_only=True)


def checkout_on_path(path):
    sys.path.insert(0, existing(path, "checkout"))


def ars_magsac_network(checkout, weights):
    checkout_on_path(checkout)
    from networks.clnet import CLNet
    from networks.resnet import ResNet
    state = load_state(weights)
    network = ResNet(12) if "0s0.weight" in state else CLNet()
    network.load_state_dict(state)
    return network.eval()


def differentiable_ransac_network(checkout, weights):
    checkout_on_path(checkout)
    from model_cl import CLNet
    network = CLNet()
    network.load_state_dict(load_state(weights))
    return lambda x: network.eval()(x, prob_type=2)


NETWORKS = {"ars_magsac": ars_magsac_network, "differentiable_ransac": differentiable_ransac_network}


def log_weights(network, pair, task):
    points = normalized(pair)
    if task == "fundamental":
        width1, height1, width2, height2 = pair.sizes
        points = (pair.matches - np.array(pair.sizes) / 2) / np.repeat([max(width1, height1), max(width2, height2)], 2)
    inputs = torch.tensor(np.hstack([points, pair.ratios[:, None], pair.affine]).T[None, :, :, None]).float()
    with torch.inference_mode():
        return network(inputs).reshape(-1).double().numpy()


def ratios_by(log_weight, pair):
    """The pair's ratios, the best given to the match of greatest weight: what reads them finds ratios as they usually are."""
    handed_out = np.empty(len(pair.ratios))
    handed_out[np.argsort(-log_weight, kind="stable")] = np.sort(pair.ratios)
    return handed_out


def weights_as_ratios(log_weight, pair):
    return np.clip((log_weight.max() - log_weight) / LOG_RANGE, 0, 1)


def write_identity_network(path, task):
    """Weights of an `ng_ransac` network of width 4 with one block that does nothing: log weight = -LOG_RANGE * ratio."""
    width = 4
    weights = {"input.weight": np.zeros((width, 5)), "input.bias": np.zeros(width), "output.weight": np.zeros((1, width)),
               "output.bias": np.zeros(1)}
    weights["input.weight"][0, 4], weights["input.bias"][0], weights["output.weight"][0, 0] = RATIO_SPREAD, RATIO_MEAN, -LOG_RANGE
    for layer in ("first", "second"):
        weights |= {f"block0.{layer}.weight": np.zeros((width, width)), f"block0.{layer}.bias": np.zeros(width),
                    f"block0.{layer}_norm.gain": np.zeros(width), f"block0.{layer}_norm.shift": np.zeros(width)}
    tensors = {f"network.{name}": value for name, value in weights.items()}
    write_safetensors(path, tensors, {"method": "ng_ransac", "task": task, "source": "identity"})
