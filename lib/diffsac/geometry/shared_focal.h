#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "diffsac/geometry/epipolar.h"
#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/focal_posterior.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/model.h"
#include "diffsac/geometry/six_points.h"
#include "diffsac/geometry/square_bounds.h"

namespace diffsac {

/// What keeps f in reach during a search, where points say little of it.
inline constexpr FocalPriors kAnyCamera{{{1.0, 0.6}, {1.0, 0.6}}};

/// Bounds of Sampson distances to the F of E and the focal lengths.
struct FocalBounds : SampsonBounds {
  using SampsonBounds::SampsonBounds;
  bool Prepare(const FocalParameters& model, double threshold, Prepared* out) const {
    return SquareBounds::Prepare(FundamentalOf(model), threshold, out);
  }
};

/// Epipolar geometry of two cameras with unknown focal lengths (UnknownFocal says whose, and in which coordinates).
/// Parameters are E, row-major, of unit Frobenius norm, and the focal lengths in the unit of each image's points.
/// Choose that unit near the likeliest focal length: the prior's median is f = 1 wherever none is given.
template <UnknownFocal kUnknown>
struct FocalModel {
  using Parameters = FocalParameters;
  using Bounds = FocalBounds;  ///< Of `Residual`.
  static constexpr int kDimension = 4;
  static constexpr int kMinimalSize = 5 + CountFocals(kUnknown);
  /// Focal lengths, as shares of the unit, with which the set's first five points are solved as well.
  static constexpr double kAssumed[] = {1.0};
  static constexpr int kOfAllPoints =
      kUnknown == UnknownFocal::kEach ? Fundamental::kMaxSolutions : MaxSixPointSolutions(kUnknown);
  static constexpr int kMaxSolutions = kOfAllPoints + Essential::kMaxSolutions * static_cast<int>(std::size(kAssumed));
  /// Of a Sampson distance, for MAGSAC++.
  static constexpr int kResidualDof = 1;

  /// The 6-point solutions (SolveSixPoints), or with a length for each image the 7-point solutions with the lengths
  /// that F says (FocalsOfFundamental); and the 5-point solutions with an assumed focal length: where the motion does
  /// not show f, or all points lie on a plane, six points say nothing, or anything, and these are as good as any.
  /// Solutions against the oriented epipolar constraint, or with points behind a camera, are left out.
  static int SolveMinimal(const PointMatrix& points, const int* set, Parameters* out);

  /// Weighted normalised 8-point algorithm, then the focal lengths with which F makes a matrix nearest to an essential
  /// one, then FitFrom; needs 8 points of positive weight.
  static bool Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out);

  /// Weighted least squares of Sampson distances over E and f, from *model, by Levenberg-Marquardt, with the priors'
  /// share (RefineFocal); without any, kAnyCamera. False, leaving *model, with fewer points of positive weight than a
  /// minimal set has or unfit ones.
  static bool FitFrom(const PointMatrix& points, const Eigen::VectorXd& weights, const FocalPriors& priors,
                      Parameters* model);
  static bool FitFrom(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* model) {
    return FitFrom(points, weights, kAnyCamera, model);
  }

  /// Finite, kMinimalSize distinct correspondences, in neither image all on one line.
  static bool Determined(const PointMatrix& points) { return DeterminesTwoViews(points, kMinimalSize); }

  /// As `Residual`, over 4 columns, bit for bit.
  static void Residuals(const Parameters& model, const double* const* columns, int begin, int end, double* out) {
    SampsonDistances(FundamentalOf(model).data(), columns, begin, end, out);
  }

  /// Sampson distance, linear, in the unit of the points.
  static double Residual(const Parameters& model, const double* point) {
    return SampsonError(FundamentalOf(model), point);
  }

  /// The same with any loss. False, leaving *model, when nothing changes or the points are unfit.
  static bool Refine(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                     const FocalPriors& priors, Parameters* model, int steps = kMostRefineSteps);
  static bool Refine(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                     Parameters* model, int steps = kMostRefineSteps) {
    return Refine(points, weights, loss, kAnyCamera, model, steps);
  }

  /// The square of log f less that of K2's; with a length for each image, and K1's.
  static double CameraMismatch(const Parameters& model, const Eigen::Matrix3d& K1, const Eigen::Matrix3d& K2);

  /// MarginaliseFocal of this model.
  static bool Marginalise(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                          const FocalPriors& priors, Parameters* model, FocalPosteriors* out) {
    return MarginaliseFocal(kUnknown, points, weights, loss, priors, model, out);
  }
};

/// One unknown focal length in both images.
using SharedFocal = FocalModel<UnknownFocal::kBoth>;
/// The first camera is calibrated, the focal length of the second is unknown.
using OneFocal = FocalModel<UnknownFocal::kSecond>;
/// An unknown focal length in each image.
using TwoFocals = FocalModel<UnknownFocal::kEach>;

/// The focal lengths of the first and of the second image with which F makes an essential matrix (Bougnoux, "From
/// projective to Euclidean space under any practical situation", ICCV 1998), in the unit of points whose origin is the
/// principal point. False where a square is negative or none (axes that meet leave them open), or a length is not
/// within kGreatestFocal and its inverse.
bool FocalsOfFundamental(const Matrix3Parameters& fundamental, double* focal1, double* focal2);

}  // namespace diffsac
