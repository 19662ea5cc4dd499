"""PoseLib's robust estimators with diffsac behind them: `import diffsac.poselib as poselib`.

Calls written for 2.0.5, `(..., ransac_opt, bundle_opt, initial)`, and for 3.0, `(..., opt, initial)`, run. Of the options
max_epipolar_error or max_reproj_error, max_error, max_iterations and seed are read, none of how PoseLib searches and refines, nor an
initial model. `scores`, `snn_ratio`, `size1`, `size2` and `guidance` go by name. What is not here is PoseLib's, where it is installed;
of a function that is, a warning says so.
"""

import importlib
import warnings
from types import SimpleNamespace
from typing import Any, Dict, Optional, Tuple

import numpy as np

import diffsac

from ._results import Estimate, Floats, Pose
from ._seams import budget_of, camera_points, points_of

Info = Dict[str, Any]


def __getattr__(name: str) -> Any:
    if name.startswith("__"):
        raise AttributeError(name)
    try:
        theirs = getattr(importlib.import_module("poselib"), name)
    except ImportError:
        raise AttributeError(f"diffsac.poselib has no {name} of its own, and PoseLib is not installed") from None
    if callable(theirs) and not isinstance(theirs, type):
        warnings.warn(f"diffsac.poselib.{name} is PoseLib's own: diffsac has no such function", stacklevel=2)
    return theirs


def estimate_relative_pose(points2D_1: Any, points2D_2: Any, camera1: Any, camera2: Any, *args: Any, **kwargs: Any) -> Tuple[Any, Info]:
    """(pose, info): of the second camera seen from the first, |t| = 1."""
    (x1, K1), (x2, K2) = camera_points(points2D_1, camera1), camera_points(points2D_2, camera2)
    estimate = diffsac.estimate_essential(x1, x2, K1, K2, **_options("max_epipolar_error", args, kwargs))
    return _camera_pose(estimate.pose), _info(estimate)


def estimate_fundamental(points2D_1: Any, points2D_2: Any, *args: Any, **kwargs: Any) -> Tuple[Floats, Info]:
    """(F, info)."""
    options = _options("max_epipolar_error", args, kwargs)
    estimate = diffsac.estimate_fundamental(points_of(points2D_1), points_of(points2D_2), **options)
    return estimate.model, _info(estimate)


def estimate_homography(points2D_1: Any, points2D_2: Any, *args: Any, **kwargs: Any) -> Tuple[Floats, Info]:
    """(H, info)."""
    options = _options("max_reproj_error", args, kwargs)
    estimate = diffsac.estimate_homography(points_of(points2D_1), points_of(points2D_2), **options)
    return estimate.model, _info(estimate)


def estimate_absolute_pose(points2D: Any, points3D: Any, camera: Any, *args: Any, **kwargs: Any) -> Tuple[Any, Info]:
    """(pose, info): world-to-camera."""
    x, K = camera_points(points2D, camera)
    estimate = diffsac.estimate_absolute_pose(points_of(points3D, 3), x, K, **_options("max_reproj_error", args, kwargs))
    return _camera_pose(estimate.pose), _info(estimate)


def _options(threshold: str, args: Tuple[Any, ...], kwargs: Dict[str, Any]) -> Dict[str, Any]:
    """Ours, of ransac_opt or opt, by place or by name."""
    given = dict(kwargs)
    opt = args[0] if args else given.pop("ransac_opt", given.pop("opt", {}))
    for unread in ("bundle_opt", "initial_pose", "initial_F", "initial_H"):
        given.pop(unread, None)
    opt = {**opt.get("ransac", {}), **opt}
    most = opt.get("max_error", opt.get(threshold))
    return {**budget_of(opt.get("max_iterations")), **({"max_residual": most} if most else {}), "seed": opt.get("seed", 0), **given}


def _camera_pose(found: Optional[Pose]) -> Any:
    """PoseLib's own kind, where it is installed; the identity without a pose."""
    pose = found or Pose(np.eye(3), np.zeros(3))
    try:
        made = importlib.import_module("poselib").CameraPose()
    except ImportError:
        made = SimpleNamespace(Rt=np.column_stack([pose.rotation, pose.translation]))
    made.R, made.t = pose.rotation, pose.translation
    return made


def _info(estimate: Estimate) -> Info:
    ratio = estimate.num_inliers / max(1, len(estimate.inliers))
    info = {"inliers": estimate.inliers.tolist(), "num_inliers": estimate.num_inliers, "inlier_ratio": ratio}
    info.update(iterations=estimate.stats.iterations, refinements=estimate.stats.hypotheses, model_score=estimate.diagnostics.log10_nfa)
    return {**info, "estimate": estimate}
