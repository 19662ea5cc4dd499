#include "diffsac/consensus/score.h"

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
                                ScoreKind::kMagsac};

TEST_CASE("Every score has the properties of a score, at any scale") {
  for (ScoreKind kind : kKinds)
    for (double scale : {1e-8, 1.0, 1e8})
      for (int dof : {1, 2, 3, 4, 5, 6}) {
        CAPTURE(ToString(kind), scale, dof);
        const double threshold = 0.1 * scale;
        const Score score(kind, threshold, 0.03 * scale, 20.0, dof);
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

}  // namespace
}  // namespace diffsac
