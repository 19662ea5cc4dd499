"""What the estimates return. Fields are those of the C++ header diffsac/diffsac.h."""

import enum
import operator
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Optional, Tuple

import numpy as np
from numpy.typing import NDArray

from ._former_names import FIELDS

Floats = NDArray[np.float64]


class Status(str, enum.Enum):
    """How an estimate ended. Bad data is a status, never an exception."""

    OK = "ok"
    TOO_FEW_POINTS = "too_few_points"  # Fewer than a minimal set needs.
    DEGENERATE = "degenerate"  # Points that determine no model.
    NO_MODEL = "no_model"  # Models were tried, but none was supported by the data.
    TOO_MANY_POINTS = "too_many_points"


class Verdict(str, enum.Enum):
    """Whether a result may be used. If several hold, the first."""

    FAILED = "failed"  # No model; `status` says why.
    UNSUPPORTED = "unsupported"  # No more inliers than unrelated points would give: do not use it.
    UNRELIABLE = "unreliable"  # E, F: more often wrong than right, by more than 10 degrees in R or t.
    ROTATION_ONLY = "rotation_only"  # The camera only rotated, or did not move: R is right, t is 0.
    PLANAR = "planar"  # The inliers lie on one plane (F) or line: they are right, the model is one of many that fit.
    AMBIGUOUS = "ambiguous"  # Two poses explain the inliers: `pose` and `ambiguous_pose`.
    RELIABLE = "reliable"


class Degeneracy(str, enum.Enum):
    """What the inliers of two views leave undetermined."""

    NOT_TESTED = "not_tested"  # There is no model, or it is not of two views.
    DETERMINED = "determined"
    PURE_ROTATION = "pure_rotation"  # Any translation explains the matches.
    STATIC = "static"  # The images show no motion.
    PLANE = "plane"  # F: the matches lie on one plane, or the camera only rotated.
    LINE = "line"  # The matches lie on one line.


class _Result:
    """Fields of version 0.2, which warn; removed in 0.4."""

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            new = FIELDS.get(name)
            if new is None:
                raise AttributeError(f"{type(self).__name__} has no field '{name}'")
            if "diagnostics" not in getattr(type(self), "__dataclass_fields__", {}):
                new = new.rpartition(".")[2]
            if new == name:
                raise AttributeError(f"{type(self).__name__} has no field '{name}'")
            value = operator.attrgetter(new)(self)
            warnings.warn(f"{name} is {new} since diffsac 0.3", DeprecationWarning, stacklevel=2)
            return value


@dataclass(frozen=True, eq=False)
class EstimationStats(_Result):
    """Work and time of an estimate."""

    hypotheses: int  # Models that were solved or scored.
    unique_minimal_sets: int
    iterations: int  # Minimal samples.
    ms_features: float  # Milliseconds, as those below.
    ms_network: float
    ms_consensus: float
    ms_total: float


@dataclass(frozen=True, eq=False)
class FocalConflict:
    """Focal lengths of the two images, in pixels, that contradict the matches."""

    said_px: Tuple[float, float]  # By a calibration, or the median of the prior.
    found_px: Tuple[float, float]  # By the matches alone.
    low_px: Tuple[float, float]  # From `low_px` to `high_px`: 68 % of these.
    high_px: Tuple[float, float]


@dataclass(frozen=True, eq=False)
class Diagnostics:
    """The numbers behind a verdict."""

    log10_nfa: float  # log10 of the number of models with as many inliers expected by chance. Above 0: UNSUPPORTED.
    error_probability: float  # E, F: that R or t is off by more than 10 degrees. Above 0.5: UNRELIABLE. Else NaN.
    degeneracy: Degeneracy
    cheirality_failure_ratio: float  # E, absolute poses: share of fitting points behind a camera, which are no inliers.
    mirrored: bool  # The matches fit the mirror image of the second photograph; the result is UNSUPPORTED then.
    # E, unknown focal lengths: the matches contradict K1 and K2, or the prior. The result is UNRELIABLE then.
    focal_conflict: Optional[FocalConflict]
    scores_ignored: bool  # Ratios or scores were not used: right matches do not have the better ones.
    num_nonfinite: int  # Rows with a non-finite or masked value, which are dropped.
    num_duplicates: int  # Rows that equal another one. Everything but `num_inliers` counts them once.


@dataclass(frozen=True, eq=False)
class Pose:
    """A motion: x' = rotation @ x + translation."""

    rotation: Floats  # 3 × 3.
    translation: Floats  # 3. Of two views: of length 1.


@dataclass(frozen=True, eq=False)
class Focal:
    """Focal lengths of the two images in pixels, by the matches and the prior together; a length that was given is
    observable, with a prior of width 0."""

    focal_px: Tuple[float, float]
    low_px: Tuple[float, float]  # From `low_px` to `high_px`: the central 68 %.
    high_px: Tuple[float, float]
    observable: Tuple[bool, bool]  # Whether the matches say more than the prior does.
    prior_focal_px: Tuple[float, float]
    prior_log_sigma: Tuple[float, float]


