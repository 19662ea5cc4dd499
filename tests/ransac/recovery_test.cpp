// What the loop is for: many random problems with noise and outliers, and the model must come out right.

#include <algorithm>
#include <catch2/catch.hpp>
#include <optional>

#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/ransac/local/final_refiner.h"
#include "diffsac/ransac/option_names.h"
#include "diffsac/ransac/sample_consensus.h"
#include "geometry/two_view_problems.h"
#include "ransac/random_problems.h"

namespace diffsac {
namespace {

using testing::AllSets;
using testing::MakeRandomProblem;
using testing::RandomProblem;
using testing::RandomSets;
using testing::SearchSets;
using testing::SearchUniformly;

constexpr double kThreshold = 0.1;
constexpr double kSigma = kThreshold / 3.0;

template <int D>
int CountRecovered(double outlier_ratio, int num_sets, const ConsensusOptions& options, double degrees) {
  int recovered = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const auto problem = MakeRandomProblem<D>(100, outlier_ratio, kSigma, Rng(trial).Fork("recovery"));
    const auto result =
        SearchSets<Hyperplane<D>>(problem.points, kThreshold, RandomSets(100, D, num_sets, trial), options, Rng(trial));
    if (result.status == Status::kOk && AngleBetweenDegrees(result.model, problem.truth) < degrees) ++recovered;
  }
  return recovered;
}

TEMPLATE_TEST_CASE_SIG("Models are recovered from 10 to 60 % outliers by every refit", "", ((int D), D), 2, 3) {
  for (const Refit refit : {Refit::kNone, Refit::kInliers, Refit::kIterated, Refit::kMixture}) {
    for (double ratio : {0.1, 0.3, 0.6}) {
      CAPTURE(ToString(refit), ratio);
      ConsensusOptions options;
      options.refit = refit;
      options.final_score = ScoreKind::kMsac;
      CHECK(CountRecovered<D>(ratio, 500, options, refit == Refit::kNone ? 3.0 : 1.5) >= 196);
    }
  }
}

TEST_CASE("Without noise the model is exact") {
  for (int trial = 0; trial < 50; ++trial) {
    const auto line = MakeRandomProblem<2>(60, 0.5, 0.0, Rng(trial));
    const auto found = SearchSets<Line>(line.points, 1e-6, AllSets(60, 2), {}, Rng(1));
    REQUIRE(found.status == Status::kOk);
    CHECK(AngleBetweenDegrees(found.model, line.truth) < 1e-6);
    const auto plane = MakeRandomProblem<3>(30, 0.4, 0.0, Rng(trial));
    const auto solved = SearchSets<Plane>(plane.points, 1e-6, AllSets(30, 3), {}, Rng(1));
    REQUIRE(solved.status == Status::kOk);
    CHECK(AngleBetweenDegrees(solved.model, plane.truth) < 1e-6);
  }
}

TEST_CASE("Expectation maximisation is more accurate than a refit on hard inliers at 80 % outliers") {
  ConsensusOptions hard, soft;
  hard.score = soft.score = ScoreKind::kMsac;
  hard.score_threshold_factor = soft.score_threshold_factor = 1.5;
  soft.refit = Refit::kMixture;
  const auto sets = AllSets(100, 2);
  int hard_good = 0, soft_good = 0, soft_better = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const auto problem = MakeRandomProblem<2>(100, 0.8, kSigma, Rng(trial).Fork("refit"));
    const auto a = SearchSets<Line>(problem.points, kThreshold, sets, hard, Rng(1));
    const auto b = SearchSets<Line>(problem.points, kThreshold, sets, soft, Rng(1));
    const double hard_error = AngleBetweenDegrees(a.model, problem.truth);
    const double soft_error = AngleBetweenDegrees(b.model, problem.truth);
    hard_good += hard_error < 0.25;
    soft_good += soft_error < 0.25;
    soft_better += soft_error < hard_error;
  }
  CAPTURE(hard_good, soft_good, soft_better);
  CHECK(soft_good > hard_good);
  CHECK(soft_better > 265);
}

/// Mean angular error, in degrees, over problems whose σ is `sigma`; every one is told kSigma.
template <int D>
double MeanErrorOfRefit(double sigma, double sigma_prior) {
  ConsensusOptions options;
  options.score = options.final_score = ScoreKind::kMlesac;
  options.refit = Refit::kMixture;
  options.refit_candidates = 5;
  options.sigma_prior = sigma_prior;
  double sum = 0.0;
  for (int trial = 0; trial < 300; ++trial) {
    const auto problem = MakeRandomProblem<D>(100, 0.5, sigma, Rng(trial).Fork("sigma"));
    const auto result =
        SearchSets<Hyperplane<D>>(problem.points, kThreshold, RandomSets(100, D, 400, trial), options, Rng(1));
    sum += AngleBetweenDegrees(result.model, problem.truth);
  }
  return sum / 300.0;
}

