"""kornia's RANSAC with diffsac behind it: `from diffsac.kornia import RANSAC`. Tensors in, tensors of their kind and place out."""

import importlib
from typing import Any, Optional, Tuple

import diffsac

_FUNCTIONS = {kind: kind.split("_")[0] for kind in ("homography", "essential", "fundamental", "fundamental_7pt", "fundamental_8pt")}


class RANSAC:
    """Of kornia.geometry.ransac.RANSAC's arguments model_type, inl_th, batch_size * max_iter and seed are read. options: ours
    (size1, size2, guidance). `weights` of a call are scores from 0 to 1, higher is better: kornia does not read them."""

    def __init__(
        self, model_type: str = "homography", inl_th: Optional[float] = None, *_: Any, seed: Optional[int] = None, **options: Any
    ) -> None:
        if model_type not in _FUNCTIONS:
            raise NotImplementedError(f"model_type: expected one of {', '.join(_FUNCTIONS)}, got {model_type}")
        unread = ("batch_size", "max_iter", "confidence", "max_lo_iters", "score_type", "prosac_sampling", "local_optimization")
        self.model_type = model_type
        self.options = {key: value for key, value in options.items() if key not in unread}
        self.options.update(seed=seed or 0, **({} if inl_th is None else {"max_residual": inl_th}))

    def __call__(self, kp1: Any, kp2: Any, weights: Optional[Any] = None) -> Tuple[Any, Any]:
        """kp1, kp2: N × 2, of "essential" in coordinates of the camera. (model, inliers): 3 × 3, zeros without one, and N of bool."""
        torch = importlib.import_module("torch")
        arrays = [None if one is None else one.detach().cpu().double().numpy() for one in (kp1, kp2, weights)]
        cameras = [[[1.0, 0, 0], [0, 1, 0], [0, 0, 1]]] * 2 if self.model_type == "essential" else []
        estimate = getattr(diffsac, "estimate_" + _FUNCTIONS[self.model_type])(*arrays[:2], *cameras, scores=arrays[2], **self.options)
        model, inliers = (torch.from_numpy(value.copy()).to(kp1.device) for value in (estimate.model, estimate.inliers))
        return model.to(kp1.dtype), inliers

    forward = __call__
