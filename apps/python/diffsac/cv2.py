"""OpenCV's robust estimators with diffsac behind them, for a program that is written for cv2: `import diffsac.cv2 as cv2`.

findEssentialMat, findFundamentalMat, findHomography and solvePnPRansac take what cv2's take, and `scores`, `ratio`, `size1`,
`size2`, `use_network` and `seed` by name; everything else is cv2's own. Fits without outliers (method 0 of findHomography, 7 and
8 points) are cv2's too. Of `method` and confidence nothing else is read; a threshold is `max_residual_px`.
"""

import importlib
import numbers
from typing import Any, Dict, Optional, Tuple

import numpy as np

import diffsac

from ._results import Estimate
from ._seams import budget_of, points_of

_cv2: Any = importlib.import_module("cv2")
Found = Tuple[Optional[Any], Any]


def __getattr__(name: str) -> Any:
    return getattr(_cv2, name)


def _found(estimate: Estimate, scaled: bool = False) -> Found:
    corner = estimate.model[2, 2] if scaled and abs(estimate.model[2, 2]) > 1e-12 else 1.0
    return (estimate.model / corner if estimate.ok else None), estimate.inliers.astype(np.uint8)[:, None]


def _essential_arguments(given: Tuple[Any, ...], named: Dict[str, Any]) -> Dict[str, Any]:
    """By the names of the overload that is meant."""
    after = ("method", "prob", "threshold", "maxIters", "mask")
    if "cameraMatrix1" in named or (len(given) > 2 and not isinstance(given[1], numbers.Number) and np.ndim(given[0]) == 2):
        names: Tuple[str, ...] = ("cameraMatrix1", "distCoeffs1", "cameraMatrix2", "distCoeffs2", "method", "prob", "threshold", "mask")
    elif "cameraMatrix" in named or (given and np.ndim(given[0]) == 2):
        names = ("cameraMatrix",) + after
    else:
        names = ("focal", "pp") + after
    return {**dict(zip(names, given)), **named}


def findEssentialMat(points1: Any, points2: Any, *args: Any, **kwargs: Any) -> Found:
    """(E, mask), all three ways that cv2 takes cameras. E is None where there is none."""
    given = _essential_arguments(args, kwargs)
    x1, x2 = points_of(points1), points_of(points2)
    focal, (cx, cy) = given.pop("focal", 1.0), given.pop("pp", (0.0, 0.0))
    K1 = given.pop("cameraMatrix", np.array([[focal, 0, cx], [0, focal, cy], [0, 0, 1.0]]))
    K1, K2 = given.pop("cameraMatrix1", K1), given.pop("cameraMatrix2", K1)
    x1, x2 = (_straight(x, K, given.pop(name, None)) for x, K, name in ((x1, K1, "distCoeffs1"), (x2, K2, "distCoeffs2")))
    options = _options(given, "threshold", ("method", "prob", "mask"))
    return _found(diffsac.estimate_essential(x1, x2, K1, K2, **options))


def findFundamentalMat(points1: Any, points2: Any, *args: Any, **kwargs: Any) -> Found:
    """(F, mask), F[2, 2] = 1 where it is not 0."""
    with_budget = len(args) > 3 and isinstance(args[3], numbers.Number)
    names = ("method", "ransacReprojThreshold", "confidence") + (("maxIters", "mask") if with_budget else ("mask",))
    given = {**dict(zip(names, args)), **kwargs}
    if given.get("method", _cv2.FM_RANSAC) in (_cv2.FM_7POINT, _cv2.FM_8POINT):
        return _cv2.findFundamentalMat(points1, points2, *args, **kwargs)  # type: ignore[no-any-return]
    options = _options(given, "ransacReprojThreshold", ("method", "confidence", "mask"))
    return _found(diffsac.estimate_fundamental(points_of(points1), points_of(points2), **options), scaled=True)


def findHomography(srcPoints: Any, dstPoints: Any, *args: Any, **kwargs: Any) -> Found:
    """(H, mask), H[2, 2] = 1 where it is not 0."""
    given = {**dict(zip(("method", "ransacReprojThreshold", "mask", "maxIters", "confidence"), args)), **kwargs}
    if given.get("method", 0) == 0:
        return _cv2.findHomography(srcPoints, dstPoints, *args, **kwargs)  # type: ignore[no-any-return]
    options = _options(given, "ransacReprojThreshold", ("method", "confidence", "mask"))
    return _found(diffsac.estimate_homography(points_of(srcPoints), points_of(dstPoints), **options), scaled=True)


def solvePnPRansac(objectPoints: Any, imagePoints: Any, cameraMatrix: Any, distCoeffs: Any, *args: Any, **kwargs: Any) -> Any:
    """(found, rvec, tvec, inliers). A guess is not needed and not read."""
    names = ("rvec", "tvec", "useExtrinsicGuess", "iterationsCount", "reprojectionError", "confidence", "inliers", "flags")
    given = {**dict(zip(names, args)), **kwargs}
    given["maxIters"] = given.pop("iterationsCount", None)
    options = _options(given, "reprojectionError", ("rvec", "tvec", "useExtrinsicGuess", "confidence", "inliers", "flags"))
    x = _straight(points_of(imagePoints), cameraMatrix, distCoeffs)
    estimate = diffsac.estimate_absolute_pose(points_of(objectPoints, 3), x, np.asarray(cameraMatrix, float), **options)
    rvec = _cv2.Rodrigues(estimate.pose.rotation)[0]
    inliers = np.flatnonzero(estimate.inliers).astype(np.int32)[:, None]
    return estimate.ok, rvec, estimate.pose.translation[:, None].copy(), inliers if estimate.ok else None


def _straight(points: Any, K: Any, lens: Any) -> Any:
    if lens is None or not np.any(lens):
        return points
    return _cv2.undistortPoints(points[:, None], np.asarray(K, float), np.asarray(lens, float), P=np.asarray(K, float))[:, 0]


def _options(given: Dict[str, Any], threshold: str, unread: Tuple[str, ...]) -> Dict[str, Any]:
    """Ours, of what is left; a name that neither knows is a TypeError of the estimate's."""
    rest = {key: value for key, value in given.items() if key not in unread}
    options = budget_of(rest.pop("maxIters", None))
    if threshold in rest:
        options["max_residual_px"] = rest.pop(threshold)
    return {**options, **rest}