// At twice the noise that it was told the refit lost to a plain RANSAC.
TEMPLATE_TEST_CASE_SIG("Estimating sigma mends a refit that was told half of it and costs nothing when it was right",
                       "", ((int D), D), 2, 3) {
  const double told = MeanErrorOfRefit<D>(2.0 * kSigma, 0.0), estimated = MeanErrorOfRefit<D>(2.0 * kSigma, 30.0);
  CAPTURE(told, estimated);
  CHECK(estimated < 0.9 * told);
  const double right = MeanErrorOfRefit<D>(kSigma, 0.0), needless = MeanErrorOfRefit<D>(kSigma, 30.0);
  CAPTURE(right, needless);
  CHECK(needless < 1.02 * right);
}

ConsensusOptions OverScales(FinalRefinement refinement) {
  ConsensusOptions options;
  options.score = options.final_score = ScoreKind::kSigmaMarginalisedMsac;
  options.threshold = ThresholdKind::kAdaptive;
  options.local_optimization = LocalOptimization::kInnerSamples;
  options.refit = Refit::kIterated;
  options.refit_rounds = 5;
  options.refit_candidates = 10;
  options.final_refinement = refinement;
  options.max_iterations = 200;
  return options;
}

template <class Model>
struct Compared {
  double staged = 0.0, all = 0.0;
  std::int64_t staged_fits = 0, all_fits = 0;

  void Add(const PointMatrix& points, double threshold, int seed) {
    ConsensusOptions options = OverScales(FinalRefinement::kMarginalised);
    const auto every = SearchUniformly<Model>(points, threshold, options, Rng(seed));
    options.num_finalists = 3;
    const auto best = SearchUniformly<Model>(points, threshold, options, Rng(seed));
    REQUIRE(every.status == Status::kOk);
    REQUIRE(best.status == Status::kOk);
    CHECK(best.score >= 0.95 * every.score);
    staged += best.score;
    all += every.score;
    staged_fits += best.hypotheses;
    all_fits += every.hypotheses;
    // As many finalists as candidates leave nothing out.
    options.num_finalists = 10;
    CHECK(SearchUniformly<Model>(points, threshold, options, Rng(seed)).model == every.model);
    // Nor is there anything to stage without a refinement.
    options = OverScales(FinalRefinement::kNone);
    const auto refitted = SearchUniformly<Model>(points, threshold, options, Rng(seed));
    options.num_finalists = 3;
    CHECK(SearchUniformly<Model>(points, threshold, options, Rng(seed)).model == refitted.model);
  }
};

TEST_CASE("The best three of ten, refined to the end, score as the best of ten for fewer fits") {
  Rng rng(1);
  Compared<Fundamental> f;
  Compared<Essential> e;
  for (int seed = 0; seed < 10; ++seed) {
    auto problem = RandomProblem(200, rng, 0.7);
    for (int i = 0; i < 80; ++i) problem.pixels(i, 2) += 100.0 * rng.Normal();
    f.Add(problem.pixels, 2.0, seed);
    e.Add(NormalizedCoordinates(problem.pixels, problem.k1, problem.k2), 2.0 / MeanFocal(problem.k1, problem.k2), seed);
  }
  CHECK(f.staged >= 0.99 * f.all);
  CHECK(e.staged >= 0.99 * e.all);
  CHECK(f.staged_fits < f.all_fits);
  CHECK(e.staged_fits < e.all_fits);
}

TEST_CASE("In stages as without: points that determine nothing have no model") {
  ConsensusOptions options = OverScales(FinalRefinement::kMarginalised);
  options.num_finalists = 3;
  for (const int count : {0, 1, 6, 7, 20}) {
    const PointMatrix same = PointMatrix::Constant(count, 4, 3.0);
    CHECK(SearchUniformly<Fundamental>(same, 1.0, options, Rng(1)).status != Status::kOk);
    const PointMatrix nan = PointMatrix::Constant(count, 4, std::nan(""));
    CHECK(SearchUniformly<Fundamental>(nan, 1.0, options, Rng(1)).status != Status::kOk);
  }
  Rng rng(5);
  const auto exact = RandomProblem(7, rng);
  const auto result = SearchUniformly<Fundamental>(exact.pixels, 1.0, options, Rng(1));
  CHECK((result.status == Status::kOk || result.model.size() == 0));
}

}  // namespace
}  // namespace diffsac
