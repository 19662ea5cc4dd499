// Searches that need no threshold, and what else scores may know: priors of the points, cameras that are likely.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "diffsac/geometry/hyperplane.h"
#include "diffsac/ransac/scores/scorer.h"
#include "geometry/two_view_problems.h"
#include "lab/config/yaml.h"
#include "lab/options/options.h"
#include "ransac/all_models.h"
#include "ransac/random_problems.h"

namespace diffsac {
namespace {

using testing::MakeModelProblem;
using testing::ModelProblem;
using testing::SearchUniformly;

/// least and greatest: of the scales, in the unit of the points.
ConsensusOptions OverScales(double least, double greatest) {
  ConsensusOptions options;
  options.score = options.final_score = ScoreKind::kSigmaMarginalisedMsac;
  options.threshold = ThresholdKind::kAdaptive;
  options.least_scale = least;
  options.greatest_scale = greatest;
  options.local_optimization = LocalOptimization::kInnerSamples;
  options.refit = Refit::kIterated;
  options.refit_rounds = 5;
  options.final_refinement = FinalRefinement::kMarginalised;
  options.max_iterations = 300;
  return options;
}

TEMPLATE_TEST_CASE("With the scales given and the noise estimated, ε is the mask's limit and nothing else", "", Line,
                   Plane, Homography, Fundamental, Fundamental8, Essential, AbsolutePose) {
  const ModelProblem problem = MakeModelProblem<TestType>(150, 0.3, Rng(1));
  const ConsensusOptions options = OverScales(0.25 * problem.threshold, 2.0 * problem.threshold);
  const ConsensusResult result = SearchUniformly<TestType>(problem.points, 2.0 * problem.threshold, options, Rng(2));
  REQUIRE(result.status == Status::kOk);
  const typename TestType::Parameters model = result.model;
  const auto count = [](const ConsensusResult& r) { return std::count(r.inliers.begin(), r.inliers.end(), 1); };
  CHECK(count(result) > 75);
  for (const double factor : {0.1, 0.5, 1.0, 100.0}) {
    const double threshold = factor * problem.threshold;
    const ConsensusResult other = SearchUniformly<TestType>(problem.points, threshold, options, Rng(2));
    REQUIRE(other.model == result.model);
    CHECK(other.score == result.score);
    CHECK(count(other) <= count(result));
    for (Eigen::Index i = 0; i < problem.points.rows(); ++i)
      if (other.inliers[i])
        CHECK(TestType::Residual(model, problem.points.data() + i * TestType::kDimension) <= threshold);
  }
}

TEST_CASE("The mask's threshold follows the noise") {
  for (const double noise : {0.25, 0.5, 1.0}) {
    Rng rng(4);
    const testing::TwoViewProblem views = testing::RandomProblem(400, rng, noise);
    const ConsensusResult result = SearchUniformly<Fundamental>(views.pixels, 8.0, OverScales(0.25, 8.0), Rng(1));
    REQUIRE(result.status == Status::kOk);
    const Fundamental::Parameters model = result.model;
    double largest = 0.0;
    for (int i = 0; i < 400; ++i)
      if (result.inliers[i]) largest = std::max(largest, Fundamental::Residual(model, views.pixels.data() + 4 * i));
    // Noise of σ on each coordinate is a Sampson distance of σ.
    CHECK(largest == Approx(2.5 * noise).epsilon(0.25));
  }
}

TEST_CASE("Points of low prior count less, in the score and for the model") {
  const ModelProblem problem = MakeModelProblem<Line>(100, 0.5, Rng(5));
  ConsensusOptions options = OverScales(0.02, 0.2);
  EstimationPriors priors;
  priors.inlier_priors = Eigen::VectorXd::Constant(100, 0.5);
  const auto plain = SearchUniformly<Line>(problem.points, 0.1, options, Rng(1), priors);
  options.inlier_prior_power = 1.0;
  const auto halved = SearchUniformly<Line>(problem.points, 0.1, options, Rng(1), priors);
  CHECK(halved.score == Approx(0.5 * plain.score));
  options.inlier_prior_power = 2.0;
  CHECK(SearchUniformly<Line>(problem.points, 0.1, options, Rng(1), priors).score == Approx(0.25 * plain.score));
  // A second line with as many points: the prior decides.
  PointMatrix points(100, 2);
  for (int i = 0; i < 100; ++i) points.row(i) << 0.1 * (i % 50), i < 50 ? 1.0 : 0.05 * (i % 50) - 3.0;
  for (const bool first : {true, false}) {
    for (int i = 0; i < 100; ++i) priors.inlier_priors[i] = (i < 50) == first ? 0.9 : 0.4;
    const auto chosen = SearchUniformly<Line>(points, 0.1, options, Rng(1), priors);
    CHECK(chosen.inliers[first ? 10 : 60] == 1);
    CHECK(chosen.inliers[first ? 60 : 10] == 0);
  }
  // Unknown priors change nothing.
  CHECK(SearchUniformly<Line>(problem.points, 0.1, options, Rng(1)).score == plain.score);
}

TEST_CASE("Of two models with as many matches that is chosen with which keypoints turn") {
  Rng rng(7);
  const testing::TwoViewProblem one = testing::RandomProblem(60, rng, 0.2), two = testing::RandomProblem(60, rng, 0.2);
  PointMatrix points(120, 4);
  points << one.pixels, two.pixels;
  ConsensusOptions options = OverScales(0.5, 4.0);
  options.final_refinement = FinalRefinement::kMarginalised;
  options.max_iterations = 3000;
  const auto search = [&](const EstimationPriors& priors) {
    return SearchUniformly<Fundamental>(points, 1.0, options, Rng(1), priors);
  };
  const ConsensusResult plain = search({});
  for (const bool first : {true, false}) {
    EstimationPriors priors;
    priors.turns.resize(120, 2);
    for (int i = 0; i < 120; ++i) {
      const Matrix3Parameters& own = i < 60 ? one.fundamental : two.fundamental;
      const double* x = points.data() + 4 * i;
      double turn[2];
      // Those of one model turn as its lines do, those of the other one otherwise.
      for (double angle = 0.0; angle < 6.3; angle += 0.1) {
        turn[0] = std::cos(angle), turn[1] = std::sin(angle);
        if (TurnsAsLines(own.data(), x[0], x[1], x[2], x[3], turn) == ((i < 60) == first)) break;
      }
      priors.turns.row(i) << turn[0], turn[1];
    }
    options.keypoint_orientation_weight = 0.25;
    const ConsensusResult chosen = search(priors);
    REQUIRE(chosen.status == Status::kOk);
    const auto inliers = [&](int begin) {
      return std::count(chosen.inliers.begin() + begin, chosen.inliers.begin() + begin + 60, 1);
    };
    CHECK(inliers(first ? 0 : 60) > 50);
    CHECK(inliers(first ? 60 : 0) < 20);
    // At weight 1, and of another number of points, they say nothing.
    options.keypoint_orientation_weight = 1.0;
    CHECK(search(priors).score == plain.score);
    options.keypoint_orientation_weight = 0.25;
    priors.turns.conservativeResize(119, 2);
    CHECK(search(priors).score == plain.score);
  }
}

TEST_CASE("The cameras' prior divides scores of F, not those of models without the hook") {
  Rng rng(6);
  const testing::TwoViewProblem views = testing::RandomProblem(60, rng, 0.2);
  const Score score(ScoreKind::kMsac, 1.0, 0.3, 20.0);
  const Scorer<Fundamental> plain(views.pixels);
  const Matrix3Parameters model = views.fundamental;
  const auto scored = [&](const Eigen::Matrix3d& k1, const Eigen::Matrix3d& k2) {
    return Scorer<Fundamental>(views.pixels, {{}, CameraPrior{k1, k2, 0.5}})(model, score);
  };
  CHECK(scored(views.k1, views.k2) == Approx(plain(model, score)));
  Eigen::Matrix3d wrong = views.k1;
  wrong(0, 0) *= 3.0;
  wrong(1, 1) *= 3.0;
  const double mismatch = Fundamental::CameraMismatch(model, wrong, views.k2);
  CHECK(mismatch > 0.01);
  CHECK(scored(wrong, views.k2) == Approx(plain(model, score) / (1.0 + 0.5 * mismatch)));
  const Scorer<Essential> essential(views.normalized, {{}, CameraPrior{wrong, views.k2, 0.5}});
  CHECK(essential(views.essential, score) == Scorer<Essential>(views.normalized)(views.essential, score));
  // Giving up early decides as a full sum would.
  const Scorer<Fundamental> with(views.pixels, {{}, CameraPrior{wrong, views.k2, 0.5}});
  const double full = with(model, score);
  CHECK(with(model, score, 0.99 * full) == full);
  CHECK(with(model, score, full + 1.0) <= full + 1.0);
}

TEST_CASE("Options over scales are refused where they cannot act") {
  const auto read = [](const char* text) { return ReadOptions<ConsensusOptions>(ConfigFromYaml(text)); };
  CHECK(read("score: sigma_marginalised_msac\nleast_scale: 0.5\ngreatest_scale: 4\n").greatest_scale == 4.0);
  CHECK(read("threshold: adaptive\nleast_scale: 0.5\n").threshold == ThresholdKind::kAdaptive);
  CHECK(read("final_refinement: lm_marginalised\nleast_scale: 0.5\n").final_refinement ==
        FinalRefinement::kMarginalised);
  for (const char* wrong :
       {"least_scale: 0.5\n", "score: msac\ngreatest_scale: 2\n", "noise: known\n",
        "score: sigma_marginalised_msac\nleast_scale: 4\ngreatest_scale: 2\n", "camera_prior: -1\n"})
    CHECK_THROWS_AS(read(wrong), Error);
}

}  // namespace
}  // namespace diffsac
