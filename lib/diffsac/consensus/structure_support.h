#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "diffsac/consensus/false_alarms.h"
#include "diffsac/consensus/model_hooks.h"
#include "diffsac/core/random.h"
#include "diffsac/geometry/model.h"

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

/// How many models chance would give.
template <MinimalModel Model>
class StructureChance {
 public:
  using Parameters = typename Model::Parameters;

  StructureChance(const PointMatrix& points, double threshold, Rng rng)
      : threshold_(threshold), uniform_(kChancePoints, points.cols()) {
    const Eigen::RowVectorXd low = points.colwise().minCoeff(), high = points.colwise().maxCoeff();
    for (Eigen::Index i = 0; i < kChancePoints; ++i)
      for (Eigen::Index k = 0; k < points.cols(); ++k) uniform_(i, k) = rng.Uniform(low[k], high[k]);
  }

  /// log10 of the number of such models (LogChanceModels) that points spread uniformly over the box of the data would
  /// give. least: of a point that fits, the least probability.
  double LogModels(const ModelParameters& parameters, int points, int inside, double least) const {
    const Parameters model = parameters;
    int fitting = 0;
    for (Eigen::Index i = 0; i < kChancePoints; ++i)
      fitting += Model::Residual(model, uniform_.data() + i * uniform_.cols()) <= threshold_;
    const double share = (fitting + 1.0) / (kChancePoints + 1.0);
    return LogChanceModels(points, inside, Model::kMinimalSize, std::max(least, share));
  }

 private:
  double threshold_;
  PointMatrix uniform_;
};

}  // namespace diffsac::structures_internal
