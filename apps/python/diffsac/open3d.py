"""Open3D's global registration, and KISS-Matcher's, with diffsac behind them (docs/open3d.md).

    import diffsac.open3d as registration             # in the place of open3d.pipelines.registration, whose other names it has too
    result = registration.registration_ransac_based_on_feature_matching(source, target, source_fpfh, target_fpfh, True, 0.075, ...)
    result.transformation, result.fitness             # Open3D's fields, and beside them
    result.verdict, result.covariance, result.ambiguous_transformation, result.estimate

The same clouds and `seed` give the same digits with any number of threads; of Open3D's seed, which can be set but not be read, nothing
depends. Clouds are Open3D's or arrays N x 3, features arrays D x N, correspondences arrays K x 2; without Open3D results have the shape of its
class. All four functions take `seed` and `num_threads` by name, those of correspondences `snn_ratio` or `scores` too.
"""

import functools
import importlib
from types import SimpleNamespace
from typing import Any, Dict, Optional, Sequence, Tuple

import numpy as np

import diffsac

from ._results import Floats, Pose, Verdict

OUR_BUDGET = 10000  # Draws, unless a caller asks for fewer: Open3D's are of three correspondences that nothing links.
_LEAST_MUTUAL = 0.1  # Of the source's points: below, Open3D takes all correspondences.


def open3d() -> Any:
    """Open3D, or an error that says what to install."""
    try:
        return importlib.import_module("open3d")
    except ImportError as error:
        raise ImportError(f"clouds need Open3D, which cannot be imported ({error}): pip install open3d") from None


def __getattr__(name: str) -> Any:
    if name.startswith("__"):
        raise AttributeError(name)
    return getattr(open3d().pipelines.registration, name)


def registration_ransac_based_on_correspondence(
    source: Any, target: Any, corres: Any, max_correspondence_distance: float, estimation_method: Optional[Any] = None, ransac_n: int = 3,
    checkers: Sequence[Any] = (), criteria: Optional[Any] = None, **options: Any
) -> Any:
    """Open3D's RegistrationResult, with ours beside it. Of the estimation methods point-to-point is taken, with or without scaling; of the
    checkers those of edge lengths and of distances; others are a NotImplementedError that names them. A criterion's max_iteration below
    10000 is read, and its confidence."""
    if ransac_n < 3:
        raise ValueError(f"ransac_n: expected 3 or more, got {ransac_n}")
    if type(estimation_method).__name__ not in ("NoneType", "TransformationEstimationPointToPoint"):
        raise NotImplementedError(f"estimation_method: diffsac fits by TransformationEstimationPointToPoint, not by {type(estimation_method).__name__}")
    points, scaled = (_points(source, "source"), _points(target, "target")), bool(getattr(estimation_method, "with_scaling", False))
    pairs = _pairs(corres, *map(len, points))
    similarity, nearest = _checked(checkers)
    options = {**_criteria(criteria), "max_residual": min(max_correspondence_distance, nearest), **options}
    return _registered((source, target), points, pairs, max_correspondence_distance, scaled, options, similarity)


def registration_ransac_based_on_feature_matching(
    source: Any, target: Any, source_feature: Any, target_feature: Any, mutual_filter: bool, max_correspondence_distance: float,
    estimation_method: Optional[Any] = None, ransac_n: int = 3, checkers: Sequence[Any] = (), criteria: Optional[Any] = None, **options: Any
) -> Any:
    """The same of the nearest features, by default in the order of their ratios. mutual_filter: only of pairs that are each other's nearest,
    if these are a tenth of the source's points."""
    pairs, options["snn_ratio"] = matched(_features(source_feature), _features(target_feature), mutual_filter)
    return registration_ransac_based_on_correspondence(
        source, target, pairs, max_correspondence_distance, estimation_method, ransac_n, checkers, criteria, **options
    )


