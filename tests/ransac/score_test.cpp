#include "diffsac/ransac/scores/score.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/core/status.h"
#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/hyperplane.h"
#include "diffsac/ransac/option_names.h"
#include "diffsac/ransac/scores/scorer.h"
#include "geometry/loss_properties.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

constexpr ScoreKind kKinds[] = {ScoreKind::kInlierCount, ScoreKind::kMsac, ScoreKind::kMlesac, ScoreKind::kMagsac,
                                ScoreKind::kSigmaMarginalisedMsac};

TEST_CASE("Every score has its properties at any scale") {
  for (ScoreKind kind : kKinds)
    for (double scale : {1e-8, 1.0, 1e8})
      for (int dof : {1, 2, 3, 4, 5, 6}) {
        CAPTURE(ToString(kind), scale, dof);
        const double threshold = 0.1 * scale;
        const Score score(kind, threshold, 0.03 * scale, 20.0, dof, 0.3 * threshold);
        const double table_error = kind == ScoreKind::kMagsac ? 1e-6 : 0.0;
        // One minus a score is a loss bounded by 1.
        testing::CheckLossFunction({[&](double r) { return 1.0 - score(r); },
                                    [&](double r) { return -score.Derivative(r); },
                                    threshold,
                                    {threshold},
                                    1.0,
                                    table_error});
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
  const Score mixture(ScoreKind::kMlesac, 0.1, 0.03, 20.0);
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
    const Score score(ScoreKind::kSigmaMarginalisedMsac, 1.0, 0.3, 20.0, 1, least);
    for (const double residual : {0.0, 0.01, 0.05, 0.2, 0.7, 0.99, 1.0, 2.0})
      CHECK(score(residual) ==
            Approx(IntegralOverScales(residual, least) / IntegralOverScales(0.0, least)).epsilon(1e-4).margin(1e-6));
  }
  // With all scales one it is MSAC.
  const Score one(ScoreKind::kSigmaMarginalisedMsac, 1.0, 0.3, 20.0, 1, 5.0), msac(ScoreKind::kMsac, 1.0, 0.3, 20.0);
  for (const double residual : {0.0, 0.3, 0.8, 1.2}) CHECK(one(residual) == Approx(msac(residual)).margin(0.01));
  // Differences of residuals between the scales count alike, whatever the greatest is.
  const Score near(ScoreKind::kSigmaMarginalisedMsac, 20.0, 0.3, 20.0, 1, 0.1),
      far(ScoreKind::kSigmaMarginalisedMsac, 80.0, 0.3, 20.0, 1, 0.1);
  CHECK(near(0.1) - near(1.0) == Approx(far(0.1) - far(1.0)).epsilon(0.02));
}

TEST_CASE("A sum is that of the parts, weighted or not, for every length") {
  Rng rng(2);
  std::vector<double> residuals(67), weights(67);
  for (double& residual : residuals) residual = rng.Uniform(0.0, 0.3);
  for (double& weight : weights) weight = rng.Uniform();
  residuals[5] = std::numeric_limits<double>::quiet_NaN();
  for (ScoreKind kind : kKinds) {
    CAPTURE(ToString(kind));
    const Score score(kind, 0.1, 0.03, 20.0, 1, 0.02);
    double weighted = 0.0, plain = 0.0;
    for (int count = 0; count <= 67; ++count) {
      CHECK(score.Sum(residuals.data(), weights.data(), count) == Approx(weighted).epsilon(1e-12).margin(1e-13));
      CHECK(score.Sum(residuals.data(), count) == Approx(plain).epsilon(1e-13).margin(1e-13));
      if (count == 67) break;
      weighted += weights[count] * score(residuals[count]);
      plain += score(residuals[count]);
    }
  }
}

TEST_CASE("scores over scales were not finite for thresholds whose cubes are not ordinary numbers") {
  for (const double threshold : {1e-150, 1e-3, 1.0, 1e150}) {
    const Score score(ScoreKind::kSigmaMarginalisedMsac, threshold, threshold, 1.0, 1, 0.1 * threshold);
    CAPTURE(threshold);
    CHECK(score(0.0) == Approx(1.0));
    CHECK(score(threshold) == Approx(0.0).margin(1e-12));
    CHECK(score(0.3 * threshold) == Approx(Score(ScoreKind::kSigmaMarginalisedMsac, 1.0, 1.0, 1.0, 1, 0.1)(0.3)));
    CHECK(score(std::numeric_limits<double>::infinity()) == Approx(0.0).margin(1e-12));
  }
}

