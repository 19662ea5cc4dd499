#pragma once

#include "diffsac/geometry/shared_focal.h"
#include "diffsac/problem/epipolar_task.h"

namespace diffsac {

template <>
inline constexpr const char* kModelName<SharedFocal> = "shared_focal";
template <>
inline constexpr const char* kModelName<OneFocal> = "one_focal";
template <>
inline constexpr const char* kModelName<TwoFocals> = "two_focals";

/// The mean of the two of a calibration, in pixels.
inline double FocalOf(const Eigen::Matrix3d& K) { return 0.5 * (K(0, 0) + K(1, 1)); }

/// The focal length that features and F's likely camera take where the calibration is unknown, in longer sides.
inline constexpr double kUsualFocal = 1.2;

/// The coordinates in which a problem without calibration is solved, and what is known of its focal lengths there.
struct FocalSpace {
  /// From pixels of each image to the solver's coordinates. The second one's is of unknown focal length.
  Eigen::Matrix3d first = Eigen::Matrix3d::Identity(), second = Eigen::Matrix3d::Identity();
  /// The images have changed places: it is the problem's first that is of unknown focal length.
  bool swapped = false;
  /// Of the solver's images: pixels in one unit, which is the prior's median where the focal length is unknown.
  std::array<double, 2> unit = {1.0, 1.0};
  std::array<double, 2> log_sigma = {};  ///< Of the prior; 0: that of cameras in general.
};

/// Nothing where a principal point, or the calibration that task one_focal needs, is unknown or makes no sense.
std::optional<FocalSpace> FocalSpaceOf(UnknownFocal unknown, const Problem& problem);

// The members of FocalTask, for either.
PointMatrix NormalizeFocal(UnknownFocal unknown, const Problem& problem, double* unit);
CameraPair CamerasOfFocal(UnknownFocal unknown, const FocalParameters& model, const Problem& problem);
Eigen::Matrix3d EssentialOfFocal(UnknownFocal unknown, const FocalParameters& model, const Problem& problem);
ParallaxTest FocalParallax(UnknownFocal unknown, const FocalParameters& model, const std::vector<std::uint8_t>& inliers,
                           const Problem& problem);
/// The matches in K⁻¹ x of the cameras that the model says.
inline PointMatrix CalibratedMatches(const Problem& problem, const CameraPair& cameras) {
  return NormalizedCoordinates(problem.points, cameras.K1, cameras.K2);
}
FocalEstimate FocalInPixels(UnknownFocal unknown, const FocalPosteriors& posteriors, const Problem& problem);

/// Two views of unknown focal length, one for both images, that of one of them, or two, with known principal points
/// (CameraPriorHint; the images' centres where none is given). The problem has no calibration.
template <UnknownFocal kUnknown>
struct FocalTask : TwoViewTask<FocalModel<kUnknown>> {
  static constexpr UnknownFocal kUnknownFocal = kUnknown;
  /// Principal points, or the images' sizes; for one_focal the calibration of one image as well.
  static bool Accepts(const Problem& problem) { return FocalSpaceOf(kUnknown, problem).has_value(); }
  static PointMatrix Normalize(const Problem& problem, double* unit) { return NormalizeFocal(kUnknown, problem, unit); }
  /// The priors in the solver's coordinates, with `log_sigma` where the problem has none of its own.
  static FocalPriors PriorsOf(const Problem& problem, double log_sigma) {
    const FocalSpace space = FocalSpaceOf(kUnknown, problem).value_or(FocalSpace{});
    const auto prior = [&](double own) { return FocalPrior{1.0, own > 0.0 ? own : log_sigma}; };
    return {kUnknown == UnknownFocal::kSecond ? FocalPrior{1.0, 0.0} : prior(space.log_sigma[0]),
            prior(space.log_sigma[1])};
  }
  static FocalEstimate InPixels(const FocalPosteriors& posteriors, const Problem& problem) {
    return FocalInPixels(kUnknown, posteriors, problem);
  }
  /// E and the calibrations that the model says.
  static CameraPair CamerasOf(const ModelParameters& model, const Problem& problem) {
    return CamerasOfFocal(kUnknown, FocalParameters(model), problem);
  }
  static Eigen::Matrix3d EssentialOf(const ModelParameters& model, const Problem& problem) {
    return EssentialOfFocal(kUnknown, FocalParameters(model), problem);
  }
  static Matrix3Parameters PixelModel(const ModelParameters& model, const Problem& problem) {
    const CameraPair cameras = CamerasOf(model, problem);
    return AsParameters(FundamentalFromEssential(EssentialOf(model, problem), cameras.K1, cameras.K2));
  }
  static double PixelResidual(const Matrix3Parameters& model, const double* point) {
    return SampsonError(model, point);
  }
  static std::optional<RigidMotion> Pose(const ModelParameters& model, const std::vector<std::uint8_t>& inliers,
                                         const NormalizedProblem& space) {
    const Problem& problem = space.problem();
    const CameraPair cameras = CamerasOf(model, problem);
    return EpipolarPose(EssentialOf(model, problem), CalibratedMatches(problem, cameras), inliers,
                        problem.inlier_threshold / cameras.MeanFocal());
  }
  static ParallaxTest Parallax(const ModelParameters& model, const std::vector<std::uint8_t>& inliers,
                               const NormalizedProblem& space) {
    return FocalParallax(kUnknown, model, inliers, space.problem());
  }
  static double LeaveOutBehind(const ModelParameters& model, const RigidMotion& pose, const NormalizedProblem& space,
                               double threshold, std::vector<std::uint8_t>* inliers) {
    const CameraPair cameras = CamerasOf(model, space.problem());
    return diffsac::LeaveOutBehind(pose, CalibratedMatches(space.problem(), cameras),
                                   threshold * space.unit() / cameras.MeanFocal(), inliers);
  }
  static double ChanceShare(const Problem& problem, double threshold) {
    return EpipolarChanceShare(problem, threshold);
  }
};

using SharedFocalTask = FocalTask<UnknownFocal::kBoth>;
using OneFocalTask = FocalTask<UnknownFocal::kSecond>;
using TwoFocalsTask = FocalTask<UnknownFocal::kEach>;

}  // namespace diffsac