def registration_fgr_based_on_correspondence(source: Any, target: Any, corres: Any, option: Optional[Any] = None, **options: Any) -> Any:
    """Of `option` maximum_correspondence_distance and use_absolute_scale are read: without the latter, Open3D's default, the distance is in
    units of the greatest distance of a point from its cloud's middle. The rest says how fast global registration searches."""
    points = _points(source, "source"), _points(target, "target")
    most, absolute = getattr(option, "maximum_correspondence_distance", 0.025), getattr(option, "use_absolute_scale", False)
    reach = 1.0 if absolute else max((float(np.linalg.norm(side - side.mean(0), axis=1).max()) for side in points if len(side)), default=0.0)
    pairs, options = _pairs(corres, *map(len, points)), {"max_residual": most * (reach or 1.0), **options}
    return _registered((source, target), points, pairs, most, False, options)


def registration_fgr_based_on_feature_matching(
    source: Any, target: Any, source_feature: Any, target_feature: Any, option: Optional[Any] = None, **options: Any
) -> Any:
    """The same of features that are each other's nearest."""
    pairs, options["snn_ratio"] = matched(_features(source_feature), _features(target_feature), True, 0.0)
    return registration_fgr_based_on_correspondence(source, target, pairs, option, **options)


class KISSMatcher:
    """kiss_matcher.KISSMatcher's calls. config: its KISSMatcherConfig, of which voxel_size and use_voxel_sampling are read, or a voxel size.
    options: of diffsac.estimate_rigid_motion; max_residual is two voxels by default. Of a solution `valid` is False where the motion may be
    chance, and `estimate` is ours."""

    def __init__(self, config: Any = 0.3, **options: Any) -> None:
        if getattr(config, "use_quatro", False):
            raise NotImplementedError("use_quatro: diffsac has no motion of four degrees of freedom")
        self.voxel_size, self.thin = float(getattr(config, "voxel_size", config)), getattr(config, "use_voxel_sampling", True)
        self.options = {"max_residual": 2.0 * self.voxel_size, **options}
        self._inliers: Any = np.zeros(0, bool)

    def estimate(self, src: Any, tgt: Any) -> SimpleNamespace:
        """Of two clouds, Open3D's or N x 3, by FPFH."""
        sides = [describe(as_cloud(cloud), self.voxel_size, self.thin) for cloud in (src, tgt)]
        pairs, ratios = matched(sides[0][1], sides[1][1], True, 0.0)
        return self.prune_and_solve(*(np.asarray(cloud.points)[rows] for (cloud, _), rows in zip(sides, pairs.T)), snn_ratio=ratios)

    def prune_and_solve(self, src_matched: Any, tgt_matched: Any, **options: Any) -> SimpleNamespace:
        """Of points N x 3 whose row i matches row i of the other's."""
        given = _points(src_matched, "src_matched"), _points(tgt_matched, "tgt_matched")
        found = diffsac.estimate_rigid_motion(*given, **{**self.options, **options})
        self._inliers, pose = found.inliers, found.pose or Pose(np.eye(3), np.zeros(3))
        valid = found.pose is not None and found.verdict is not Verdict.UNSUPPORTED
        return SimpleNamespace(rotation=pose.rotation, translation=pose.translation, valid=valid, estimate=found)

    def get_num_final_inliers(self) -> int:
        return int(self._inliers.sum())


def as_cloud(points: Any) -> Any:
    """Open3D's cloud of an array N x 3; a cloud stays."""
    return points if hasattr(points, "points") else open3d().geometry.PointCloud(open3d().utility.Vector3dVector(np.asarray(points, float)))


