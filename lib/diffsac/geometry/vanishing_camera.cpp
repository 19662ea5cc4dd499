#include "diffsac/geometry/vanishing_camera.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace diffsac {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kAngleSigma = kAngleSigmaDeg * kDegree;
/// Directions are orthogonal, or horizontal, within this angle.
const double kOrthogonalSine = std::sin(5.0 * kDegree);
/// Horizontal directions that are nearer to each other do not say which plane they are in.
const double kApartSine = std::sin(10.0 * kDegree);
/// Of a camera that is upright within 45°.
const double kUprightCosine = std::cos(45.0 * kDegree);

Eigen::Matrix3d CameraMatrix(double focal, const Eigen::Vector2d& c) {
  Eigen::Matrix3d K = Eigen::Vector3d(focal, focal, 1.0).asDiagonal();
  K.topRightCorner<2, 1>() = c;
  return K;
}

std::vector<Eigen::Vector3d> DirectionsOf(const std::vector<Eigen::Vector3d>& points, const Eigen::Matrix3d& K) {
  std::vector<Eigen::Vector3d> directions;
  for (const Eigen::Vector3d& point : points) directions.push_back(DirectionOf(point, K));
  return directions;
}

/// All pairs of vanishing points at a focal length.
class OrthogonalPairs {
 public:
  OrthogonalPairs(const std::vector<Eigen::Vector3d>& points, const std::vector<double>& weights,
                  const Eigen::Vector2d& c)
      : points_(points), weights_(weights), c_(c) {}

  /// How near to orthogonal the pairs are together.
  double Support(double focal) const {
    double support = 0.0;
    ForEach(focal, [&](int, int, double cosine, double, double weight) { support += weight * Nearness(cosine); });
    return support;
  }

  /// Gauss-Newton on log f over the pairs that are about orthogonal.
  double Refined(double focal) const {
    constexpr int kSteps = 10;
    for (int step = 0; step < kSteps; ++step) {
      double gradient = 0.0, curvature = 0.0;
      ForEach(focal, [&](int, int, double cosine, double slope, double weight) {
        gradient += weight * Nearness(cosine) * slope * cosine;
        curvature += weight * Nearness(cosine) * slope * slope;
      });
      if (!(curvature > 0.0)) break;
      focal *= std::exp(std::clamp(-gradient / curvature, -0.2, 0.2));
    }
    return focal;
  }

  /// Which points are orthogonal, and what they say of log f: the heaviest three of which each two are, else two.
  VanishingFocal At(double focal) const {
    const auto count = static_cast<int>(points_.size());
    Eigen::MatrixXd information = Eigen::MatrixXd::Constant(count, count, -1.0);
    ForEach(focal, [&](int i, int j, double cosine, double slope, double) {
      if (std::abs(cosine) < kOrthogonalSine) information(i, j) = slope * slope;
    });
    VanishingFocal best{focal, std::numeric_limits<double>::infinity(), {}};
    double heaviest = 0.0;
    for (int i = 0; i < count; ++i)
      for (int j = i + 1; j < count; ++j) {
        if (information(i, j) < 0.0) continue;
        Keep({i, j}, information(i, j), &heaviest, &best);
        for (int k = j + 1; k < count; ++k)
          if (information(i, k) >= 0.0 && information(j, k) >= 0.0)
            Keep({i, j, k}, information(i, j) + information(i, k) + information(j, k), &heaviest, &best);
      }
    return best;
  }

 private:
  static double Nearness(double cosine) { return std::exp(-0.5 * std::pow(cosine / kAngleSigma, 2.0)); }

  /// call(i, j, cosine of the angle, its derivative by log f, weight) of each pair.
  template <class Call>
  void ForEach(double focal, const Call& call) const {
    const std::vector<Eigen::Vector3d> directions = DirectionsOf(points_, CameraMatrix(focal, c_));
    for (std::size_t i = 0; i < directions.size(); ++i)
      for (std::size_t j = i + 1; j < directions.size(); ++j) {
        const Eigen::Vector3d &a = directions[i], &b = directions[j];
        const double cosine = a.dot(b), slope = 2.0 * a[2] * b[2] - cosine * (a[2] * a[2] + b[2] * b[2]);
        call(static_cast<int>(i), static_cast<int>(j), cosine, slope, weights_[i] * weights_[j]);
      }
  }

  /// Three orthogonal ones are taken before two, then those of most weight; only what determines f at all.
  void Keep(const std::vector<int>& places, double information, double* heaviest, VanishingFocal* best) const {
    const double log_sigma = kAngleSigma / std::sqrt(information);
    if (!(log_sigma <= kMostFocalLogSigma)) return;
    double weight = 0.0;
    for (const int place : places) weight += weights_[static_cast<std::size_t>(place)];
    const bool better =
        places.size() != best->orthogonal.size() ? places.size() > best->orthogonal.size() : weight > *heaviest;
    if (!better) return;
    *heaviest = weight;
    best->log_sigma = log_sigma;
    best->orthogonal = places;
  }

  const std::vector<Eigen::Vector3d>& points_;
  const std::vector<double>& weights_;
  const Eigen::Vector2d c_;
};

