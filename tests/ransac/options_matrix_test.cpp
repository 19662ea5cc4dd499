// What must hold for every score and optimiser on lines and planes: stages only improve, useless thresholds do no harm.
// all_models_test.cpp has what all models and sources share.

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "diffsac/ransac/option_names.h"
#include "diffsac/ransac/sample_consensus.h"
#include "lab/config/yaml.h"
#include "lab/options/options.h"
#include "ransac/all_models.h"
#include "ransac/random_problems.h"

namespace diffsac {
namespace {

using testing::kScores;
using testing::MakeRandomProblem;
using testing::SearchUniformly;

constexpr double kThreshold = 0.1;

TEST_CASE("No optimiser lowers the score that chose the model, and each raises it on the whole") {
  for (const ScoreKind score : {ScoreKind::kInlierCount, ScoreKind::kMsac, ScoreKind::kMagsac})
    for (const LocalOptimization optimizer :
         {LocalOptimization::kInnerSamples, LocalOptimization::kReweighted, LocalOptimization::kGraphCut}) {
      double gain = 0.0;
      for (int trial = 0; trial < 40; ++trial) {
        const auto problem = MakeRandomProblem<3>(100, 0.5, 0.04, Rng(trial));
        ConsensusOptions options;
        options.refit = Refit::kNone;
        options.score = options.final_score = score;
        options.max_iterations = 100;
        const auto run = [&] { return SearchUniformly<Plane>(problem.points, kThreshold, options, Rng(trial)); };
        const auto plain = run();
        options.local_optimization = optimizer;
        const auto optimized = run();
        CHECK(optimized.score >= plain.score);
        CHECK(optimized.hypotheses > plain.hypotheses);
        CHECK(optimized.iterations == 100);
        gain += optimized.score - plain.score;
      }
      CAPTURE(ToString(score), ToString(optimizer));
      CHECK(gain > 0.0);
    }
}

TEST_CASE("No refit of many rounds lowers the final score") {
  for (const ScoreKind score : kScores)
    for (int trial = 0; trial < 40; ++trial) {
      const auto problem = MakeRandomProblem<2>(100, 0.7, 0.04, Rng(trial));
      ConsensusOptions options;
      options.refit = Refit::kNone;
      options.score = ScoreKind::kMsac;
      options.final_score = score;
      options.max_iterations = 100;
      options.refit_rounds = 5;
      const auto run = [&] { return SearchUniformly<Line>(problem.points, kThreshold, options, Rng(1)); };
      const double plain = run().score;
      for (const Refit refit : {Refit::kReweighted, Refit::kIterated}) {
        CAPTURE(ToString(score), ToString(refit));
        options.refit = refit;
        CHECK(run().score >= (1.0 - 1e-12) * plain);  // Sums of the same residuals in another order.
      }
    }
}

TEST_CASE("MAGSAC++ is more accurate than a plain search, most of all where the threshold is too tight for the noise") {
  for (const double sigma : {kThreshold / 3.0, 0.6 * kThreshold}) {
    double plain_error = 0.0, magsac_error = 0.0, cut_error = 0.0;
    for (int trial = 0; trial < 150; ++trial) {
      const auto problem = MakeRandomProblem<3>(150, 0.6, sigma, Rng(trial).Fork("magsac"));
      const auto error = [&](ConsensusOptions options) {
        options.max_iterations = 300;
        const auto result = SearchUniformly<Plane>(problem.points, kThreshold, options, Rng(trial));
        return AngleBetweenDegrees(result.model, problem.truth);
      };
      ConsensusOptions options;
      plain_error += error(options);
      options.score = options.final_score = ScoreKind::kMagsac;
      options.score_threshold_factor = 2.0;
      options.local_optimization = LocalOptimization::kReweighted;
      options.refit = Refit::kReweighted;
      magsac_error += error(options);
      options.local_optimization = LocalOptimization::kGraphCut;
      cut_error += error(options);
    }
    CAPTURE(sigma, plain_error, magsac_error, cut_error);
    const double share = sigma > 0.5 * kThreshold ? 0.85 : 0.97;
    CHECK(magsac_error < share * plain_error);
    CHECK(cut_error < share * plain_error);
  }
}

TEST_CASE("Useless thresholds give no model") {
  const PointMatrix points = MakeRandomProblem<2>(30, 0.5, 0.03, Rng(5)).points;
  for (double threshold :
       {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    CHECK(SearchUniformly<Line>(points, threshold, {}, Rng(1)).status == Status::kNoModel);
  for (double threshold : {1e-300, 1e-12, 1e12, 1e300})
    for (const ScoreKind score : kScores) {
      ConsensusOptions options;
      options.score = options.final_score = score;
      options.local_optimization = LocalOptimization::kReweighted;
      options.max_iterations = 50;
      const auto result = SearchUniformly<Line>(points, threshold, options, Rng(1));
      CHECK((result.status == Status::kOk || result.status == Status::kNoModel));
      CHECK(result.model.allFinite());
    }
}

TEST_CASE("Consensus options are read from YAML and come back out") {
  const ConsensusOptions defaults;
  CHECK(defaults.score == ScoreKind::kInlierCount);
  CHECK(defaults.local_optimization == LocalOptimization::kNone);
  CHECK(defaults.refit == Refit::kInliers);
  CHECK(defaults.stopping == Stopping::kBudget);
  CHECK(defaults.final_refinement == FinalRefinement::kNone);
  const auto options =
      ReadOptions<ConsensusOptions>(ConfigFromYaml("score: magsac_pp\nresidual_dof: 4\nlocal_optimization: gc_ransac\n"
                                                   "stopping: confidence\nconfidence: 0.999\n"
                                                   "max_iterations: 7\nmin_iterations: 3\nrefit: irls\n"
                                                   "final_refinement: lm\n"));
  CHECK(options.residual_dof == 4);
  CHECK(options.max_iterations == 7);
  CHECK(WriteYaml(ReadOptions<ConsensusOptions>(ToConfig(options))) == WriteYaml(options));
  // What memory is asked for in proportion to.
  for (const char* huge : {"max_iterations: 1000000000", "refit_candidates: 1000000000"})
    CHECK_THROWS_WITH(ReadOptions<ConsensusOptions>(ConfigFromYaml(huge)), Catch::Contains("expected an integer from"));
  for (const char* wrong : {"refit: least\n", "refit_candidates: 0\n", "refits: em\n", "confidence: 1\n",
                            "residual_dof: 7\n", "max_iterations: 0\n", "stopping: ever\n", "final_refinement: yes\n"})
    CHECK_THROWS_AS(ReadOptions<ConsensusOptions>(ConfigFromYaml(wrong)), Error);
}

}  // namespace
}  // namespace diffsac
