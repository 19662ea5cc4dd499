"""Robust estimation of geometric models from points that are only partly right.

    estimate = diffsac.estimate_essential(x1, x2, K1, K2, ratio)
    if estimate.ok and not estimate.may_be_chance:
        use(estimate.pose.rotation, estimate.inliers)

Points are arrays of N rows in pixels (lines and planes: in any unit). `ratio` has for each match the distance of the
nearest descriptor to that of the second-nearest, lower is better: not needed, but it helps most. `scores`, of matchers that give
some, are in its place: from 0 to 1, higher is better, of all matches. `max_residual_px` is the
greatest residual of an inlier in the unit of the points (0: 1 px, homographies 3, absolute poses 4, and of points that
are in no pixels as much in thousandths of how far they go), `max_iterations` how many minimal samples are
drawn at most (0: what is recommended). The same input, options and seed give the same result.

Bad data is a status of the result. Arguments that make no sense, and models that are not found, are a ValueError; too few
or unknown arguments are a TypeError. Rows with values that are not finite, or masked, are left out, and of equal rows one
counts. Other Python threads run during an estimate.
"""

import os as _os

from . import _native
from ._calls import explained as _explained
from ._results import AbsolutePoseEstimate, Cost, Estimate, Estimates, Focal, FocalConflict, Horizon, Pose
from ._results import RigidMotionEstimate
from ._results import SharedFocalEstimate, SimilarityEstimate, Status, Translation, TwoViewEstimate, VanishingFocal
from ._results import VanishingPointsEstimate

estimate_absolute_pose = _explained(_native.estimate_absolute_pose)
estimate_absolute_poses = _explained(_native.estimate_absolute_poses)
estimate_essential = _explained(_native.estimate_essential)
estimate_essentials = _explained(_native.estimate_essentials)
estimate_fundamental = _explained(_native.estimate_fundamental)
estimate_fundamentals = _explained(_native.estimate_fundamentals)
estimate_homographies = _explained(_native.estimate_homographies)
estimate_homography = _explained(_native.estimate_homography)
estimate_line = _explained(_native.estimate_line)
estimate_lines = _explained(_native.estimate_lines)
estimate_one_focal = _explained(_native.estimate_one_focal)
estimate_plane = _explained(_native.estimate_plane)
estimate_planes = _explained(_native.estimate_planes)
estimate_rigid_motion = _explained(_native.estimate_rigid_motion)
estimate_rigid_motions = _explained(_native.estimate_rigid_motions)
estimate_shared_focal = _explained(_native.estimate_shared_focal)
estimate_similarity = _explained(_native.estimate_similarity)
estimate_two_focals = _explained(_native.estimate_two_focals)
estimate_vanishing_points = _explained(_native.estimate_vanishing_points)

__version__: str = _native.VERSION
_native.set_packaged_models(_os.path.join(_os.path.dirname(_os.path.abspath(__file__)), "models"))

__all__ = [
    "AbsolutePoseEstimate",
    "Cost",
    "Estimate",
    "Estimates",
    "Focal",
    "FocalConflict",
    "Horizon",
    "Pose",
    "RigidMotionEstimate",
    "SharedFocalEstimate",
    "SimilarityEstimate",
    "Status",
    "Translation",
    "TwoViewEstimate",
    "VanishingFocal",
    "VanishingPointsEstimate",
    "__version__",
    "estimate_absolute_pose",
    "estimate_absolute_poses",
    "estimate_essential",
    "estimate_essentials",
    "estimate_fundamental",
    "estimate_fundamentals",
    "estimate_homographies",
    "estimate_homography",
    "estimate_line",
    "estimate_lines",
    "estimate_one_focal",
    "estimate_plane",
    "estimate_planes",
    "estimate_rigid_motion",
    "estimate_rigid_motions",
    "estimate_shared_focal",
    "estimate_similarity",
    "estimate_two_focals",
    "estimate_vanishing_points",
]