double LogDensity(double focal, const FocalPrior& prior) {
  return -0.5 * std::pow(std::log(focal / prior.focal) / prior.log_sigma, 2.0);
}

/// The direction that is most vertical of those within 45° of the image's columns, −1 where there is none.
int VerticalOf(const std::vector<Eigen::Vector3d>& directions, const std::vector<double>& weights) {
  int best = -1;
  double most = 0.0;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const double upright = std::abs(directions[i][1]);
    if (upright < kUprightCosine || !(weights[i] * upright > most)) continue;
    most = weights[i] * upright;
    best = static_cast<int>(i);
  }
  return best;
}

/// Of the two surest directions that span a plane whose normal is within 45° of the image's columns; 0 where no two do.
Eigen::Vector3d NormalOfTwo(const std::vector<Eigen::Vector3d>& directions, const std::vector<double>& weights) {
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double most = 0.0;
  for (std::size_t i = 0; i < directions.size(); ++i)
    for (std::size_t j = i + 1; j < directions.size(); ++j) {
      const Eigen::Vector3d normal = directions[i].cross(directions[j]);
      if (normal.norm() < kApartSine || std::abs(normal.normalized()[1]) < kUprightCosine) continue;
      if (!(weights[i] * weights[j] > most)) continue;
      most = weights[i] * weights[j];
      best = normal.normalized();
    }
  return best;
}

/// The direction that is nearest to the vertical one and to orthogonal to the horizontal ones.
Eigen::Vector3d UpOf(const std::vector<Eigen::Vector3d>& directions, const std::vector<double>& weights,
                     const Horizon& horizon) {
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const int i : horizon.horizontal)
    scatter += weights[static_cast<std::size_t>(i)] * directions[static_cast<std::size_t>(i)] *
               directions[static_cast<std::size_t>(i)].transpose();
  if (horizon.vertical >= 0) {
    const auto v = static_cast<std::size_t>(horizon.vertical);
    scatter += weights[v] * (Eigen::Matrix3d::Identity() - directions[v] * directions[v].transpose());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  const Eigen::Vector3d up = solver.eigenvectors().col(0);
  return up[1] < 0.0 ? up : Eigen::Vector3d(-up);
}

}  // namespace

Eigen::Vector3d DirectionOf(const Eigen::Vector3d& point, const Eigen::Matrix3d& K) {
  constexpr double kFlat = 1e-12;
  Eigen::Vector3d direction = (K.inverse() * point).normalized();
  const bool flat = std::abs(direction[2]) < kFlat;
  const bool away = flat ? direction[1] > 0.0 : direction[2] < 0.0;
  return away ? Eigen::Vector3d(-direction) : direction;
}

std::optional<double> FocalOfOrthogonal(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector2d& c) {
  const double product = (a.head<2>() - a[2] * c).dot(b.head<2>() - b[2] * c), depth = a[2] * b[2];
  const double square = -product / depth;
  if (!(square > 0.0) || !std::isfinite(square)) return std::nullopt;
  return std::sqrt(square);
}

std::optional<VanishingFocal> FocalOfVanishingPoints(const std::vector<Eigen::Vector3d>& points,
                                                     const std::vector<double>& weights, const Eigen::Vector2d& c,
                                                     const FocalPrior& prior) {
  const OrthogonalPairs pairs(points, weights, c);
  VanishingFocal best;
  double most = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      const auto focal = FocalOfOrthogonal(points[i], points[j], c);
      if (!focal) continue;
      const VanishingFocal found = pairs.At(pairs.Refined(*focal));
      const double score = std::log(pairs.Support(found.focal_px)) + LogDensity(found.focal_px, prior);
      if (found.orthogonal.empty() || !(score > most)) continue;
      most = score;
      best = found;
    }
  if (best.orthogonal.empty()) return std::nullopt;
  return best;
}

double Horizon::TiltDeg() const { return std::atan2(-line[0], line[1]) / kDegree; }

double Horizon::PitchDeg() const { return std::asin(std::clamp(up[2], -1.0, 1.0)) / kDegree; }

std::optional<Horizon> HorizonOf(const std::vector<Eigen::Vector3d>& points, const std::vector<double>& weights,
                                 const Eigen::Matrix3d& K) {
  const std::vector<Eigen::Vector3d> directions = DirectionsOf(points, K);
  Horizon horizon;
  horizon.vertical = VerticalOf(directions, weights);
  const Eigen::Vector3d first =
      horizon.vertical >= 0 ? directions[static_cast<std::size_t>(horizon.vertical)] : NormalOfTwo(directions, weights);
  if (first.isZero()) return std::nullopt;
  for (std::size_t i = 0; i < directions.size(); ++i)
    if (std::abs(directions[i].dot(first)) < kOrthogonalSine) horizon.horizontal.push_back(static_cast<int>(i));
  horizon.up = UpOf(directions, weights, horizon);
  // Of the plane of directions d with up · d = 0: up · K⁻¹ x = 0.
  horizon.line = K.inverse().transpose() * horizon.up;
  const double length = horizon.line.head<2>().norm();
  if (!(length > 0.0) || horizon.line[1] == 0.0) return std::nullopt;
  horizon.line /= horizon.line[1] < 0.0 ? -length : length;
  return horizon;
}

}  // namespace diffsac
