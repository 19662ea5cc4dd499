"""What the drop-ins share: other libraries' cameras, thresholds and budgets as ours (docs/drop_ins.md)."""

from typing import Any, Dict, Optional, Sequence, Tuple

import numpy as np

from ._results import Floats

_PARAMETERS = {"SIMPLE_PINHOLE": 3, "PINHOLE": 4, "SIMPLE_RADIAL": 4, "RADIAL": 5, "OPENCV": 8}
OUR_BUDGET = 1000  # Minimal samples, unless a caller asks for fewer: others' defaults go up to 100000.


def points_of(array: Any, dimension: int = 2) -> Floats:
    """N × dimension of N × dimension, N × 1 × dimension or 1 × N × dimension."""
    points = np.asarray(array, np.float64)
    if points.shape[-1:] != (dimension,) or points.ndim not in (2, 3) or (points.ndim == 3 and 1 not in points.shape[:2]):
        raise ValueError(f"points: expected N x {dimension} or N x 1 x {dimension}, got shape {points.shape}")
    return points.reshape(-1, dimension)


def budget_of(iterations: Optional[float]) -> Dict[str, Any]:
    return {} if iterations is None or iterations >= OUR_BUDGET else {"max_iterations": max(1, int(iterations))}


def calibration_of(model: str, params: Sequence[float]) -> Tuple[Floats, Tuple[float, float, float, float]]:
    """K, and k1 k2 p1 p2 of the lens, of a camera as COLMAP, PoseLib and hloc name it."""
    if model not in _PARAMETERS:
        raise ValueError(f"camera: expected {', '.join(_PARAMETERS)}, got {model}")
    p = [float(value) for value in params]
    if len(p) != _PARAMETERS[model]:
        raise ValueError(f"camera: {model} has {_PARAMETERS[model]} parameters, got {len(p)}")
    fx, fy, cx, cy, *lens = p if model in ("PINHOLE", "OPENCV") else [p[0], *p]
    k1, k2, p1, p2 = lens + [0.0] * (4 - len(lens))
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]]), (k1, k2, p1, p2)


def straightened(points: Floats, K: Floats, lens: Tuple[float, float, float, float]) -> Floats:
    """Where the points were without the lens: fixed-point iterations, as OpenCV's undistortPoints does."""
    k1, k2, p1, p2 = lens
    if not any(lens):
        return points
    seen = (points - K[:2, 2]) / K[[0, 1], [0, 1]]
    x = seen
    for _ in range(50):
        r2, xy = (x**2).sum(1, keepdims=True), x.prod(1, keepdims=True)
        x = (seen - 2 * xy * [p1, p2] - (r2 + 2 * x**2) * [p2, p1]) / (1 + r2 * (k1 + k2 * r2))
    return x * K[[0, 1], [0, 1]] + K[:2, 2]


def camera_points(points: Any, camera: Any) -> Tuple[Floats, Floats]:
    """Points without the lens, and K. camera: pycolmap's or PoseLib's, or a dictionary of such a one's model and params."""
    if hasattr(camera, "cam_from_img"):
        K = np.array(camera.calibration_matrix())
        rays = np.asarray(camera.cam_from_img(points_of(points)), np.float64)  # NaN where no such camera could see a point.
        return rays.reshape(-1, 2) @ K[:2, :2].T + K[:2, 2], K
    if not isinstance(camera, dict):
        name = camera.model_name
        camera = {"model": name() if callable(name) else name, "params": camera.params}
    K, lens = calibration_of(camera["model"], camera["params"])
    return straightened(points_of(points), K, lens), K
