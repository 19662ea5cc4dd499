#include "diffsac/geometry/parallax.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/robust_map.h"
#include "diffsac/geometry/some_rows.h"
#include "diffsac/geometry/svd3.h"

namespace diffsac {
namespace {

/// The least noise, of the extent of the points, a tenth of a pixel in 2000: no calibration is more exact, and a
/// principal point that is half a pixel off would otherwise make parallax of a turn whose matches are exact.
constexpr double kLeastLength = 5e-5;

/// Compares parallax with its absence, by the matches' distances to a map and to epipolar lines.
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

  double sigma() const { return sigma_; }

  bool IsParallax() const {
    double sum = 0.0;
    for (const auto& [octave, rows] : Octaves(sigma_)) {
      const std::vector<double> ratios = RatiosOf(rows);
      const double share = ShareOf(ratios);
      double log = 0.0;
      for (const double ratio : ratios) log += std::log(1.0 - share + share * ratio);
      sum += std::max(0.0, log - kFreedom);
    }
    return sum > needed_;
  }

  /// The same where most matches are noise about the map: what is left of them, compression's errors or another window
  /// of a façade, may prefer the lines' direction, but only parallax prefers one sense of it (`along`, N values).
  /// exact: keypoints of one place or size may all be off by so much, to one side.
  bool IsOneSided(const Eigen::VectorXd& along, double exact) const {
    double sums[2] = {0.0, 0.0};
    for (const auto& [octave, rows] : Octaves(exact)) {
      const std::vector<double> ratios = RatiosOf(rows);
      const double share = ShareOf(ratios);
      double counts[2] = {0.0, 0.0};
      for (std::size_t i = 0; i < rows.size(); ++i)
        counts[along[rows[i]] > 0.0 ? 0 : 1] += share * ratios[i] / (1.0 - share + share * ratios[i]);
      const double all = counts[0] + counts[1];
      double log = 0.0;
      for (const double count : counts)
        if (count > 0.0) log += count * std::log(2.0 * count / all);
      sums[counts[0] > counts[1] ? 0 : 1] += std::max(0.0, log - kFreedom);
    }
    return std::max(sums[0], sums[1]) - std::log(2.0) > needed_;
  }

 private:
  using Rows = std::vector<Eigen::Index>;

  static constexpr double kFreedom = 1.0;  ///< What the best share of an octave explains by chance.

  /// Matches by the octave of their distance to the map. Wrong ones lie anywhere, right ones as far as their parallax.
  std::map<int, Rows> Octaves(double least) const {
    std::map<int, Rows> octaves;
    for (Eigen::Index i = 0; i < to_map_.size(); ++i)
      if (to_map_[i] > std::max(least, sigma_)) octaves[std::ilogb(to_map_[i] / sigma_)].push_back(i);
    return octaves;
  }

  /// How much likelier the distance to the line is if it is noise than if it is that of any direction, in steps of σ.
  double Ratio(Eigen::Index i) const {
    constexpr double kSteps[] = {0.5, 1.0, 2.0, 3.0};
    constexpr double kTail = 0.02;  // Of right matches, farther than noise goes.
    const double reach = to_map_[i] / sigma_, root = std::sqrt(0.5);
    double low = 0.0, high = reach;
    for (const double step : kSteps) {
      if (step >= reach) break;
      if (to_lines_[i] <= step * sigma_) {
        high = step;
        break;
      }
      low = step;
    }
    const double any = 2.0 / std::numbers::pi * (std::asin(std::min(1.0, high / reach)) - std::asin(low / reach));
    const double noise = (std::erf(root * high) - std::erf(root * low)) / std::erf(root * reach);
    return (1.0 - kTail) * noise / any + kTail;
  }

  std::vector<double> RatiosOf(const Rows& rows) const {
    std::vector<double> ratios;
    for (const Eigen::Index i : rows) ratios.push_back(Ratio(i));
    return ratios;
  }

  /// The likeliest share of matches that have parallax (expectation maximisation).
  static double ShareOf(const std::vector<double>& ratios) {
    constexpr int kRounds = 30;
    double share = 0.5;
    for (int round = 0; round < kRounds; ++round) {
      double sum = 0.0;
      for (const double ratio : ratios) sum += share * ratio / (1.0 - share + share * ratio);
      share = sum / static_cast<double>(ratios.size());
    }
    return share;
  }

