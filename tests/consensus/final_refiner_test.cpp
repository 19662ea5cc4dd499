// Refinement in stages: all candidates by a few steps, the best of them to the end.

#include "diffsac/consensus/local/final_refiner.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <optional>

#include "consensus/search.h"
#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

using testing::RandomProblem;
using testing::SearchUniformly;

ConsensusOptions OverScales(FinalRefinement refinement) {
  ConsensusOptions options;
  options.score = options.final_score = ScoreKind::kMarginalised;
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
    options.refine_finalists = 3;
    const auto best = SearchUniformly<Model>(points, threshold, options, Rng(seed));
    REQUIRE(every.status == Status::kOk);
    REQUIRE(best.status == Status::kOk);
    CHECK(best.score >= 0.95 * every.score);
    staged += best.score;
    all += every.score;
    staged_fits += best.hypotheses;
    all_fits += every.hypotheses;
    // As many finalists as candidates leave nothing out.
    options.refine_finalists = 10;
    CHECK(SearchUniformly<Model>(points, threshold, options, Rng(seed)).model == every.model);
    // Nor is there anything to stage without a refinement.
    options = OverScales(FinalRefinement::kNone);
    const auto refitted = SearchUniformly<Model>(points, threshold, options, Rng(seed));
    options.refine_finalists = 3;
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
  options.refine_finalists = 3;
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
