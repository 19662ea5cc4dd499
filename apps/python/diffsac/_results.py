"""What the estimates return. Fields are those of the C++ header diffsac/diffsac.h."""

import enum
from dataclasses import dataclass
from typing import Optional, Tuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Status(str, enum.Enum):
    """How an estimate ended. Bad data is a status, never an exception."""

    OK = "ok"
    TOO_FEW_POINTS = "too_few_points"  # Fewer than a minimal set needs.
    DEGENERATE = "degenerate"  # Points that determine no model.
    NO_MODEL = "no_model"  # Models were tried, but none was supported by the data.
    TOO_MANY_POINTS = "too_many_points"


class Translation(str, enum.Enum):
    """Whether the matches of two views determine the translation, or, of F and H, the model; else why not."""

    NOT_TESTED = "not_tested"  # There is no model.
    DETERMINED = "determined"
    TURN = "turn_in_place"  # The camera only turned: any translation explains the matches.
    STATIC = "static"  # The images show no motion.
    PLANE = "plane"  # F: the matches lie on one plane, or the camera only turned.
    LINE = "line"  # The matches lie on one line.


@dataclass(frozen=True, eq=False)
class Cost:
    """What an estimate cost: every model that was solved or scored, and milliseconds."""

    hypotheses: int
    unique_minimal_sets: int
    draws: int
    ms_features: float
    ms_network: float
    ms_consensus: float
    ms_total: float


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
class FocalConflict:
    """Focal lengths of the two images, in pixels, that contradict the matches."""

    said_px: Tuple[float, float]  # By a calibration, or the likeliest of the prior.
    found_px: Tuple[float, float]  # By the matches alone.
    low_px: Tuple[float, float]  # From `low_px` to `high_px`: 68 % of these.
    high_px: Tuple[float, float]


@dataclass(frozen=True, eq=False)
class Estimate:
    """One model. Lines and planes: coefficients; two views: 3 × 3; absolute poses: [R | t], 3 × 4."""

    status: Status
    model: Floats  # Zero unless the status is OK.
    inliers: NDArray[np.bool_]  # N: which points are inliers of `model`.
    num_inliers: int  # Of `inliers`, repeated rows included.
    inlier_threshold: float  # Of these: what was asked for, or less where the noise was found to be less.
    noise_scale: float  # σ of one coordinate of the inliers' residuals, in pixels or the points' unit; NaN: not estimated.
    log_false_alarms: float  # log10 of the number of models with as many inliers that chance would give.
    inlier_probabilities: Optional[NDArray[np.float32]]  # N, by the network before the search; None without one.
    posteriors: NDArray[np.float32]  # N, how likely each match or point is right under the model; 0 without one.
    cost: Cost
    rows_left_out: int  # That have a value that is not finite, or masked.
    repeated_rows: int  # That equal another one: `log_false_alarms` and all else but `num_inliers` count it once.
    scores_ignored: bool  # Whether scores or ratios were not used: right matches are not the better scored, or none were found by them.

    @property
    def ok(self) -> bool:
        return self.status is Status.OK

    @property
    def may_be_chance(self) -> bool:
        """Whether points without any model would give one like this: better not relied upon."""
        return self.log_false_alarms > 0.0


@dataclass(frozen=True, eq=False)
class TwoViewEstimate(Estimate):
    """F, E or H."""

    pose: Optional[Pose]  # E: the second camera seen from the first; t = 0 where it only turned or stood still.
    pose_covariance: Optional[Floats]  # 6 × 6 in the order (ω, t): R = exp([ω]×) R̂, of rank 5; or None.
    translation: Translation
    mirrored: bool  # Whether the matches fit the mirror image of the second photograph; the result may be chance then.
    error_probability: float  # E and F: how likely R or t is off by more than 10°, learned on photographs; else NaN.
    focal_conflict: Optional[FocalConflict]  # E, unknown focal lengths: where the matches contradict K or the prior.
    share_behind: float  # E: of the matches that fit, the share behind a camera, which are no inliers.
    other_pose: Optional[Pose]  # Of matches on one plane: another motion that explains them as well; else None.

    @property
    def may_be_wrong(self) -> bool:
        """Whether results like this are wrong too often to rely on."""
        return self.may_be_chance or self.error_probability > 0.5 or self.focal_conflict is not None


@dataclass(frozen=True, eq=False)
class SharedFocalEstimate(TwoViewEstimate):
    """F of two views of unknown focal length. `pose_covariance` is None."""

    focal: Optional[Focal]
    K1: Floats  # Of these focal lengths; the identity unless the status is OK.
    K2: Floats


@dataclass(frozen=True, eq=False)
class AbsolutePoseEstimate(Estimate):
    """A world-to-camera pose."""

    pose: Pose  # As `model`; the identity unless the status is OK.
    pose_covariance: Optional[Floats]  # 6 × 6 in the order (ω, t), t in the scene's unit; or None.
    share_behind: float  # Of the points that fit, the share behind the camera, which are no inliers.
    other_pose: Optional[Pose]  # Of a plane, where the points do not say which of two poses is right; else None.

    @property
    def ambiguous(self) -> bool:
        return self.other_pose is not None


@dataclass(frozen=True, eq=False)
class RigidMotionEstimate(Estimate):
    """A motion between two clouds: points2 ≈ R points1 + t."""

    motion: Pose  # As `model`; the identity unless the status is OK.
    covariance: Optional[Floats]  # 6 × 6 in the order (ω, t), ω in the second cloud's frame, t as in `motion`; or None.
    other_motion: Optional[Pose]  # Of a symmetric thing: another motion, of other matches, that may be right; else None.

    @property
    def ambiguous(self) -> bool:
        return self.other_motion is not None


@dataclass(frozen=True, eq=False)
class SimilarityEstimate(Estimate):
    """A motion with a scale: points2 ≈ s R points1 + t."""

    scale: float  # s.
    motion: Pose  # R and t; the identity unless the status is OK.
    covariance: Optional[Floats]  # 7 × 7 in the order (ω, t, log s); or None.


@dataclass(frozen=True, eq=False)
class Estimates:
    """Several models of one kind in the same points, found without being told how many."""

    status: Status  # NO_MODEL: nothing that chance would not give.
    models: Floats  # M × the shape of one model, that of most points first.
    assignment: NDArray[np.int32]  # N: 0 for a point of none, k for one of models[k - 1].
    cost: Cost
    rows_left_out: int  # As Estimate's.
    repeated_rows: int

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
class VanishingPointsEstimate:
    """The vanishing points of an image, the surest first."""

    status: Status  # NO_MODEL: nothing that a person would call one.
    points: Floats  # M × 3: homogeneous pixels, of unit length.
    directions: Optional[Floats]  # M × 3: in the camera's frame; None where K is unknown.
    values: Optional[Floats]  # M: how sure the network is of each beside those before it; None without a network.
    assignment: NDArray[np.int32]  # N: 0 for a segment of none, k for one of points[k - 1].
    K: Optional[Floats]  # That was given, or of `focal`.
    focal: Optional[VanishingFocal]  # Found where no K was given.
    horizon: Optional[Horizon]
    cost: Cost
    rows_left_out: int  # As Estimate's.
    repeated_rows: int

    @property
    def ok(self) -> bool:
        return self.status is Status.OK
