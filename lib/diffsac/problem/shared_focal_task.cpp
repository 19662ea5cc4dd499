#include "diffsac/problem/shared_focal_task.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "diffsac/geometry/calibration.h"

namespace diffsac {
namespace {

/// A focal length that is known as well as this, in log f, is that of a turn too, within three times as much.
constexpr double kKnownSigma = 0.01;

struct ImageOf {
  const CameraPriorHint& hint;
  const ImageSize& size;
};

ImageOf First(const Problem& problem) { return {problem.camera_prior1, problem.size1}; }
ImageOf Second(const Problem& problem) { return {problem.camera_prior2, problem.size2}; }

std::optional<Eigen::Vector2d> PrincipalPoint(const ImageOf& image) {
  if (image.hint.principal_point) return image.hint.principal_point;
  if (!image.size.known()) return std::nullopt;
  return Eigen::Vector2d(0.5 * (image.size.width - 1), 0.5 * (image.size.height - 1));
}

/// In pixels; a width of 0 where it is that of cameras in general.
std::optional<FocalPrior> PriorOf(const ImageOf& image) {
  if (image.hint.focal) return image.hint.focal;
  if (!image.size.known()) return std::nullopt;
  return FocalPrior{kMedianFocal * std::max(image.size.width, image.size.height), 0.0};
}

/// What two images of one camera say of it. They are not independent, so that one is no surer than the surer of both.
FocalPrior Pooled(const FocalPrior& a, const FocalPrior& b) {
  if (a.log_sigma != b.log_sigma && std::min(a.log_sigma, b.log_sigma) == 0.0) return a.log_sigma > 0.0 ? a : b;
  const double share = a.log_sigma == b.log_sigma
                           ? 0.5
                           : std::pow(b.log_sigma, 2) / (std::pow(a.log_sigma, 2) + std::pow(b.log_sigma, 2));
  return {std::exp(share * std::log(a.focal) + (1.0 - share) * std::log(b.focal)), std::min(a.log_sigma, b.log_sigma)};
}

Eigen::Matrix3d FromPixels(const Eigen::Vector2d& principal_point, double unit) {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity() / unit;
  matrix.col(2) << -principal_point / unit, 1.0;
  return matrix;
}

std::optional<FocalSpace> SharedSpace(const Problem& problem) {
  const auto point1 = PrincipalPoint(First(problem)), point2 = PrincipalPoint(Second(problem));
  const auto prior1 = PriorOf(First(problem)), prior2 = PriorOf(Second(problem));
  if (!point1 || !point2 || (!prior1 && !prior2)) return std::nullopt;
  const FocalPrior prior = Pooled(prior1 ? *prior1 : *prior2, prior2 ? *prior2 : *prior1);
  return FocalSpace{FromPixels(*point1, prior.focal),
                    FromPixels(*point2, prior.focal),
                    false,
                    {prior.focal, prior.focal},
                    {prior.log_sigma, prior.log_sigma}};
}

std::optional<FocalSpace> SpaceOfTwo(const Problem& problem) {
  const auto point1 = PrincipalPoint(First(problem)), point2 = PrincipalPoint(Second(problem));
  const auto prior1 = PriorOf(First(problem)), prior2 = PriorOf(Second(problem));
  if (!point1 || !point2 || !prior1 || !prior2) return std::nullopt;
  return FocalSpace{FromPixels(*point1, prior1->focal),
                    FromPixels(*point2, prior2->focal),
                    false,
                    {prior1->focal, prior2->focal},
                    {prior1->log_sigma, prior2->log_sigma}};
}

std::optional<FocalSpace> OneSpace(const Problem& problem) {
  const bool swapped = !problem.camera_prior1.K && problem.camera_prior2.K;
  const ImageOf known = swapped ? Second(problem) : First(problem),
                unknown = swapped ? First(problem) : Second(problem);
  const auto point = PrincipalPoint(unknown);
  const auto prior = PriorOf(unknown);
  if (!known.hint.K || !IsCalibration(*known.hint.K) || !point || !prior) return std::nullopt;
  return FocalSpace{known.hint.K->inverse(),
                    FromPixels(*point, prior->focal),
                    swapped,
                    {FocalOf(*known.hint.K), prior->focal},
                    {0.0, prior->log_sigma}};
}

PointMatrix Swapped(const PointMatrix& points) {
  PointMatrix swapped(points.rows(), 4);
  swapped << points.rightCols(2), points.leftCols(2);
  return swapped;
}

}  // namespace

std::optional<FocalSpace> FocalSpaceOf(UnknownFocal unknown, const Problem& problem) {
  const auto space = unknown == UnknownFocal::kBoth     ? SharedSpace(problem)
                     : unknown == UnknownFocal::kSecond ? OneSpace(problem)
                                                        : SpaceOfTwo(problem);
  if (!space || !space->first.allFinite() || !space->second.allFinite()) return std::nullopt;
  for (int k = 0; k < 2; ++k)
    if (!(space->unit[k] > 0.0) || !std::isfinite(space->unit[k]) || !(space->log_sigma[k] >= 0.0) ||
        !std::isfinite(space->log_sigma[k]))
      return std::nullopt;
  return space;
}

PointMatrix NormalizeFocal(UnknownFocal unknown, const Problem& problem, double* unit) {
  const FocalSpace space = FocalSpaceOf(unknown, problem).value();
  // What an error of a pixel is in either image, on the mean.
  *unit = 0.5 * (space.unit[0] + space.unit[1]);
  return NormalizedCoordinates(space.swapped ? Swapped(problem.points) : problem.points, space.first.inverse(),
                               space.second.inverse());
}

CameraPair CamerasOfFocal(UnknownFocal unknown, const FocalParameters& model, const Problem& problem) {
  const FocalSpace space = FocalSpaceOf(unknown, problem).value();
  const auto scaled = [](double focal) { return Eigen::DiagonalMatrix<double, 3>(focal, focal, 1.0); };
  CameraPair cameras{space.first.inverse() * scaled(model[9]), space.second.inverse() * scaled(model[10])};
  if (space.swapped) std::swap(cameras.K1, cameras.K2);
  return cameras;
}

Eigen::Matrix3d EssentialOfFocal(UnknownFocal unknown, const FocalParameters& model, const Problem& problem) {
  const Eigen::Matrix3d essential = AsMatrix(model.head<9>());
  return FocalSpaceOf(unknown, problem).value().swapped ? Eigen::Matrix3d(essential.transpose()) : essential;
}

/// F cannot tell a turn from a plane. Where the matches are those of either, a turn by the model's focal length is
/// tried, and then, unless that is known, by the one with which it explains them best: what E and f were fitted to is a
/// turn's noise.
ParallaxTest FocalParallax(UnknownFocal unknown, const FocalParameters& model, const std::vector<std::uint8_t>& inliers,
                           const Problem& problem) {
  CameraPair cameras = CamerasOfFocal(unknown, model, problem);
  const Eigen::Matrix3d essential = EssentialOfFocal(unknown, model, problem),
                        f = FundamentalFromEssential(essential, cameras.K1, cameras.K2);
  const Degeneracy of_pixels = TestPlane(problem.points, AsParameters(f), inliers).degeneracy;
  if (of_pixels == Degeneracy::kDetermined) return {of_pixels};
  if (of_pixels == Degeneracy::kStatic) return {of_pixels, Eigen::Matrix3d::Identity()};
  const PointMatrix points = CalibratedMatches(problem, cameras);
  const ParallaxTest test = TestTurn(points, AsParameters(essential), inliers);
  if (test.degeneracy != Degeneracy::kDetermined) return test;
  const FocalSpace space = FocalSpaceOf(unknown, problem).value();
  const bool both = unknown != UnknownFocal::kSecond;
  const TurnFocals turning = unknown == UnknownFocal::kEach ? TurnFocals::kEach
                             : both                         ? TurnFocals::kBothAlike
                             : space.swapped                ? TurnFocals::kFirst
                                                            : TurnFocals::kSecond;
  Eigen::Vector2d factors;
  if (!FindFocalsOfTurn(points, inliers, turning, &factors)) return test;
  for (int k = both ? 0 : 1; k < 2; ++k) {
    const double factor = factors[space.swapped ? 1 - k : k];
    // 0: nothing is known of it.
    const bool known = space.log_sigma[k] > 0.0 && space.log_sigma[k] <= kKnownSigma;
    if (known && std::abs(std::log(factor * model[9 + k])) > 3.0 * kKnownSigma) return test;
  }
  cameras.K1 = cameras.K1 * Eigen::DiagonalMatrix<double, 3>(factors[0], factors[0], 1.0);
  cameras.K2 = cameras.K2 * Eigen::DiagonalMatrix<double, 3>(factors[1], factors[1], 1.0);
  const ParallaxTest turned = TestTurn(CalibratedMatches(problem, cameras),
                                       AsParameters(EssentialFromFundamental(f, cameras.K1, cameras.K2)), inliers);
  return IsUndetermined(turned.degeneracy) ? turned : test;
}

FocalEstimate FocalInPixels(UnknownFocal unknown, const FocalPosteriors& posteriors, const Problem& problem) {
  const FocalSpace space = FocalSpaceOf(unknown, problem).value();
  FocalEstimate estimate;
  for (int k = 0; k < 2; ++k) {
    const int image = space.swapped ? 1 - k : k;
    estimate.focal_px[image] = space.unit[k] * posteriors[k].focal;
    estimate.low_px[image] = space.unit[k] * posteriors[k].low;
    estimate.high_px[image] = space.unit[k] * posteriors[k].high;
    estimate.observable[image] = posteriors[k].observable;
    estimate.prior_focal_px[image] = space.unit[k] * posteriors[k].prior.focal;
    estimate.prior_log_sigma[image] = posteriors[k].prior.log_sigma;
    estimate.log_correlation = posteriors[k].correlation;
  }
  return estimate;
}

}  // namespace diffsac
