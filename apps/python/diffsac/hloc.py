"""hloc's verification of matches and localisation with diffsac in the place of pycolmap's estimators (docs/drop_ins.md).

    hloc.triangulation.estimation_and_geometric_verification = diffsac.hloc.verification(matches)   # hloc's reconstruction.main
    localizer = diffsac.hloc.QueryLocalizer(reconstruction, config)                                 # hloc.localize_sfm's
"""

import importlib
from pathlib import Path
from typing import Any, Callable, Dict, Optional

import numpy as np

import diffsac

from ._calls import ARGUMENTS, renamed
from ._results import TwoViewEstimate, Verdict
from ._seams import camera_points

FEWEST_INLIERS = 15  # Of a pair that counts, as COLMAP's min_num_inliers.


def verification(matches: Optional[Any] = None, **options: Any) -> Callable[..., None]:
    """A function that takes what hloc's estimation_and_geometric_verification takes, and writes a two-view geometry for each pair whose
    matches the database has: E of cameras with a prior focal length, else F. matches: hloc's file of them, whose matching_scores0 are
    the scores of the estimates; None: there are no scores. options: of the estimates, without a network unless guidance="network"."""

    options = renamed(options, ARGUMENTS)

    def verify(database_path: Any, pairs_path: Any, verbose: bool = False) -> None:
        pycolmap = importlib.import_module("pycolmap")
        database = pycolmap.Database.open(str(database_path))
        images = {image.name: image for image in database.read_all_images()}
        cameras = {camera.camera_id: camera for camera in database.read_all_cameras()}
        pairs = [line.split()[:2] for line in Path(pairs_path).read_text().splitlines() if line.split()]
        unknown = sorted({name for pair in pairs for name in pair} - set(images))
        if unknown:
            database.close()
            raise ValueError(f"{pairs_path}: the database has no image {unknown[0]}" + f" ({len(unknown)} such names)" * (len(unknown) > 1))
        for name1, name2 in pairs:
            both = images[name1], images[name2]
            ids = [image.image_id for image in both]
            rows = np.asarray(database.read_matches(*ids))
            if len(rows) == 0 or database.exists_two_view_geometry(*ids):
                continue
            points = [database.read_keypoints(id)[rows[:, i], :2].astype(float) for i, id in enumerate(ids)]
            given = {"guidance": "none", "scores": _scores(matches, name1, name2, rows), **options}
            geometry = _geometry(pycolmap, points, rows, [cameras[image.camera_id] for image in both], given)
            database.write_two_view_geometry(*ids, geometry)
            if verbose:
                print(f"{name1} {name2}: {len(geometry.inlier_matches)} of {len(rows)} matches")
        database.close()

    return verify


class QueryLocalizer:
    """hloc.localize_sfm.QueryLocalizer's calls. config: {"estimation": {"ransac": {"max_error": pixels}}} as hloc's; more are ours."""

    def __init__(self, reconstruction: Any, config: Optional[Dict[str, Any]] = None, **options: Any) -> None:
        self.reconstruction, self.config = reconstruction, config or {}
        most = self.config.get("estimation", {}).get("ransac", {}).get("max_error")
        self.options = {**({"max_residual": most} if most else {}), **options}

    def localize(self, points2D_all: Any, points2D_idxs: Any, points3D_id: Any, query_camera: Any, scores: Optional[Any] = None) -> Optional[Any]:
        """{"cam_from_world", "num_inliers", "inlier_mask"}, or None. points2D_all: in COLMAP's pixels, as hloc gives them."""
        pycolmap = importlib.import_module("pycolmap")
        points3d = np.array([self.reconstruction.points3D[j].xyz for j in points3D_id]).reshape(-1, 3)
        x, K = camera_points(np.asarray(points2D_all, float)[points2D_idxs].reshape(-1, 2), query_camera)
        estimate = diffsac.estimate_absolute_pose(points3d, x, K, scores=scores, **self.options)
        if estimate.pose is None:
            return None
        pose = pycolmap.Rigid3d(pycolmap.Rotation3d(estimate.pose.rotation), estimate.pose.translation)
        return {"cam_from_world": pose, "num_inliers": estimate.num_inliers, "inlier_mask": estimate.inliers, "estimate": estimate}


def _scores(path: Optional[Any], name1: str, name2: str, matches: Any) -> Optional[Any]:
    """Of these matches, from hloc's file, in which the pair may stand the other way round; None where it has none."""
    if path is None:
        return None
    with importlib.import_module("h5py").File(str(path), "r") as file:
        for first, second, column in ((name1, name2, 0), (name2, name1, 1)):
            for between in "/_":
                pair = between.join(name.replace("/", "-") for name in (first, second))
                if pair in file and "matching_scores0" in file[pair]:
                    return file[pair]["matching_scores0"][()].astype(float)[matches[:, column]]
    return None


def _geometry(pycolmap: Any, points: Any, rows: Any, cameras: Any, options: Dict[str, Any]) -> Any:
    """Of the kind that COLMAP's mapper starts from."""
    geometry, kind = pycolmap.TwoViewGeometry(), pycolmap.TwoViewGeometryConfiguration
    calibrated = all(camera.has_prior_focal_length for camera in cameras)
    options = {**options, **{f"size{i + 1}": (camera.width, camera.height) for i, camera in enumerate(cameras)}}
    if calibrated:
        (x1, K1), (x2, K2) = (camera_points(x, camera) for x, camera in zip(points, cameras))
        estimate: TwoViewEstimate = diffsac.estimate_essential(x1, x2, K1, K2, **options)
        geometry.E = estimate.model
    else:
        estimate = diffsac.estimate_fundamental(*points, **options)
        geometry.F = estimate.model
    if not estimate.ok or estimate.verdict is Verdict.UNSUPPORTED or estimate.num_inliers < FEWEST_INLIERS:
        geometry.config = kind.DEGENERATE
        return geometry
    flat = estimate.diagnostics.degeneracy.value in ("pure_rotation", "plane", "static")
    geometry.config = kind.PLANAR_OR_PANORAMIC if flat else kind.CALIBRATED if calibrated else kind.UNCALIBRATED
    geometry.inlier_matches = rows[estimate.inliers].astype(np.uint32)
    if estimate.pose is not None:
        geometry.cam2_from_cam1 = pycolmap.Rigid3d(pycolmap.Rotation3d(estimate.pose.rotation), estimate.pose.translation)
    return geometry
