#include "diffsac/geometry/parallax.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>

#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/robust_map.h"
#include "diffsac/geometry/some_rows.h"

namespace diffsac {
namespace {

/// The least noise, of the extent of the points, a tenth of a pixel in 2000: no calibration is more exact, and a
/// principal point that is half a pixel off would otherwise make parallax of a turn whose matches are exact.
constexpr double kLeastLength = 5e-5;

/// What the matches say of parallax, by their distances to a map and to epipolar lines.
class Evidence {
 public:
  /// parameters: of the model, which the inliers' distances to lines were made small by. least: of a noise. chance: how
  /// often chance may look like parallax.
  Evidence(const Eigen::VectorXd& to_map, const Eigen::VectorXd& to_lines, const std::vector<std::uint8_t>& inliers,
           int parameters, double least, double chance)
      : to_map_(to_map), to_lines_(to_lines) {
    double noise = 0.0, parallax = 0.0;
    int count = 0;
    for (Eigen::Index i = 0; i < to_map.size(); ++i) {
      if (inliers[i] == 0) continue;
      ++count;
      noise += to_lines[i] * to_lines[i];
      parallax += to_map[i] * to_map[i];
    }
    sigma_ = std::max(least, std::sqrt(noise / std::max(1, count - parameters)));
    // Of how many directions of t the matches could tell one.
    needed_ = -std::log(chance) + std::log(1.0 + std::numbers::pi * parallax / (sigma_ * sigma_));
  }

  bool IsParallax() const {
    double greatest = 0.0;
    for (const double share : kShares) greatest = std::max(greatest, LogRatio(share));
    return greatest - std::log(std::size(kShares)) > needed_;
  }

 private:
  /// Of the matches, that may have parallax.
  static constexpr double kShares[] = {1.0, 0.3, 0.1, 0.03};

  double LogRatio(double share) const {
    const double one = std::sqrt(0.5);
    double sum = 0.0;
    for (Eigen::Index i = 0; i < to_map_.size(); ++i) {
      if (!(to_map_[i] > sigma_)) continue;
      const double of_noise = 2.0 / std::numbers::pi * std::asin(sigma_ / to_map_[i]);
      const double of_parallax = std::erf(one) / std::erf(one * to_map_[i] / sigma_);
      const double ratio = to_lines_[i] <= sigma_ ? of_parallax / of_noise : (1.0 - of_parallax) / (1.0 - of_noise);
      sum += std::log(1.0 - share + share * ratio);
    }
    return sum;
  }

