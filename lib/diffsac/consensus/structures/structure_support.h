#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <numbers>
#include <vector>

#include "diffsac/consensus/model_hooks.h"
#include "diffsac/consensus/scores/false_alarms.h"
#include "diffsac/core/random.h"
#include "diffsac/geometry/hyperplane.h"
#include "diffsac/geometry/point_spread.h"

namespace diffsac::structures_internal {

/// Uniform points that say how often one fits a model by chance.
inline constexpr int kChancePoints = 10000;
/// Beside a model: farther than ε, in a space so many times as large.
inline constexpr double kBeside = 12.0;
/// A structure is so many times as dense as what is beside it; the best model of a cluster is not.
inline constexpr double kDenser = 3.0;
/// A model of whose points so large a share is near other models, in a space so many times as large as that within ε,
/// is one of them, seen twice: real surfaces are thicker than ε.
inline constexpr double kNear = 3.0;
inline constexpr double kSame = 0.7;

/// How many ε a space so many times as large as that within ε reaches: a residual in the image plane has two
/// dimensions.
template <MinimalModel Model>
double Reach(double times) {
  return std::pow(times, 1.0 / ResidualDimension<Model>());
}

/// What speaks for a model, among free points and its own.
struct StructureSupport {
  int points = 0;
  int inside = 0;  ///< Within ε.
  int beside = 0;
  int shared = 0;  ///< Of those inside, how many are near other models.
  bool IsSame() const { return shared >= kSame * inside; }
  bool IsDense() const { return (kBeside - 1.0) * inside > kDenser * beside; }
};

/// Where points of no structure might be: of matches, uniform points in the box of the data.
template <MinimalModel Model>
class ChanceSpace {
 public:
  ChanceSpace(const PointMatrix& points, double threshold, Rng rng)
      : threshold_(threshold), uniform_(kChancePoints, points.cols()) {
    const Eigen::RowVectorXd low = points.colwise().minCoeff(), high = points.colwise().maxCoeff();
    for (Eigen::Index i = 0; i < kChancePoints; ++i)
      for (Eigen::Index k = 0; k < points.cols(); ++k) uniform_(i, k) = rng.Uniform(low[k], high[k]);
  }

  /// Which share of them fits a model.
  double ShareNear(const ModelParameters& parameters) const {
    const typename Model::Parameters model = parameters;
    int fitting = 0;
    for (Eigen::Index i = 0; i < kChancePoints; ++i)
      fitting += Model::Residual(model, uniform_.data() + i * uniform_.cols()) <= threshold_;
    return (fitting + 1.0) / (kChancePoints + 1.0);
  }

 private:
  double threshold_;
  PointMatrix uniform_;
};

/// Of lines and planes, the ellipsoid in which uniform points have the data's covariance: it turns with the data. It
/// reaches kBeside thresholds however flat the data is, that of one plane, say. Its section by the model counts, and
/// half of its largest one at least: data of another shape goes on where the ellipsoid ends.
template <MinimalModel Model>
requires std::same_as<Model, Hyperplane<Model::kDimension>>
class ChanceSpace<Model> {
 public:
  ChanceSpace(const PointMatrix& points, double threshold, const Rng&)
      : threshold_(threshold), spread_(SpreadOf(points)) {}

  double ShareNear(const ModelParameters& model) const {
    constexpr int kDimension = Model::kDimension;
    const Eigen::VectorXd along = spread_.axes.transpose() * model.head(kDimension);
    const double sigma = along.cwiseProduct(spread_.sides).norm() / std::sqrt(12.0);
    const double reach = std::max(std::sqrt(kDimension + 2.0) * sigma, kBeside * threshold_);
    const double place = std::abs(model.head(kDimension).dot(spread_.centre) + model[kDimension]) / reach;
    const double half = threshold_ / reach;
    return std::max(ShareBelow(place + half) - ShareBelow(place - half), 0.5 * (ShareBelow(half) - ShareBelow(-half)));
  }

 private:
  /// Of a disc or a ball of radius 1, what is below this height.
  static double ShareBelow(double height) {
    const double h = std::clamp(height, -1.0, 1.0);
    if constexpr (Model::kDimension == 2) return 0.5 + (h * std::sqrt(1.0 - h * h) + std::asin(h)) / std::numbers::pi;
    return 0.5 + 0.25 * h * (3.0 - h * h);
  }

  double threshold_;
  PointSpread spread_;
};

/// log10 of the number of such models (LogChanceModels) that points of no structure would give. least: of a point that
/// fits, the least probability.
template <MinimalModel Model>
double LogModels(const ChanceSpace<Model>& chance, const ModelParameters& model, int points, int inside, double least) {
  return LogChanceModels(points, inside, Model::kMinimalSize, std::max(least, chance.ShareNear(model)));
}

}  // namespace diffsac::structures_internal
