#include "diffsac/geometry/robust_loss_sums.h"

#include <catch2/catch.hpp>
#include <limits>
#include <vector>

#include "diffsac/core/random.h"

namespace diffsac {
namespace {

constexpr LossKind kLosses[] = {LossKind::kTrivial, LossKind::kTruncated, LossKind::kHuber, LossKind::kCauchy,
                                LossKind::kMarginalised};

TEST_CASE("Sums and weights of many residuals are those of each, at any unit") {
  Rng rng(1);
  for (const LossKind kind : kLosses)
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