  const Eigen::VectorXd &to_map_, &to_lines_;
  double sigma_ = 0.0, needed_ = 0.0;
};

/// Whether the identity explains the inliers that the map explains as well as this does, but for its own parameters.
bool IsStatic(const PointMatrix& rows, const Eigen::Matrix3d& map, double least, double greatest) {
  // Far beyond χ² of three or eight parameters, which the choice of the inliers favours.
  constexpr double kMostDeviation = 30.0;
  const Eigen::VectorXd moved = MapDistances(map, rows, least, greatest);
  const Eigen::VectorXd still = MapDistances(Eigen::Matrix3d::Identity(), rows, least, greatest);
  const auto near = (moved.array() <= 3.0 * Median(moved)).cast<double>();
  const double of_map = (near * moved.array().square()).sum(), of_identity = (near * still.array().square()).sum();
  return of_identity <= of_map * (1.0 + kMostDeviation / (2.0 * near.sum()));
}

/// `fit` makes the map of what no translation would show, `without` says what that is.
ParallaxTest TestAll(const PointMatrix& points, const Matrix3Parameters& model,
                     const std::vector<std::uint8_t>& inliers, int parameters, MapFit fit, Translation without,
                     double chance) {
  ParallaxTest test;
  const PointMatrix rows = RowsOf(points, inliers);
  if (rows.rows() < 2 || !points.allFinite()) return test;
  const double greatest = Extent(points), least = kLeastLength * greatest;
  Eigen::Matrix3d map;
  if (!(greatest > 0.0) || !FitRobustly(rows, least, greatest, fit, &map)) return test;
  const Eigen::VectorXd to_map = MapDistances(map, points, least, greatest);
  const Eigen::VectorXd to_lines = RowResiduals<Fundamental>(points, model);
  test.translation = Translation::kDetermined;
  if (Evidence(to_map, to_lines, inliers, parameters, least, chance).IsParallax()) return test;
  test.translation = IsStatic(rows, map, least, greatest) ? Translation::kStatic : without;
  test.turn = map;
  return test;
}

/// Of many matches some are asked first: most parallax shows in them.
ParallaxTest Test(const PointMatrix& points, const Matrix3Parameters& model, const std::vector<std::uint8_t>& inliers,
                  int parameters, MapFit fit, Translation without) {
  constexpr double kChance = 0.01, kChanceOfSome = 1e-4;
  constexpr Eigen::Index kSome = 400;
  if (points.rows() > 2 * kSome) {
    const auto some = SomeRows(points.rows(), kSome);
    std::vector<std::uint8_t> own(some.size());
    for (Eigen::Index i = 0; i < some.size(); ++i) own[i] = inliers[some[i]];
    const ParallaxTest test = TestAll(points(some, Eigen::all), model, own, parameters, fit, without, kChanceOfSome);
    if (test.translation == Translation::kDetermined) return test;
  }
  return TestAll(points, model, inliers, parameters, fit, without, kChance);
}

}  // namespace

ParallaxTest TestTurn(const PointMatrix& points, const Matrix3Parameters& essential,
                      const std::vector<std::uint8_t>& inliers) {
  constexpr int kMotion = 5;
  return Test(points, essential, inliers, kMotion, FitRotation, Translation::kTurn);
}

ParallaxTest TestPlane(const PointMatrix& points, const Matrix3Parameters& fundamental,
                       const std::vector<std::uint8_t>& inliers) {
  constexpr int kFundamental = 7;
  ParallaxTest test = Test(points, fundamental, inliers, kFundamental, FitHomography, Translation::kPlane);
  test.turn.reset();
  return test;
}

bool FindFocalOfTurn(const PointMatrix& points, const std::vector<std::uint8_t>& inliers, bool first, bool second,
                     double* factor) {
  constexpr int kSteps = 16, kSections = 40;
  const double greatest = Extent(points), least = 1e-4 * kLeastLength * greatest;
  PointMatrix rows = SpreadRows(RowsOf(points, inliers));
  Eigen::Matrix3d map;
  if (!(greatest > 0.0) || !FitRobustly(rows, least, greatest, FitHomography, &map)) return false;
  // Whatever the focal length, a turn is this homography.
  const Eigen::VectorXd to_map = MapDistances(map, rows, least, greatest);
  const double reach = 3.0 * Median(to_map);
  std::vector<std::uint8_t> near;
  for (const double distance : to_map) near.push_back(distance <= reach);
  rows = RowsOf(rows, near);
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(rows.rows());
  const auto distance = [&](double octaves) {
    const double by = std::exp2(octaves);
    PointMatrix scaled = rows;
    if (first) scaled.leftCols(2) /= by;
    if (second) scaled.rightCols(2) /= by;
    Eigen::Matrix3d turn;
    if (!FitRotation(scaled, ones, &turn)) return greatest;
    return MapDistances(turn, scaled, least, greatest).norm() * (second ? by : 1.0);
  };
  double best = 0.0, smallest = std::numeric_limits<double>::infinity();
  const double step = 4.0 / kSteps;
  for (int i = 0; i <= kSteps; ++i) {
    const double found = distance(i * step - 2.0);
    if (!(found < smallest)) continue;
    smallest = found;
    best = i * step - 2.0;
  }
  // Golden sections (Kiefer 1953).
  const double golden = 1.0 / std::numbers::phi;
  double low = best - step, high = best + step;
  for (int i = 0; i < kSections; ++i) {
    const double below = high - golden * (high - low), above = low + golden * (high - low);
    if (distance(below) < distance(above)) {
      high = above;
    } else {
      low = below;
    }
  }
  *factor = std::exp2(0.5 * (low + high));
  return true;
}

std::vector<std::uint8_t> BesideLine(const PointMatrix& points, int column, const std::vector<std::uint8_t>& inliers,
                                     double reach) {
  constexpr int kRounds = 10;
  // Of the greatest coordinate: what is written in single precision lies on no line more exactly.
  constexpr double kRounding = 1e-6;
  const auto image = points.middleCols(column, 2);
  const double least = std::max(reach, kRounding * image.cwiseAbs().maxCoeff());
  const Eigen::MatrixX2d rows = SpreadRows(RowsOf(points, inliers)).middleCols(column, 2);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(rows.rows());
  Eigen::RowVector2d centre;
  Eigen::Vector2d normal;
  for (int round = 0; round < kRounds; ++round) {
    centre = weights.transpose() * rows / weights.sum();
    const Eigen::MatrixX2d about = rows.rowwise() - centre;
    const Eigen::Matrix2d spread = about.transpose() * weights.asDiagonal() * about;
    normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread).eigenvectors().col(0);
    weights = (about * normal).cwiseAbs().cwiseMax(least).cwiseInverse();
  }
  const Eigen::VectorXd distances = ((image.rowwise() - centre) * normal).cwiseAbs();
  std::vector<std::uint8_t> beside(points.rows());
  for (std::size_t i = 0; i < beside.size(); ++i) beside[i] = distances[static_cast<Eigen::Index>(i)] > least;
  return beside;
}

}  // namespace diffsac
