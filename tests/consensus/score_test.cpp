#include "diffsac/consensus/score.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "consensus/score_properties.h"
#include "diffsac/core/random.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

constexpr ScoreKind kKinds[] = {ScoreKind::kInlierCount, ScoreKind::kMsac, ScoreKind::kGaussianUniform,
                                ScoreKind::kMagsac, ScoreKind::kMarginalised};

TEST_CASE("Every score has the properties of a score, at any scale") {
  for (ScoreKind kind : kKinds)
    for (double scale : {1e-8, 1.0, 1e8})
      for (int dof : {1, 2, 3, 4, 5, 6}) {
        CAPTURE(ToString(kind), scale, dof);
        const double threshold = 0.1 * scale;
        const Score score(kind, threshold, 0.03 * scale, 20.0, dof, 0.3 * threshold);
        const double table_error = kind == ScoreKind::kMagsac ? 1e-6 : 0.0;
        testing::CheckScore(
            {score, [&](double r) { return score.Derivative(r); }, threshold, {threshold}, table_error});
        if (kind != ScoreKind::kMagsac) break;
      }
}

TEST_CASE("Scores have their defined values") {
  const Score count(ScoreKind::kInlierCount, 0.1, 0.03, 20.0);
  CHECK(count(0.1) == 1.0);
  CHECK(count(std::nextafter(0.1, 1.0)) == 0.0);
  const Score msac(ScoreKind::kMsac, 0.1, 0.03, 20.0);
  CHECK(msac(0.05) == Approx(0.75));
  CHECK(msac(0.1) == Approx(0.0).margin(1e-12));
  const Score mixture(ScoreKind::kGaussianUniform, 0.1, 0.03, 20.0);
  CHECK(mixture(0.03) == Approx(std::log(1.0 + 20.0 * std::exp(-0.5)) / std::log(21.0)));
}

/// ∫ max(0, 1 − r²/t²) dt/t² from `least` to 1, in many steps.
double IntegralOverScales(double residual, double least) {
  constexpr int kSteps = 20000;
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double t = least + (1.0 - least) * (i + 0.5) / kSteps;
    sum += std::max(0.0, 1.0 - residual * residual / (t * t)) / (t * t);
  }
  return sum * (1.0 - least) / kSteps;
}

TEST_CASE("The score over scales is MSAC's integral over them, and between the scales it forgets the greatest") {
  for (const double least : {0.5, 0.1, 0.02}) {
    const Score score(ScoreKind::kMarginalised, 1.0, 0.3, 20.0, 1, least);
    for (const double residual : {0.0, 0.01, 0.05, 0.2, 0.7, 0.99, 1.0, 2.0})
      CHECK(score(residual) ==
            Approx(IntegralOverScales(residual, least) / IntegralOverScales(0.0, least)).epsilon(1e-4).margin(1e-6));
  }
  // With all scales one it is MSAC.
  const Score one(ScoreKind::kMarginalised, 1.0, 0.3, 20.0, 1, 5.0), msac(ScoreKind::kMsac, 1.0, 0.3, 20.0);
  for (const double residual : {0.0, 0.3, 0.8, 1.2}) CHECK(one(residual) == Approx(msac(residual)).margin(0.01));
  // Differences of residuals between the scales count alike, whatever the greatest is.
  const Score near(ScoreKind::kMarginalised, 20.0, 0.3, 20.0, 1, 0.1),
      far(ScoreKind::kMarginalised, 80.0, 0.3, 20.0, 1, 0.1);
  CHECK(near(0.1) - near(1.0) == Approx(far(0.1) - far(1.0)).epsilon(0.02));
}

TEST_CASE("A weighted sum is the sum of the weighted parts") {
  Rng rng(2);
  std::vector<double> residuals(67), weights(67);
  for (double& residual : residuals) residual = rng.Uniform(0.0, 0.3);
  for (double& weight : weights) weight = rng.Uniform();
  residuals[5] = std::numeric_limits<double>::quiet_NaN();
  for (ScoreKind kind : kKinds) {
    CAPTURE(ToString(kind));
    const Score score(kind, 0.1, 0.03, 20.0, 1, 0.02);
    double sum = 0.0;
    for (int i = 0; i < 67; ++i) sum += weights[i] * score(residuals[i]);
    CHECK(score.Sum(residuals.data(), weights.data(), 67) == Approx(sum).epsilon(1e-12));
    const std::vector<double> ones(67, 1.0);
    CHECK(score.Sum(residuals.data(), ones.data(), 67) == Approx(score.Sum(residuals.data(), 67)).epsilon(1e-12));
  }
}

TEST_CASE("The sum is the sum of the parts for every length") {
  Rng rng(1);
  std::vector<double> residuals(67);
  for (double& residual : residuals) residual = rng.Uniform(0.0, 0.3);
  residuals[5] = std::numeric_limits<double>::quiet_NaN();
  for (ScoreKind kind : kKinds) {
    CAPTURE(ToString(kind));
    const Score score(kind, 0.1, 0.03, 20.0);
    double sum = 0.0;
    for (int count = 0; count <= 67; ++count) {
      CHECK(score.Sum(residuals.data(), count) == Approx(sum).epsilon(1e-13).margin(1e-13));
      if (count < 67) sum += score(residuals[count]);
    }
  }
}

TEST_CASE("Names of scores go both ways, and others are refused") {
  for (ScoreKind kind : kKinds) CHECK(FromString<ScoreKind>(ToString(kind)) == kind);
  CHECK_THROWS_AS(FromString<ScoreKind>("mssac"), Error);
}

TEST_CASE("scores over scales were not finite for thresholds whose cubes are not ordinary numbers") {
  for (const double threshold : {1e-150, 1e-3, 1.0, 1e150}) {
    const Score score(ScoreKind::kMarginalised, threshold, threshold, 1.0, 1, 0.1 * threshold);
    CAPTURE(threshold);
    CHECK(score(0.0) == Approx(1.0));
    CHECK(score(threshold) == Approx(0.0).margin(1e-12));
    CHECK(score(0.3 * threshold) == Approx(Score(ScoreKind::kMarginalised, 1.0, 1.0, 1.0, 1, 0.1)(0.3)));
    CHECK(score(std::numeric_limits<double>::infinity()) == Approx(0.0).margin(1e-12));
  }
}

}  // namespace
}  // namespace diffsac
