"""Robust estimation of geometric models in the presence of outliers.

    estimate = diffsac.estimate_essential(x1, x2, K1, K2, snn_ratio, confidence=0.9999, seed=7)
    if estimate.verdict is diffsac.Verdict.RELIABLE:
        use(estimate.pose.rotation, estimate.inliers)

By default a small network and PROSAC together guide the samples of E, F and H (guidance="network"): it finds more poses than
PROSAC where few matches are right, and as many as the diffusion process of the paper (guidance="diffusion") in a fraction of
its time. guidance="none" is PROSAC alone.

Points are arrays of N rows in pixels or any other unit. `snn_ratio` is, for each match, the descriptor distance of the nearest
neighbour divided by that of the second-nearest: it is optional, but helps most. `scores` replaces it for matchers with
confidences. The same input, options and seed give the same result.

Returns a status for bad data. Raises ValueError for options out of range and TypeError for missing or unknown arguments.
Rows with values that are not finite, or masked, are dropped, and duplicates are merged. Other Python threads run during an
estimate.
"""

import warnings as _warnings
from typing import Any as _Any

from . import _native
from ._calls import explained as _explained
from ._former_names import NAMES as _NAMES
from ._results import AbsolutePoseEstimate, Degeneracy, Diagnostics, Estimate, EstimationStats, Focal, FocalConflict, Horizon
from ._results import MultiModelEstimate, Pose, PoseEstimate, RigidMotionEstimate, SimilarityEstimate, Status, TwoViewEstimate, UnknownFocalEstimate
from ._results import VanishingFocal, VanishingPointsEstimate, Verdict

estimate_absolute_pose = _explained(_native.estimate_absolute_pose)
estimate_essential = _explained(_native.estimate_essential)
estimate_fundamental = _explained(_native.estimate_fundamental)
estimate_homography = _explained(_native.estimate_homography)
estimate_line = _explained(_native.estimate_line)
estimate_multiple_absolute_poses = _explained(_native.estimate_multiple_absolute_poses)
estimate_multiple_essentials = _explained(_native.estimate_multiple_essentials)
estimate_multiple_fundamentals = _explained(_native.estimate_multiple_fundamentals)
estimate_multiple_homographies = _explained(_native.estimate_multiple_homographies)
estimate_multiple_lines = _explained(_native.estimate_multiple_lines)
estimate_multiple_planes = _explained(_native.estimate_multiple_planes)
estimate_multiple_rigid_motions = _explained(_native.estimate_multiple_rigid_motions)
estimate_one_focal = _explained(_native.estimate_one_focal)
estimate_plane = _explained(_native.estimate_plane)
estimate_rigid_motion = _explained(_native.estimate_rigid_motion)
estimate_shared_focal = _explained(_native.estimate_shared_focal)
estimate_similarity = _explained(_native.estimate_similarity)
estimate_two_focals = _explained(_native.estimate_two_focals)
estimate_vanishing_points = _explained(_native.estimate_vanishing_points)

__version__: str = _native.VERSION

def __getattr__(name: str) -> _Any:
    if name not in _NAMES:
        raise AttributeError(f"module 'diffsac' has no attribute '{name}'")
    _warnings.warn(f"diffsac.{name} is diffsac.{_NAMES[name]} since diffsac 0.3", DeprecationWarning, stacklevel=2)
    return globals()[_NAMES[name]]


__all__ = [
    "AbsolutePoseEstimate",
    "Degeneracy",
    "Diagnostics",
    "Estimate",
    "EstimationStats",
    "Focal",
    "FocalConflict",
    "Horizon",
    "MultiModelEstimate",
    "Pose",
    "PoseEstimate",
    "RigidMotionEstimate",
    "SimilarityEstimate",
    "Status",
    "TwoViewEstimate",
    "UnknownFocalEstimate",
    "VanishingFocal",
    "VanishingPointsEstimate",
    "Verdict",
    "__version__",
    "estimate_absolute_pose",
    "estimate_essential",
    "estimate_fundamental",
    "estimate_homography",
    "estimate_line",
    "estimate_multiple_absolute_poses",
    "estimate_multiple_essentials",
    "estimate_multiple_fundamentals",
    "estimate_multiple_homographies",
    "estimate_multiple_lines",
    "estimate_multiple_planes",
    "estimate_multiple_rigid_motions",
    "estimate_one_focal",
    "estimate_plane",
    "estimate_rigid_motion",
    "estimate_shared_focal",
    "estimate_similarity",
    "estimate_two_focals",
    "estimate_vanishing_points",
]
