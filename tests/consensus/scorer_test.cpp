#include "diffsac/consensus/scores/scorer.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>
#include <vector>

#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

/// Whatever the bar, a model above it has its full score, and one that is not stays below it.
template <class Model>
void CheckBars(const PointMatrix& points, const Matrix3Parameters& truth, double threshold, Rng& rng) {
  Eigen::VectorXd weights(points.rows());
  // The first half counts for little, so that most of a score is still to come after it.
  for (Eigen::Index i = 0; i < weights.size(); ++i) weights[i] = (2 * i < weights.size() ? 0.01 : 1.0) * rng.Uniform();
  const Scorer<Model> plain(points), weighted(points, {weights, {}});
  for (const auto& [kind, name] : kEnumNames<ScoreKind>) {
    CAPTURE(name);
    const Score score(kind, threshold, threshold / 3.0, 20.0, 1, threshold / 8.0,
                      {100.0 * threshold, ResidualDimension<Model>(), Model::kMinimalSize, 0.0});
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
  for (const int count : {20, 64, 129, 700}) {
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

TEST_CASE("The heaviest first: every row once, weights falling by classes of 1/64, equal ones in their order") {
  Rng rng(2);
  for (const int count : {0, 1, 2, 500}) {
    Eigen::VectorXd weights(count);
    for (double& weight : weights)
      weight = rng.Below(3) == 0 ? 0.25 * static_cast<double>(rng.Below(5)) : rng.Uniform();
    const std::vector<int> rows = HeaviestFirst(weights);
    std::vector<int> sorted = rows, all(count);
    std::sort(sorted.begin(), sorted.end());
    std::iota(all.begin(), all.end(), 0);
    CHECK(sorted == all);
    for (int i = 1; i < count; ++i) {
      CHECK(weights[rows[i]] <= weights[rows[i - 1]] + 1.0 / 64.0);
      if (weights[rows[i]] == weights[rows[i - 1]]) CHECK(rows[i] > rows[i - 1]);
    }
  }
}

}  // namespace
}  // namespace diffsac
