#include "diffsac/geometry/robust_loss.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/geometry/robust_loss_sums.h"
#include "geometry/loss_properties.h"

namespace diffsac {
namespace {

constexpr LossKind kKinds[] = {LossKind::kTrivial, LossKind::kTruncated, LossKind::kHuber, LossKind::kCauchy,
                               LossKind::kMarginalised};

/// What every loss of a squared residual promises beyond that.
void CheckSquaredLoss(const RobustLoss& loss) {
  CAPTURE(static_cast<int>(loss.kind), loss.scale);
  CHECK(loss.Value(0.0) == 0.0);
  CHECK(loss.Weight(0.0) == 1.0);
  double last_weight = 1.0;
  for (double s = 1e-4; s < 1e4; s *= 1.05) {
    const double value = loss.Value(s), weight = loss.Weight(s);
    CHECK(value <= s * (1.0 + 1e-12));
    CHECK(weight >= 0.0);
    CHECK(weight <= last_weight);
    last_weight = weight;
  }
  CHECK(loss.Weight(std::numeric_limits<double>::infinity()) == 0.0);
  CHECK(loss.Weight(std::numeric_limits<double>::quiet_NaN()) == 0.0);
}

TEST_CASE("Every loss has the properties of a loss, at any scale") {
  for (const LossKind kind : kKinds)
    for (const double scale : {1e-8, 1.0, 1e8}) {
      CAPTURE(static_cast<int>(kind), scale);
      const RobustLoss loss{kind, scale, 0.2 * scale};
      const double infinity = std::numeric_limits<double>::infinity();
      testing::CheckLossFunction(
          {[&](double r) { return loss.Value(r * r); },
           [&](double r) { return 2.0 * r * loss.Weight(r * r); },
           scale,
           {scale},
           kind == LossKind::kTruncated || kind == LossKind::kMarginalised ? loss.Value(scale * scale) : infinity});
    }
}

TEST_CASE("Losses are bounded by the square, and their weights fall from 1") {
  for (const LossKind kind : kKinds)
    for (const double scale : {0.1, 1.0, 7.0}) CheckSquaredLoss({kind, scale, 0.3 * scale});
}

TEST_CASE("Losses at known places") {
  CHECK(RobustLoss{LossKind::kTruncated, 2.0}.Value(3.9) == 3.9);
  CHECK(RobustLoss{LossKind::kTruncated, 2.0}.Value(100.0) == 4.0);
  CHECK(RobustLoss{LossKind::kTruncated, 2.0}.Value(std::numeric_limits<double>::quiet_NaN()) == 4.0);
  CHECK(RobustLoss{LossKind::kTruncated, 2.0}.Weight(4.0) == 1.0);  // a residual at the threshold is an inlier
  CHECK(RobustLoss{LossKind::kHuber, 2.0}.Value(9.0) == Approx(8.0));
  CHECK(RobustLoss{LossKind::kCauchy, 2.0}.Value(4.0) == Approx(4.0 * std::log(2.0)));
  CHECK(RobustLoss{LossKind::kTrivial, 2.0}.Value(1e9) == 1e9);
  // Below the smallest scale a square; then the weight falls as the cube of the distance.
  const RobustLoss scales{LossKind::kMarginalised, 1e6, 2.0};
  CHECK(scales.Value(4.0) == 4.0);
  CHECK(scales.Weight(16.0) == Approx(1.0 / 8.0));
  CHECK(RobustLoss{LossKind::kMarginalised, 8.0, 2.0}.Weight(65.0) == 0.0);
}

TEST_CASE("Sums and weights of many residuals are those of each, at any unit") {
  Rng rng(1);
  for (const LossKind kind : kKinds)
    for (const double unit : {1e-6, 1.0, 1e6})
      for (const int count : {0, 1, 5, 64, 131}) {
        CAPTURE(static_cast<int>(kind), unit, count);
        const RobustLoss loss{kind, 2.0 * unit, 0.3 * unit};
        std::vector<double> residuals(count), weights(count), out(count);
        for (double& residual : residuals) residual = unit * rng.Uniform(0.0, 3.0);
        for (double& weight : weights) weight = rng.Uniform();
        if (count > 3) {
          residuals[0] = 0.0;
          residuals[1] = 2.0 * unit;
          residuals[2] = 0.3 * unit;
          if (kind == LossKind::kTruncated || kind == LossKind::kMarginalised)
            residuals[3] = std::numeric_limits<double>::quiet_NaN();
        }
        LossWeights(loss, residuals.data(), weights.data(), count, out.data());
        double sum = 0.0;
        for (int i = 0; i < count; ++i) {
          const double square = residuals[i] * residuals[i];
          sum += weights[i] * loss.Value(square);
          CHECK(out[i] == Approx(weights[i] * loss.Weight(square)).margin(1e-14));
        }
        CHECK(SumLoss(loss, residuals.data(), weights.data(), count) == Approx(sum).epsilon(1e-12));
      }
}

}  // namespace
}  // namespace diffsac
