// What must hold for every score and optimiser on lines and planes: masks that are the residuals' own, stages that only
// improve, and no harm from hostile input. all_models_test.cpp has what all models and sources share.

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>

#include "consensus/all_models.h"
#include "consensus/random_problems.h"
#include "consensus/search.h"
#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/consensus/samplers/make_minimal_sampler.h"
#include "lab/config/yaml.h"

namespace diffsac {
namespace {

using testing::AllSamplers;
using testing::kOptimizers;
using testing::kRefits;
using testing::kScores;
using testing::MakeRandomProblem;
using testing::SearchUniformly;

constexpr double kThreshold = 0.1;

void CheckSame(const ConsensusResult& a, const ConsensusResult& b) {
  CHECK(a.status == b.status);
  CHECK(a.model == b.model);
  CHECK(a.inliers == b.inliers);
  CHECK(a.score == b.score);
  CHECK(a.hypotheses == b.hypotheses);
  CHECK(a.iterations == b.iterations);
  CHECK(a.stop == b.stop);
  CHECK(a.unique_minimal_sets == b.unique_minimal_sets);
}

TEST_CASE("Same seed, same result; another seed, other sets") {
  const auto problem = MakeRandomProblem<2>(200, 0.6, 0.03, Rng(1));
  ConsensusOptions options;
  options.max_iterations = 20;
  options.refit = Refit::kNone;
  const auto run = [&](int seed) { return SearchUniformly<Line>(problem.points, kThreshold, options, Rng(seed)); };
  CheckSame(run(1), run(1));
  CHECK(run(1).model != run(2).model);
}

TEST_CASE("Masks are the residuals' own and scores the model's, for every combination") {
  const auto problem = MakeRandomProblem<2>(120, 0.5, 0.03, Rng(4));
  for (const ScoreKind score : kScores)
    for (const LocalOptimization optimizer : kOptimizers)
      for (const Refit refit : kRefits) {
        CAPTURE(ToString(score), ToString(optimizer), ToString(refit));
        ConsensusOptions options;
        options.score = score;
        options.final_score = ScoreKind::kInlierCount;
        options.local_optimization = optimizer;
        options.refit = refit;
        options.max_iterations = 200;
        const auto result = SearchUniformly<Line>(problem.points, kThreshold, options, Rng(1));
        REQUIRE(result.status == Status::kOk);
        int inliers = 0;
        for (int i = 0; i < 120; ++i) {
          const Line::Parameters model = result.model;
          const bool near = Line::Residual(model, problem.points.data() + 2 * i) <= kThreshold;
          REQUIRE(result.inliers[i] == (near ? 1 : 0));
          inliers += near;
        }
        CHECK(result.score == inliers);
        CHECK(AngleBetweenDegrees(result.model, problem.truth) < 2.0);
      }
}

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

TEST_CASE("A reweighted refit never lowers the final score") {
  for (const ScoreKind score : kScores)
    for (int trial = 0; trial < 40; ++trial) {
      const auto problem = MakeRandomProblem<2>(100, 0.6, 0.04, Rng(trial));
      ConsensusOptions options;
      options.refit = Refit::kNone;
      options.score = ScoreKind::kMsac;
      options.final_score = score;
      options.max_iterations = 100;
      const auto run = [&] { return SearchUniformly<Line>(problem.points, kThreshold, options, Rng(1)); };
      const double plain = run().score;
      options.refit = Refit::kReweighted;
      CHECK(run().score >= plain);
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

TEST_CASE("Hostile points give a status with every source, score and optimiser") {
  const PointMatrix good = MakeRandomProblem<2>(30, 0.5, 0.03, Rng(5)).points;
  std::vector<std::pair<PointMatrix, Status>> cases;
  for (int count : {0, 1}) cases.emplace_back(good.topRows(count), Status::kTooFewPoints);
  cases.emplace_back(PointMatrix(good.row(0).replicate(30, 1)), Status::kDegenerate);
  for (double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    PointMatrix broken = good;
    broken(3, 1) = bad;
    cases.emplace_back(broken, Status::kDegenerate);
  }
  for (double scale : {1.0, 1e-8, 1e8}) cases.emplace_back(scale * good, Status::kOk);
  cases.emplace_back(good.topRows(2), Status::kOk);
  PointMatrix twins = good;
  for (int i = 5; i < 30; ++i) twins.row(i) = twins.row(4);
  cases.emplace_back(twins, Status::kOk);
  PointMatrix collinear = good;
  collinear.col(1) = 2.0 * collinear.col(0);
  cases.emplace_back(collinear, Status::kOk);
  for (const auto& [points, expected] : cases) {
    const double scale = points.rows() > 2 && points.allFinite() ? points.cwiseAbs().maxCoeff() / 5.0 : 1.0;
    const std::vector<double> quality(points.rows(), 0.0);  // All weights zero, all qualities equal.
    const AllSamplers sources(points, 2, quality);
    for (const auto& [name, make] : sources) {
      if (name == "given") continue;  // Of refused points there may be no set to give.
      for (const ScoreKind score : kScores)
        for (const LocalOptimization optimizer : kOptimizers) {
          // Refused points are refused by every option alike: once is enough.
          if (expected != Status::kOk && optimizer != kOptimizers[0]) continue;
          ConsensusOptions options;
          options.score = options.final_score = score;
          options.local_optimization = optimizer;
          options.max_iterations = 30;
          options.refit = optimizer == LocalOptimization::kReweighted ? Refit::kReweighted : Refit::kMixture;
          options.final_refinement = FinalRefinement::kRefinement;
          EstimationPriors priors;
          priors.fit_weights = Eigen::VectorXd::Zero(points.rows());
          const auto source = make(1);
          const auto result = SampleConsensus<Line>(points, kThreshold * scale, *source, options, Rng(1), priors);
          CAPTURE(name, ToString(score), ToString(optimizer), points.rows(), scale);
          CHECK(result.status == expected);
          CHECK(result.model.size() == (expected == Status::kOk ? 3 : 0));
          CHECK(result.model.allFinite());
        }
    }
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

TEST_CASE("New options read from YAML and come back out; the defaults are the old ones") {
  const ConsensusOptions defaults;
  CHECK(defaults.score == ScoreKind::kInlierCount);
  CHECK(defaults.local_optimization == LocalOptimization::kNone);
  CHECK(defaults.refit == Refit::kInliers);
  CHECK(defaults.stopping == Stopping::kBudget);
  CHECK(defaults.final_refinement == FinalRefinement::kNone);
  const auto options = ReadOptions<ConsensusOptions>(
      ConfigFromYaml("score: magsac_pp\nresidual_dof: 4\nlocal_optimization: gc_ransac\ngraph_neighbors: 5\n"
                     "spatial_weight: 0.14\nstopping: confidence\nconfidence: 0.999\n"
                     "max_iterations: 7\nmin_iterations: 3\nrefit: irls\nirls_rounds: 4\n"
                     "final_refinement: lm\nblock_size: 16\n"));
  CHECK(options.residual_dof == 4);
  CHECK(options.max_iterations == 7);
  CHECK(WriteYaml(ReadOptions<ConsensusOptions>(ToConfig(options))) == WriteYaml(options));
  for (const char* wrong : {"confidence: 1\n", "residual_dof: 7\n", "max_iterations: 0\n", "stopping: ever\n",
                            "final_refinement: yes\n", "spatial_weight: -1\n", "irls_rounds: 0\n"})
    CHECK_THROWS_AS(ReadOptions<ConsensusOptions>(ConfigFromYaml(wrong)), Error);
}

}  // namespace
}  // namespace diffsac