@dataclass(frozen=True, eq=False)
class Estimate(_Result):
    """One model. Lines and planes: coefficients; two views: 3 × 3; absolute poses and registration: 3 × 4."""

    status: Status
    verdict: Verdict  # Whether the result may be used.
    model: Floats  # Zero unless the status is OK.
    inliers: NDArray[np.bool_]  # N: which points are inliers of `model`.
    num_inliers: int  # Number of True in `inliers`, duplicates included.
    inlier_threshold: float  # Threshold of `inliers`: max_residual, or less if the noise is lower.
    sigma: float  # Standard deviation of one coordinate of the inliers' residuals; NaN if it was not estimated.
    inlier_probabilities: Optional[NDArray[np.float32]]  # N, by the network before the search; None without one.
    posteriors: NDArray[np.float32]  # N: probability that each point is right under the model; 0 without one.
    diagnostics: Diagnostics
    stats: EstimationStats

    @property
    def ok(self) -> bool:
        return self.status is Status.OK

    @property
    def reliable(self) -> bool:
        return self.verdict is Verdict.RELIABLE

    @property
    def may_be_chance(self) -> bool:
        """Of version 0.2: the verdict is UNSUPPORTED."""
        return self.verdict is Verdict.UNSUPPORTED

    @property
    def may_be_wrong(self) -> bool:
        """Of version 0.2: the verdict is UNSUPPORTED or UNRELIABLE."""
        return self.verdict in (Verdict.UNSUPPORTED, Verdict.UNRELIABLE)


@dataclass(frozen=True, eq=False)
class PoseEstimate(Estimate):
    """One model with a pose."""

    # Two views: the second camera in the first one's frame, |t| = 1, or t = 0 if it only rotated. Absolute poses: world to
    # camera. Registration: points2 = R points1 + t. None if it is not determined.
    pose: Optional[Pose]
    pose_covariance: Optional[Floats]  # In the order (ω, t), with a scale (ω, t, log s): R = exp([ω]×) R̂; or None.
    ambiguous_pose: Optional[Pose]  # A second pose that explains the points nearly as well, or None.

    @property
    def ambiguous(self) -> bool:
        """Of version 0.2: there is an `ambiguous_pose`."""
        return self.ambiguous_pose is not None


@dataclass(frozen=True, eq=False)
class TwoViewEstimate(PoseEstimate):
    """F, E or H. The pose is E's. `focal`: F of images of one size, where the matches allow one camera."""

    focal: Optional[Focal]


@dataclass(frozen=True, eq=False)
class UnknownFocalEstimate(TwoViewEstimate):
    """F of two views of unknown focal length. `pose_covariance` is None."""

    K1: Floats  # With the focal lengths of `focal`; the identity unless the status is OK.
    K2: Floats


@dataclass(frozen=True, eq=False)
class AbsolutePoseEstimate(PoseEstimate):
    """A world-to-camera pose."""


@dataclass(frozen=True, eq=False)
class RigidMotionEstimate(PoseEstimate):
    """A motion between two clouds: points2 ≈ R points1 + t."""


@dataclass(frozen=True, eq=False)
class SimilarityEstimate(PoseEstimate):
    """A motion with a scale: points2 ≈ s R points1 + t. `pose` is R and t."""

    scale: float  # s.


@dataclass(frozen=True, eq=False)
class MultiModelEstimate(_Result):
    """Multiple models of one kind in the same points. Their number is found."""

    status: Status  # NO_MODEL: no model has more points than chance would give it.
    models: Floats  # M × the shape of one model, that of most points first.
    assignment: NDArray[np.int32]  # N: 0 for an outlier, k for a point of models[k - 1].
    stats: EstimationStats
    num_nonfinite: int  # As Diagnostics'.
    num_duplicates: int

    @property
    def ok(self) -> bool:
        return self.status is Status.OK


@dataclass(frozen=True, eq=False)
class VanishingFocal:
    """A focal length that vanishing points say."""

    focal_px: float
    log_sigma: float  # Standard deviation of its logarithm.
    orthogonal: Tuple[int, ...]  # The two or three vanishing points whose directions it makes orthogonal.


@dataclass(frozen=True, eq=False)
class Horizon:
    """The image of all horizontal directions, of a camera that is held about upright."""

    line: Floats  # (a, b, c): a x + b y + c = 0 in pixels, a² + b² = 1, b > 0.
    up: Floats  # The upward direction in the camera's frame (x right, y down, z ahead); without K of a usual camera.
    tilt_deg: float  # By how much it falls to the right.
    pitch_deg: float  # How far the camera looks up.
    vertical: Optional[int]  # The vanishing point of vertical lines.
    horizontal: Tuple[int, ...]  # Those of horizontal lines.


@dataclass(frozen=True, eq=False)
class VanishingPointsEstimate(_Result):
    """The vanishing points of an image, the surest first."""

    status: Status  # NO_MODEL: nothing that a person would call one.
    points: Floats  # M × 3: homogeneous pixels, of unit length.
    directions: Optional[Floats]  # M × 3: in the camera's frame; None where K is unknown.
    values: Optional[Floats]  # M: how sure the network is of each beside those before it; None without a network.
    assignment: NDArray[np.int32]  # N: 0 for a segment of none, k for one of points[k - 1].
    K: Optional[Floats]  # That was given, or of `focal`.
    focal: Optional[VanishingFocal]  # Found where no K was given.
    horizon: Optional[Horizon]
    stats: EstimationStats
    num_nonfinite: int  # As Diagnostics'.
    num_duplicates: int

    @property
    def ok(self) -> bool:
        return self.status is Status.OK