  const Eigen::VectorXd &to_map_, &to_lines_;
  double sigma_ = 0.0, needed_ = 0.0;
};

/// Whether the identity explains the inliers about as well as the map, which has `freedom` parameters, and leaves them
/// no more than noise of `sigma`.
bool IsStatic(const PointMatrix& rows, const Eigen::Matrix3d& map, int freedom, double sigma, double least,
              double greatest) {
  // Far beyond χ², which the choice of the inliers favours; and half of the noise is no motion.
  constexpr double kMostDeviation = 10.0, kLeastShare = 0.25, kMostNoise = 8.0;
  const Eigen::VectorXd moved = MapDistances(map, rows, least, greatest);
  const Eigen::VectorXd still = MapDistances(Eigen::Matrix3d::Identity(), rows, least, greatest);
  if (Median(still) > kMostNoise * sigma) return false;
  const auto near = (moved.array() <= 3.0 * Median(moved)).cast<double>();
  const double of_map = (near * moved.array().square()).sum(), of_identity = (near * still.array().square()).sum();
  return of_identity <= of_map * (1.0 + std::max(kLeastShare, kMostDeviation * freedom / (2.0 * near.sum())));
}

/// Keypoints of photographs are as exact, of the extent of the points: a pixel in 1600. Their errors go together.
constexpr double kExact = 6e-4;

/// Whether a share of these matches, `most`, is as near to the map as keypoints are exact.
bool Dominates(const Eigen::Matrix3d& map, const PointMatrix& rows, double most, double least, double greatest) {
  const auto near = (MapDistances(map, rows, least, greatest).array() <= kExact * greatest).count();
  return static_cast<double>(near) >= most * static_cast<double>(rows.rows());
}

/// How far each match is from the map in the direction of the epipole of the model.
Eigen::VectorXd TowardsEpipole(const Eigen::Matrix3d& map, const PointMatrix& points, const Matrix3Parameters& model) {
  const Eigen::Vector3d epipole = ComputeRotationSvd3(AsMatrix(model)).u.col(2);
  Eigen::VectorXd along(points.rows());
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Eigen::Vector2d y = (map * Eigen::Vector3d(points(i, 0), points(i, 1), 1.0)).hnormalized();
    along[i] = (points.row(i).tail<2>().transpose() - y).dot(epipole.head<2>() - epipole[2] * y);
  }
  return along;
}

/// What a test compares with epipolar geometry of so many `parameters`: the map that `fit` makes, of `freedom` ones. It
/// is all that there is without a translation, or else that of a plane.
struct Compared {
  int parameters, freedom;
  MapFit fit;
  Degeneracy without;
  double chance;  ///< How often parallax may be found of none; bounds are not sharp, of planes least.
};

ParallaxTest TestAll(const PointMatrix& points, const Matrix3Parameters& model,
                     const std::vector<std::uint8_t>& inliers, const Compared& compared, double chance) {
  ParallaxTest test;
  const PointMatrix rows = RowsOf(points, inliers);
  if (rows.rows() < 2 || !points.allFinite()) return test;
  const double greatest = Extent(points), least = kLeastLength * greatest;
  Eigen::Matrix3d map;
  if (!(greatest > 0.0) || !FitRobustly(rows, least, greatest, compared.fit, &map)) return test;
  const Eigen::VectorXd to_lines = RowResiduals<Fundamental>(points, model);
  test.degeneracy = Degeneracy::kDetermined;
  const Eigen::Matrix3d still = Eigen::Matrix3d::Identity();
  constexpr double kMost = 0.75, kAll = 0.9;
  const bool is_still = Dominates(still, rows, kMost, least, greatest);
  const Eigen::VectorXd to_map = MapDistances(map, points, least, greatest);
  const Evidence found(to_map, to_lines, inliers, compared.parameters, least, chance);
  const bool sided =
      is_still || (compared.without == Degeneracy::kPureRotation && Dominates(map, rows, kMost, least, greatest));
  // Without a calibration a few matches have an epipole whatever they are.
  const bool is_again = compared.without == Degeneracy::kPlane && Dominates(still, rows, kAll, least, greatest);
  if (!is_again &&
      (sided ? found.IsOneSided(TowardsEpipole(map, points, model), kExact * greatest) : found.IsParallax()))
    return test;
  const bool is_static = is_still || IsStatic(rows, map, compared.freedom, found.sigma(), least, greatest);
  test.degeneracy = is_static ? Degeneracy::kStatic : compared.without;
  test.pure_rotation = is_static ? still : map;
  return test;
}

