"""OpenCV's robust estimators with diffsac behind them, for a program that is written for cv2: `import diffsac.cv2 as cv2`.

findEssentialMat, findFundamentalMat, findHomography and solvePnPRansac take what cv2's take, in each of its orders, and `scores`,
`snn_ratio`, `size1`, `size2`, `guidance` and `seed` by name; everything else is cv2's own. So are fits without outliers (method 0 of
findHomography, 7 and 8 points) and what cv2 says of fewer points than a model needs. Of `method`, flags and confidence nothing else
is read, and of UsacParams threshold, maxIterations and randomGeneratorState; a threshold is `max_residual`.
"""

import functools
import importlib
import inspect
import numbers
from typing import Any, Callable, Dict, Optional, Tuple

import numpy as np

import diffsac

from ._calls import described
from ._results import Estimate, Pose
from ._seams import budget_of, points_of

_cv2: Any = importlib.import_module("cv2")
Found = Tuple[Optional[Any], Any]
Given = Dict[str, Any]
_THRESHOLDS = ("threshold", "ransacReprojThreshold", "reprojectionError")


def __getattr__(name: str) -> Any:
    return getattr(_cv2, name)


def _drop_in(fewest: int, estimate: Callable[..., Any], *orders: str, fits: Tuple[Any, ...] = ()) -> Callable[..., Any]:
    """A function of cv2's that takes its arguments in any of `orders`, and those of `estimate` by name. cv2's own answers for fewer
    points than `fewest`, unlike numbers of them, and for the methods `fits`."""
    ways = [inspect.signature(eval(f"lambda {order}: None")) for order in orders]
    names = {name for way in ways for name in way.parameters}
    first, others = ways[0].parameters, inspect.signature(estimate).parameters
    unlike = ("x1", "x2", "K1", "K2", "points3d", "points2d", "K", "max_residual", "max_iterations")
    by_name = [one.replace(kind=inspect.Parameter.KEYWORD_ONLY) for name, one in others.items() if name not in names.union(unlike)]

    def made(function: Callable[[Given, Dict[str, Any]], Any]) -> Callable[..., Any]:
        name = function.__name__

        @functools.wraps(function)
        def call(*args: Any, **kwargs: Any) -> Any:
            ours = {key: kwargs.pop(key) for key in [*kwargs] if key not in names}
            given = next((one for one in (_bound(way, args, kwargs) for way in ways) if one is not None), None)
            if given is None:
                raise TypeError(f"{name}: expected " + ", or ".join(f"({order})" for order in orders))
            count, other = (len(points_of(given.get(key), 3 if key == "objectPoints" else 2)) for key in list(first)[:2])
            if count < fewest or count != other or ("params" not in given and given.get("method") in fits):
                return getattr(_cv2, name)(*args, **kwargs)
            return function(given, {**_options(given), **ours})

        setattr(call, "__signature__", inspect.Signature([*first.values(), *by_name]))
        call.__doc__ = "\n\n".join([function.__doc__ or "", *(f"    {name}({order})" for order in orders), "By name:", described(one.name for one in by_name)])
        return call

    return made


def _bound(way: inspect.Signature, args: Tuple[Any, ...], kwargs: Dict[str, Any]) -> Optional[Given]:
    """The arguments by their names, without None; None where they are of another order."""
    try:
        given = way.bind(*args, **kwargs).arguments
    except TypeError:
        return None
    fit = all(_fits(key, value, way.parameters[key].default) for key, value in given.items())
    return {key: value for key, value in given.items() if value is not None} if fit else None


def _fits(name: str, value: Any, default: Any) -> bool:
    if name == "params":
        return isinstance(value, getattr(_cv2, "UsacParams", ()))  # OpenCV before 4.5 has none.
    if name.startswith("cameraMatrix"):
        return np.ndim(value) == 2
    return value is None or isinstance(value, (numbers.Number, np.bool_)) is isinstance(default, numbers.Number)


def _options(given: Given) -> Dict[str, Any]:
    """Ours."""
    if params := given.get("params"):
        return {"max_residual": params.threshold, "seed": params.randomGeneratorState % 2**32, **budget_of(params.maxIterations)}
    budget = budget_of(given.get("maxIters", given.get("iterationsCount")))
    return {**budget, **{"max_residual": given[key] for key in _THRESHOLDS if key in given}}


def _filled(given: Any, result: Any, shapes: Tuple[Tuple[int, ...], ...]) -> Any:
    """The array that was given, with the result, where cv2 fills it as well; else the result."""
    if not isinstance(given, np.ndarray) or given.dtype != result.dtype or given.shape not in shapes:
        return result
    given[...] = result.reshape(given.shape)
    return given


def _found(estimate: Estimate, mask: Any, scaled: bool = False) -> Found:
    corner = estimate.model[2, 2] if scaled and abs(estimate.model[2, 2]) > 1e-12 else 1.0
    n = len(estimate.inliers)
    inliers = _filled(mask, estimate.inliers.astype(np.uint8)[:, None], ((n, 1), (n,), (1, n)))
    return (estimate.model / corner if estimate.ok else None), inliers