/// Whatever the score to beat, a model above it has its full score, and one that is not stays below it.
template <class Model>
void CheckBars(const PointMatrix& points, const Matrix3Parameters& truth, double threshold, Rng& rng) {
  Eigen::VectorXd weights(points.rows());
  // The first half counts for little, so that most of a score is still to come after it.
  for (Eigen::Index i = 0; i < weights.size(); ++i) weights[i] = (2 * i < weights.size() ? 0.01 : 1.0) * rng.Uniform();
  const Scorer<Model> plain(points), weighted(points, {weights, {}});
  for (const auto& [kind, name] : kEnumNames<ScoreKind>) {
    CAPTURE(name);
    const Score score(kind, threshold, threshold / 3.0, 20.0, 1, threshold / 8.0);
    for (const Scorer<Model>* scorer : {&plain, &weighted}) {
      for (const double change : {0.0, 1e-4, 1e-2, 1.0}) {
        Matrix3Parameters model = truth;
        for (double& value : model) value += change * std::abs(value) * rng.Normal();
        const double full = (*scorer)(model, score);
        CHECK(full == Approx((*scorer)(model, scorer->Residuals(model), score)).margin(1e-9));
        for (const double below : {-1.0, 0.0, 0.5 * full, 0.999 * full, full - 1e-9})
          if (below < full) CHECK((*scorer)(model, score, below) == full);
        for (const double above : {full, full + 1e-9, full + 0.1, 2.0 * full + 1.0, 1e9})
          CHECK((*scorer)(model, score, above) <= above);
      }
    }
  }
}

TEST_CASE("Giving up early, by residuals or by their bounds, decides as a full sum would") {
  Rng rng(1);
  for (const int count : {20, 64, 129, 700, 5000}) {
    auto problem = testing::RandomProblem(count, rng, 0.7);
    for (int i = 0; i < count / 2; ++i) problem.pixels(i, 2) += 100.0 * rng.Normal();
    problem.normalized = NormalizedCoordinates(problem.pixels, problem.k1, problem.k2);
    CheckBars<Fundamental>(problem.pixels, problem.fundamental, 1.5, rng);
    CheckBars<Essential>(problem.normalized, problem.essential, 2e-3, rng);
    const Matrix3Parameters h = testing::RandomHomography(rng);
    PointMatrix points = testing::HomographyPoints(h, count, rng, 0.7);
    for (int i = 0; i < count / 2; ++i) points(i, 2) += 100.0 * rng.Normal();
    CheckBars<Homography>(points, h, 1.5, rng);
  }
}

TEST_CASE("Rows by weight: every row once, the heavier class first, and the first rows of a class are any of it") {
  Rng rng(2);
  for (const int count : {0, 1, 2, 500, 9000}) {
    Eigen::VectorXd weights(count);
    for (double& weight : weights)
      weight = rng.Below(3) == 0 ? 0.25 * static_cast<double>(rng.Below(5)) : rng.Uniform();
    const RowsByWeight order = SortByWeight(count, weights);
    std::vector<int> sorted = order.rows, all(count);
    std::sort(sorted.begin(), sorted.end());
    std::iota(all.begin(), all.end(), 0);
    CHECK(sorted == all);
    int begin = 0;
    for (const WeightClass& group : order.classes) {
      CHECK(group.begin == begin);
      CHECK(group.mixed <= group.end);
      for (int i = group.begin; i < group.end; ++i) CHECK(weights[order.rows[i]] <= group.most);
      for (int i = group.end; i < count; ++i) CHECK(weights[order.rows[i]] <= 0.5 * group.most);
      begin = group.end;
    }
    CHECK(begin == count);
  }
  // Of a million rows alike the first thousand come from everywhere.
  const RowsByWeight order = SortByWeight(1000000, {});
  REQUIRE(order.classes.size() == 1);
  const double mean = std::accumulate(order.rows.begin(), order.rows.begin() + 1000, 0.0) / 1000;
  CHECK(std::abs(mean - 5e5) < 5e4);
}

}  // namespace

}  // namespace diffsac