def describe(cloud: Any, voxel: float, thin: bool = True, viewpoint: Optional[Any] = None) -> Tuple[Any, Floats]:
    """The cloud with one point a cube, and its descriptors, D x N: roots of FPFH of five voxels, whose Euclidean distance is Hellinger's of
    histograms. Normals that it lacks are those of two voxels, towards the viewpoint, without one towards its middle."""
    o3d = open3d()
    cloud = cloud.voxel_down_sample(voxel) if thin else o3d.geometry.PointCloud(cloud)
    if not cloud.has_normals() and not cloud.is_empty():
        cloud.estimate_normals(o3d.geometry.KDTreeSearchParamHybrid(2.0 * voxel, 30))
        cloud.orient_normals_towards_camera_location(cloud.get_center() if viewpoint is None else viewpoint)
    if cloud.is_empty():
        return cloud, np.zeros((33, 0))
    found = o3d.pipelines.registration.compute_fpfh_feature(cloud, o3d.geometry.KDTreeSearchParamHybrid(5.0 * voxel, 100))
    data = np.maximum(np.asarray(found.data), 0.0)
    sums = data.sum(0)
    return cloud, np.sqrt(data / np.where(sums > 0.0, sums, 1.0))


def matched(first: Floats, second: Floats, mutual: bool, least: float = _LEAST_MUTUAL) -> Tuple[Any, Floats]:
    """K x 2 of features D x N and D x M: the nearest one of the second for each of the first, by Euclidean distance; and the ratio of its
    distance to that of the next one. mutual: only pairs that are each other's nearest, if at least this share of the first ones is."""
    if not first.shape[1] or not second.shape[1]:
        return np.zeros((0, 2), np.int32), np.zeros(0)
    to, distances = _nearest(first.T, second.T)
    pairs = np.column_stack([np.arange(len(to)), to[:, 0]]).astype(np.int32)
    ratios = np.divide(distances[:, 0], distances[:, -1], out=np.ones(len(to)), where=distances[:, -1] > 0.0)
    if mutual:
        back, _ = _nearest(second.T, first.T)
        kept = back[pairs[:, 1], 0] == pairs[:, 0]
        if kept.sum() >= least * len(kept):
            return pairs[kept], ratios[kept]
    return pairs, ratios


def _nearest(queries: Floats, rows: Floats) -> Tuple[Any, Floats]:
    """The two nearest rows of each query and their distances. Products find them; the distances do not depend on how threads add those."""
    queries, rows = queries - rows.mean(0), rows - rows.mean(0)
    squares, near = np.einsum("ij,ij->i", rows, rows), np.zeros((len(queries), 2), np.int64)
    for start in range(0, len(queries), 1024):
        apart, part = squares - 2.0 * (queries[start : start + 1024] @ rows.T), near[start : start + 1024]
        part[:, 0] = apart.argmin(1)
        np.put_along_axis(apart, part[:, :1], np.inf, 1)
        part[:, 1] = apart.argmin(1)
    distances = np.sqrt(((queries[:, None] - rows[near]) ** 2).sum(2))
    order = np.argsort(distances, axis=1, kind="stable")
    return np.take_along_axis(near, order, 1), np.take_along_axis(distances, order, 1)


def _points(cloud: Any, name: str) -> Floats:
    points = np.asarray(getattr(cloud, "points", cloud), float)
    if points.size and (points.ndim != 2 or points.shape[1] != 3):
        raise ValueError(f"{name}: expected a cloud or N x 3 numbers, got shape {points.shape}")
    return points.reshape(-1, 3)


def _features(feature: Any) -> Floats:
    return np.asarray(feature if isinstance(feature, np.ndarray) else feature.data, float)  # Of an array `data` is its memory.


def _pairs(corres: Any, first: int, second: int) -> Any:
    pairs = np.asarray(corres)
    if pairs.size and (pairs.ndim != 2 or pairs.shape[1] != 2 or pairs.dtype.kind not in "iu"):
        raise ValueError(f"corres: expected K x 2 whole numbers, got {pairs.dtype} of shape {pairs.shape}")
    if pairs.size and (pairs.min() < 0 or (pairs.max(0) >= (first, second)).any()):
        raise ValueError(f"corres: a place that the clouds of {first} and {second} points do not have")
    return pairs.reshape(-1, 2)