@_drop_in(
    5,
    diffsac.estimate_essential,
    "points1, points2, cameraMatrix, method=8, prob=0.999, threshold=1.0, maxIters=1000, mask=None",
    "points1, points2, focal=1.0, pp=(0, 0), method=8, prob=0.999, threshold=1.0, maxIters=1000, mask=None",
    "points1, points2, cameraMatrix1, distCoeffs1, cameraMatrix2, distCoeffs2, method=8, prob=0.999, threshold=1.0, mask=None",
    "points1, points2, cameraMatrix1, cameraMatrix2, dist_coeff1, dist_coeff2, params, mask=None",
)
def findEssentialMat(given: Given, options: Dict[str, Any]) -> Found:
    """(E, mask). E is None where there is none."""
    focal, (cx, cy) = given.get("focal", 1.0), given.get("pp", (0.0, 0.0))
    K = given.get("cameraMatrix", np.array([[focal, 0, cx], [0, focal, cy], [0, 0, 1.0]]))
    Ks = [np.asarray(given.get(f"cameraMatrix{i}", K), float) for i in (1, 2)]
    lenses = [given.get(f"distCoeffs{i}", given.get(f"dist_coeff{i}")) for i in (1, 2)]
    x1, x2 = (_straight(points_of(given[f"points{i + 1}"]), Ks[i], lenses[i]) for i in (0, 1))
    return _found(diffsac.estimate_essential(x1, x2, *Ks, **options), given.get("mask"))


@_drop_in(
    7,
    diffsac.estimate_fundamental,
    "points1, points2, method=8, ransacReprojThreshold=1.0, confidence=0.99, maxIters=1000, mask=None",
    "points1, points2, method=8, ransacReprojThreshold=1.0, confidence=0.99, mask=None",
    "points1, points2, params, mask=None",
    fits=(_cv2.FM_7POINT, _cv2.FM_8POINT),
)
def findFundamentalMat(given: Given, options: Dict[str, Any]) -> Found:
    """(F, mask), F[2, 2] = 1 where it is not 0."""
    x1, x2 = points_of(given["points1"]), points_of(given["points2"])
    return _found(diffsac.estimate_fundamental(x1, x2, **options), given.get("mask"), scaled=True)


@_drop_in(
    4,
    diffsac.estimate_homography,
    "srcPoints, dstPoints, method=0, ransacReprojThreshold=3.0, mask=None, maxIters=1000, confidence=0.995",
    "srcPoints, dstPoints, params, mask=None",
    fits=(0, None),
)
def findHomography(given: Given, options: Dict[str, Any]) -> Found:
    """(H, mask), H[2, 2] = 1 where it is not 0."""
    x1, x2 = points_of(given["srcPoints"]), points_of(given["dstPoints"])
    return _found(diffsac.estimate_homography(x1, x2, **options), given.get("mask"), scaled=True)


_PNP = "objectPoints, imagePoints, cameraMatrix, distCoeffs, rvec=None, tvec=None, "


@_drop_in(
    4,
    diffsac.estimate_absolute_pose,
    _PNP + "useExtrinsicGuess=False, iterationsCount=1000, reprojectionError=4.0, confidence=0.99, inliers=None, flags=0",
    _PNP + "inliers=None, params=None",
)
def solvePnPRansac(given: Given, options: Dict[str, Any]) -> Any:
    """(found, rvec, tvec, inliers), with params (found, cameraMatrix, rvec, tvec, inliers). A guess is not needed and not read; what
    chance would give is not found."""
    K = np.asarray(given["cameraMatrix"], float)
    x = _straight(points_of(given["imagePoints"]), K, given.get("distCoeffs"))
    estimate = diffsac.estimate_absolute_pose(points_of(given["objectPoints"], 3), x, K, **options)
    found = estimate.pose is not None and estimate.verdict is not diffsac.Verdict.UNSUPPORTED
    rows = np.flatnonzero(estimate.inliers).astype(np.int32)[:, None]
    pose = estimate.pose or Pose(np.eye(3), np.zeros(3))
    vectors = _cv2.Rodrigues(pose.rotation)[0], pose.translation[:, None].copy()
    rvec, tvec = (_filled(given.get(name), vector, ((3, 1),)) for name, vector in zip(("rvec", "tvec"), vectors))
    camera = (given["cameraMatrix"],) if "params" in given else ()
    return (found, *camera, rvec, tvec, _filled(given.get("inliers"), rows, (rows.shape,)) if found else None)


def _straight(points: Any, K: Any, lens: Any) -> Any:
    if lens is None or not np.any(lens):
        return points
    return _cv2.undistortPoints(points[:, None], K, np.asarray(lens, float), P=K)[:, 0]
