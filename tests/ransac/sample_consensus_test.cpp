#include "diffsac/ransac/sample_consensus.h"

#include <catch2/catch.hpp>
#include <numeric>
#include <vector>

#include "diffsac/ransac/scores/mixture.h"
#include "ransac/random_problems.h"

namespace diffsac {
namespace {

using testing::SearchSets;

using testing::AllSets;
using testing::MakeRandomProblem;
using testing::RandomSets;

constexpr double kThreshold = 0.1;

ConsensusOptions Plain() {
  ConsensusOptions options;
  options.refit = Refit::kNone;
  return options;
}

int Count(const std::vector<std::uint8_t>& mask) { return std::accumulate(mask.begin(), mask.end(), 0); }

/// The loop in its plainest form: solve each set, count, keep the first best.
template <int D>
std::pair<ModelParameters, int> BestByHand(const PointMatrix& points, const std::vector<int>& sets) {
  std::pair<ModelParameters, int> best{{}, -1};
  for (std::size_t i = 0; i < sets.size(); i += D) {
    typename Hyperplane<D>::Parameters model;
    if (Hyperplane<D>::SolveMinimal(points, sets.data() + i, &model) == 0) continue;
    const int count = Count(InlierMask<Hyperplane<D>>(points, model, kThreshold));
    if (count > best.second) best = {model, count};
  }
  return best;
}

TEMPLATE_TEST_CASE_SIG("The loop finds the first hypothesis of most inliers", "", ((int D), D), 2, 3) {
  for (int trial = 0; trial < 100; ++trial) {
    const auto problem = MakeRandomProblem<D>(150, 0.6, 0.04, Rng(trial));
    const std::vector<int> sets = RandomSets(150, D, 200, trial);
    const auto [model, count] = BestByHand<D>(problem.points, sets);
    const ConsensusResult result = SearchSets<Hyperplane<D>>(problem.points, kThreshold, sets, Plain(), Rng(trial));
    REQUIRE(result.status == Status::kOk);
    CHECK(result.model == model);
    CHECK(result.score == count);
    CHECK(Count(result.inliers) == count);
    CHECK(result.inliers == InlierMask<Hyperplane<D>>(problem.points, result.model, kThreshold));
    CHECK(result.hypotheses == 200);
    CHECK(result.unique_minimal_sets == CountUniqueSets(sets, D));
  }
}

TEST_CASE("Keeping more candidates does not change the best hypothesis, for any score") {
  for (const ScoreKind score : {ScoreKind::kInlierCount, ScoreKind::kMsac, ScoreKind::kMlesac}) {
    for (int trial = 0; trial < 20; ++trial) {
      const auto problem = MakeRandomProblem<2>(130, 0.7, 0.04, Rng(trial));
      ConsensusOptions one = Plain();
      one.score = score;
      // The final score must be the loop's, so that the first candidate wins again.
      one.final_score = score == ScoreKind::kMlesac ? ScoreKind::kMsac : score;
      ConsensusOptions many = one;
      many.refit_candidates = 10;
      const auto sets = AllSets(130, 2);
      const auto a = SearchSets<Line>(problem.points, kThreshold, sets, one, Rng(1));
      const auto b = SearchSets<Line>(problem.points, kThreshold, sets, many, Rng(1));
      if (score == one.final_score) CHECK(a.model == b.model);
      CHECK(b.score >= a.score);
    }
  }
}

TEST_CASE("No usable hypothesis: no model") {
  const auto problem = MakeRandomProblem<2>(20, 0.5, 0.04, Rng(1));
  CHECK(SearchSets<Line>(problem.points, kThreshold, std::vector<int>{}, {}, Rng(1)).status == Status::kNoModel);
  PointMatrix twins(3, 2);
  twins << 0, 0, 0, 0, 1, 1;
  const auto result = SearchSets<Line>(twins, kThreshold, std::vector<int>{0, 1}, {}, Rng(1));
  CHECK(result.status == Status::kNoModel);
  CHECK(result.hypotheses == 1);
  CHECK(SearchSets<Line>(twins, kThreshold, std::vector<int>{0, 9, -1, 2}, {}, Rng(1)).status == Status::kNoModel);
}

TEST_CASE("Priors join the hypotheses: models free of charge, the weighted fit for one") {
  const auto problem = MakeRandomProblem<2>(60, 0.5, 0.03, Rng(5));
  const std::vector<int> bad_set{0, 1};  // Two outliers.
  EstimationPriors models;
  models.models = {problem.truth, ModelParameters(), Eigen::Vector3d::Constant(std::nan(""))};
  const auto with_models = SearchSets<Line>(problem.points, kThreshold, bad_set, Plain(), Rng(1), models);
  REQUIRE(with_models.status == Status::kOk);
  CHECK(with_models.model == problem.truth);
  CHECK(with_models.hypotheses == 1);

  EstimationPriors weights;
  weights.fit_weights = Eigen::Map<const Eigen::Matrix<std::uint8_t, -1, 1>>(problem.inliers.data(), 60).cast<double>();
  const auto with_weights = SearchSets<Line>(problem.points, kThreshold, bad_set, Plain(), Rng(1), weights);
  REQUIRE(with_weights.status == Status::kOk);
  CHECK(AngleBetweenDegrees(with_weights.model, problem.truth) < 0.5);
  CHECK(with_weights.hypotheses == 2);
  // A hint alone is enough, and a poor one does no harm.
  CHECK(SearchSets<Line>(problem.points, kThreshold, std::vector<int>{}, {}, Rng(1), weights).status == Status::kOk);
  weights.fit_weights.setConstant(-1.0);
  CHECK(SearchSets<Line>(problem.points, kThreshold, bad_set, Plain(), Rng(1), weights).model ==
        SearchSets<Line>(problem.points, kThreshold, bad_set, Plain(), Rng(1)).model);
}

TEST_CASE("Every fit is in the budget") {
  const auto problem = MakeRandomProblem<2>(60, 0.5, 0.03, Rng(6));
  const auto sets = RandomSets(60, 2, 50, 1);
  const auto hypotheses = [&](ConsensusOptions options) {
    return SearchSets<Line>(problem.points, kThreshold, sets, options, Rng(1)).hypotheses;
  };
  ConsensusOptions options;
  CHECK(hypotheses(options) == 51);
  options.refit_candidates = 5;
  CHECK(hypotheses(options) == 55);
  options.refit = Refit::kMixture;
  CHECK(hypotheses(options) > 55);
  CHECK(hypotheses(options) <= 50 + 5 * 30);
  const int sigma_assumed = hypotheses(options);
  options.sigma_prior = 30.0;
  CHECK(hypotheses(options) > sigma_assumed);
  CHECK(hypotheses(options) <= sigma_assumed + 100);
  options = Plain();
  options.local_optimization = LocalOptimization::kInnerSamples;
  const int optimized = hypotheses(options);
  CHECK(optimized > 50);
  CHECK((optimized - 50) <= 50 * 10 * 5);
  options.local_samples = 0;
  CHECK(hypotheses(options) == 50);
}

}  // namespace
}  // namespace diffsac
