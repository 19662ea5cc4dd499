#include "diffsac/ransac/local/local_optimizer.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "diffsac/core/random.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/ransac/local/graph_cut.h"
#include "diffsac/ransac/samplers/neighbor_index.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

TEST_CASE("Few points are all looked at, many in part, enough inliers always") {
  CHECK(PartSize(100, 50) == 100);
  CHECK(PartSize(999, 900) == 999);
  CHECK(PartSize(1000, 500) == kPartPoints);
  CHECK(PartSize(1000, 250) == 1000);
  for (const int size : {1000, 5000, 100000})
    for (const int inliers : {10, 100, 1000}) {
      const int part = PartSize(size, inliers);
      CHECK(part <= size);
      if (part < size) CHECK(static_cast<double>(part) * inliers / size >= kPartInliers);
    }
}

TEST_CASE("Inner samples of a part improve a model as those of all points do") {
  constexpr double kThreshold = 1.5;
  Rng rng(1);
  double start_sum = 0.0, part_sum = 0.0, all_sum = 0.0;
  for (int trial = 0; trial < 10; ++trial) {
    auto problem = testing::RandomProblem(3000, rng, 0.5);
    for (int i = 0; i < 1500; ++i) problem.pixels(i, 2) += 200.0 * rng.Normal();
    const Scorer<Fundamental> scorer(problem.pixels);
    const Score score(ScoreKind::kMsac, kThreshold, 0.5, 20.0);
    int set[7], fits = 0;
    ScoredModel<Fundamental> start{Matrix3Parameters::Zero(), -1.0};
    for (int draw = 0; draw < 5; ++draw) {
      for (int i = 0; i < 7; ++i) set[i] = 1500 + 200 * i + draw;
      Matrix3Parameters models[3];
      const int count = Fundamental::SolveMinimal(problem.pixels, set, models);
      for (int i = 0; i < count; ++i)
        if (scorer(models[i], score) > start.score) start = {models[i], scorer(models[i], score)};
    }
    REQUIRE(start.score > 0.0);
    const auto part = OptimizeByInnerSamples<Fundamental>(scorer, score, kThreshold, 10, start, Rng(trial), &fits);
    const auto all = FitInnerSamples<Fundamental>(scorer, score, kThreshold, 10, start, Rng(trial), &fits);
    CHECK(part.score == scorer(part.model, score));
    CHECK(part.score >= start.score);
    start_sum += start.score;
    part_sum += part.score;
    all_sum += all.score;
  }
  CHECK(part_sum > start_sum);
  CHECK(part_sum > 0.99 * all_sum);
}

PointMatrix RandomPoints(int count, Rng rng) {
  PointMatrix points(count, 2);
  for (Eigen::Index i = 0; i < points.size(); ++i) points.data()[i] = rng.Uniform();
  return points;
}

Eigen::VectorXd RandomResiduals(int count, Rng rng) {
  Eigen::VectorXd residuals(count);
  for (double& r : residuals) r = rng.Uniform(0.0, 2.5);
  return residuals;
}

/// The definition, of any labels.
double Energy(const PointMatrix& points, int neighbors, double weight, const Eigen::VectorXd& residuals,
              const std::vector<std::uint8_t>& labels) {
  const Eigen::VectorXd kernel = (-0.5 * residuals.array().square()).exp();
  double energy = 0.0;
  for (int i = 0; i < points.rows(); ++i) energy += labels[i] ? 1.0 - kernel[i] : kernel[i];
  for (const auto& [i, j] : NeighborEdges(points, neighbors)) {
    const double mean = 0.5 * (kernel[i] + kernel[j]);
    energy += weight * (labels[i] != labels[j] ? 1.0 : labels[i] ? 1.0 - mean : mean);
  }
  return energy;
}

TEST_CASE("The labels have the least energy of all labellings") {
  constexpr int kPoints = 11;
  for (int trial = 0; trial < 60; ++trial) {
    const double weight = trial % 3 == 0 ? 0.0 : 0.1 * (trial % 7);
    const PointMatrix points = RandomPoints(kPoints, Rng(trial).Fork("points"));
    const Eigen::VectorXd residuals = RandomResiduals(kPoints, Rng(trial).Fork("residuals"));
    double least = std::numeric_limits<double>::infinity();
    std::vector<std::uint8_t> labels(kPoints);
    for (int code = 0; code < 1 << kPoints; ++code) {
      for (int i = 0; i < kPoints; ++i) labels[i] = code >> i & 1;
      least = std::min(least, Energy(points, 3, weight, residuals, labels));
    }
    const std::vector<std::uint8_t> best = GraphCut(points, 3, weight).Label(residuals, 1.0);
    CHECK(Energy(points, 3, weight, residuals, best) == Approx(least).margin(1e-5));
  }
}

TEST_CASE("Without spatial weight a label is a threshold, with it, neighbours decide close cases") {
  const double limit = std::sqrt(2.0 * std::log(2.0));  // exp(−r²/2) = 1/2
  const PointMatrix points = RandomPoints(300, Rng(1));
  const Eigen::VectorXd residuals = RandomResiduals(300, Rng(2));
  const std::vector<std::uint8_t> labels = GraphCut(points, 5, 0.0).Label(residuals, 1.0);
  for (int i = 0; i < 300; ++i) CHECK(labels[i] == (residuals[i] < limit ? 1 : 0));

  Eigen::VectorXd island = Eigen::VectorXd::Zero(300);
  island[7] = 1.3 * limit;
  CHECK(GraphCut(points, 5, 0.0).Label(island, 1.0)[7] == 0);
  CHECK(GraphCut(points, 5, 0.3).Label(island, 1.0)[7] == 1);
}

TEST_CASE("Hostile input for the cut: coinciding points, NaN and infinite residuals, one point") {
  const PointMatrix same = PointMatrix::Ones(40, 2);
  Eigen::VectorXd residuals = Eigen::VectorXd::Constant(40, 5.0);
  residuals[3] = std::numeric_limits<double>::quiet_NaN();
  residuals[4] = std::numeric_limits<double>::infinity();
  for (std::uint8_t label : GraphCut(same, 6, 0.1).Label(residuals, 1.0)) CHECK(label == 0);
  CHECK(GraphCut(PointMatrix::Ones(1, 2), 6, 0.1).Label(Eigen::VectorXd::Zero(1), 1.0) == std::vector<std::uint8_t>{1});
  CHECK(GraphCut(PointMatrix(0, 2), 6, 0.1).Label(Eigen::VectorXd(0), 1.0).empty());
}

}  // namespace

}  // namespace diffsac