/// Of many matches some are asked first: most parallax shows in them.
ParallaxTest Test(const PointMatrix& points, const Matrix3Parameters& model, const std::vector<std::uint8_t>& inliers,
                  const Compared& compared) {
  constexpr double kChanceOfSome = 1e-4;
  constexpr Eigen::Index kSome = 400;
  if (points.rows() > 2 * kSome) {
    const auto some = SomeRows(points.rows(), kSome);
    std::vector<std::uint8_t> own(some.size());
    for (Eigen::Index i = 0; i < some.size(); ++i) own[i] = inliers[some[i]];
    const ParallaxTest test = TestAll(points(some, Eigen::all), model, own, compared, kChanceOfSome);
    if (test.degeneracy == Degeneracy::kDetermined) return test;
  }
  return TestAll(points, model, inliers, compared, compared.chance);
}

}  // namespace

ParallaxTest TestTurn(const PointMatrix& points, const Matrix3Parameters& essential,
                      const std::vector<std::uint8_t>& inliers) {
  return Test(points, essential, inliers, {5, 3, FitRotation, Degeneracy::kPureRotation, 0.003});
}

ParallaxTest TestPlane(const PointMatrix& points, const Matrix3Parameters& fundamental,
                       const std::vector<std::uint8_t>& inliers) {
  ParallaxTest test = Test(points, fundamental, inliers, {7, 8, FitHomography, Degeneracy::kPlane, 0.1});
  test.pure_rotation.reset();
  return test;
}

namespace {

/// The x in [low, high] where a function of one minimum is smallest: a grid, then golden sections (Kiefer 1953).
template <class Function>
double Minimize(double low, double high, int steps, int sections, const Function& function) {
  const double step = (high - low) / steps;
  double best = low, smallest = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= steps; ++i) {
    const double found = function(low + i * step);
    if (!(found < smallest)) continue;
    smallest = found;
    best = low + i * step;
  }
  const double golden = 1.0 / std::numbers::phi;
  low = best - step;
  high = best + step;
  for (int i = 0; i < sections; ++i) {
    const double below = high - golden * (high - low), above = low + golden * (high - low);
    const bool is_below = function(below) < function(above);
    (is_below ? high : low) = is_below ? above : below;
  }
  return 0.5 * (low + high);
}

}  // namespace

bool FindFocalsOfTurn(const PointMatrix& points, const std::vector<std::uint8_t>& inliers, TurnFocals unknown,
                      Eigen::Vector2d* factors) {
  constexpr double kOctaves = 2.0;
  constexpr int kSteps = 16, kSections = 25, kRounds = 3;
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
  const auto distance = [&](const Eigen::Vector2d& octaves) {
    PointMatrix scaled = rows;
    scaled.leftCols(2) /= std::exp2(octaves[0]);
    scaled.rightCols(2) /= std::exp2(octaves[1]);
    Eigen::Matrix3d turn;
    if (!FitRotation(scaled, ones, &turn)) return greatest;
    return MapDistances(turn, scaled, least, greatest).norm() * std::exp2(octaves[1]);
  };
  Eigen::Vector2d octaves = Eigen::Vector2d::Zero();
  const auto search = [&](const Eigen::Vector2d& along) {
    octaves += along * Minimize(-kOctaves, kOctaves, kSteps, kSections,
                                [&](double by) { return distance(octaves + by * along); });
  };
  const Eigen::Vector2d both(1.0, 1.0), first(1.0, 0.0), second(0.0, 1.0);
  if (unknown == TurnFocals::kBothAlike) search(both);
  if (unknown == TurnFocals::kFirst) search(first);
  if (unknown == TurnFocals::kSecond) search(second);
  for (int round = 0; round < kRounds && unknown == TurnFocals::kEach; ++round) {
    search(second);
    search(both);
  }
  *factors = Eigen::Vector2d(std::exp2(octaves[0]), std::exp2(octaves[1]));
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