def _checked(checkers: Sequence[Any]) -> Tuple[float, float]:
    """The greatest similarity of edges that is asked for, and the least distance."""
    given = {"CorrespondenceCheckerBasedOnEdgeLength": [0.0], "CorrespondenceCheckerBasedOnDistance": [np.inf]}
    for checker in checkers:
        name = type(checker).__name__
        if name not in given:
            raise NotImplementedError(f"checkers: diffsac checks edge lengths and distances, and has no {name}")
        given[name].append(getattr(checker, "similarity_threshold", getattr(checker, "distance_threshold", np.nan)))
    lengths, distances = given.values()
    return max(lengths), min(distances)


def _criteria(criteria: Any) -> Dict[str, Any]:
    most, confidence = min(getattr(criteria, "max_iteration", OUR_BUDGET), OUR_BUDGET), getattr(criteria, "confidence", 0.999)
    return {"max_iterations": most, **({"min_iterations": most} if confidence >= 1.0 else {"confidence": confidence})}


def _registered(clouds: Any, points: Any, pairs: Any, most: float, scaled: bool, options: Dict[str, Any], similarity: float = 0.0) -> Any:
    estimate = (diffsac.estimate_similarity if scaled else diffsac.estimate_rigid_motion)(*(p[k] for p, k in zip(points, pairs.T)), **options)
    scale = getattr(estimate, "scale", 1.0)
    found = estimate.pose is not None and min(scale, 1.0 / scale) >= similarity
    (kind, vector), other = _result_class(), estimate.ambiguous_pose if found else None
    result = kind()
    result.estimate, result.verdict = estimate, estimate.verdict if found else Verdict.FAILED
    result.covariance = estimate.pose_covariance if found else None
    result.ambiguous_transformation = None if other is None else matrix(np.column_stack([scale * other.rotation, other.translation]))
    result.transformation = matrix(estimate.model) if found else np.eye(4)
    near, apart = _within(clouds, points, result.transformation, most) if found else (np.zeros((0, 2), np.int32), np.zeros(0))
    result.correspondence_set, result.fitness = vector(near), len(near) / max(1, len(points[0]))
    result.inlier_rmse = float(np.sqrt((apart**2).mean())) if len(near) else 0.0
    return result


def matrix(model: Floats) -> Floats:
    return np.vstack([model, [0.0, 0.0, 0.0, 1.0]])


def _within(clouds: Any, points: Any, motion: Floats, most: float) -> Tuple[Any, Floats]:
    """The source's points that have one of the target within a distance, with the nearest, and how far they are; in the order of the source."""
    moved = (points[0][:, None, :] * motion[:3, :3]).sum(2) + motion[:3, 3]
    if any(hasattr(cloud, "points") for cloud in clouds):
        found = open3d().pipelines.registration.evaluate_registration(*map(as_cloud, clouds), most, motion)
        near = np.asarray(found.correspondence_set).reshape(-1, 2)
        near = near[np.argsort(near[:, 0], kind="stable")]
    else:
        to, distances = _nearest(moved, points[1])
        rows = np.flatnonzero(distances[:, 0] < most)
        near = np.column_stack([rows, to[rows, 0]]).astype(np.int32)
    return near, np.sqrt(((moved[near[:, 0]] - points[1][near[:, 1]]) ** 2).sum(1))


@functools.lru_cache(None)
def _result_class() -> Any:
    """A class of Open3D's own, where it is installed, so that its functions take results; and what its correspondences are."""
    try:
        base, vector = open3d().pipelines.registration.RegistrationResult, open3d().utility.Vector2iVector
    except ImportError:
        base, vector = object, np.asarray
    return type("RegistrationResult", (base,), {"__module__": "diffsac.open3d"}), vector
