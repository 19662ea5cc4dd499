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

/// Points of two motions: 60 that the first sees before both cameras, and 66 of the second, 33 of them behind its first
/// camera. In normalised coordinates, and in pixels of `camera`.
struct TwoMotions {
  Matrix3Parameters sound, unsound;
  Eigen::Matrix3d camera{{800.0, 0.0, 500.0}, {0.0, 800.0, 400.0}, {0.0, 0.0, 1.0}};
  PointMatrix normalized{126, 4}, pixels{126, 4};

  explicit TwoMotions(Rng& rng) {
    const RelativePose poses[] = {testing::RandomPose(rng), testing::RandomPose(rng)};
    for (int i = 0; i < 126; ++i) {
      const RelativePose& pose = poses[i < 60 ? 0 : 1];
      const double depth = rng.Uniform(3.0, 8.0) * (i < 93 ? 1.0 : -1.0);
      const Eigen::Vector3d first(depth * rng.Uniform(-0.5, 0.5), depth * rng.Uniform(-0.5, 0.5), depth);
      const Eigen::Vector3d second = pose.rotation * first + pose.translation;
      normalized.row(i) << first.hnormalized().transpose(), second.hnormalized().transpose();
      pixels.row(i) << (camera * first).hnormalized().transpose(), (camera * second).hnormalized().transpose();
    }
    sound = AsParameters(EssentialFromPose(poses[0])).normalized();
    unsound = AsParameters(EssentialFromPose(poses[1])).normalized();
  }
  Matrix3Parameters InPixels(const Matrix3Parameters& e) const {
    return AsParameters(FundamentalFromEssential(AsMatrix(e), camera, camera)).normalized();
  }
};

/// The chosen one of two given models.
template <class Model>
ConsensusResult Chosen(const PointMatrix& points, double threshold, const Matrix3Parameters& first,
                       const Matrix3Parameters& second, ConsensusOptions options,
                       const std::optional<CameraPrior>& cameras) {
  EstimationPriors priors;
  priors.models = {first, second};
  priors.cameras = cameras;
  options.refit_candidates = 2;
  return testing::SearchSets<Model>(points, threshold, {}, options, Rng(1), priors);
}

TEST_CASE("Inliers behind a camera do not count in the choice, where cheirality is asked for") {
  Rng rng(3);
  for (int trial = 0; trial < 10; ++trial) {
    const TwoMotions motions(rng);
    const Matrix3Parameters f = motions.InPixels(motions.sound), wrong = motions.InPixels(motions.unsound);
    const CameraPrior cameras{motions.camera, motions.camera, 0.3};
    ConsensusOptions options;
    options.score = options.final_score = ScoreKind::kMsac;
    options.refit = Refit::kNone;
    options.refine_finalists = trial % 2;
    options.final_refinement = trial % 2 == 0 ? FinalRefinement::kNone : FinalRefinement::kRefinement;
    const auto e_of = [&] {
      return Chosen<Essential>(motions.normalized, 1e-3, motions.sound, motions.unsound, options, std::nullopt);
    };
    const auto f_of = [&](const std::optional<CameraPrior>& known) {
      return Chosen<Fundamental>(motions.pixels, 0.8, f, wrong, options, known);
    };
    // The second motion has more inliers.
    for (const auto& plain : {e_of(), f_of(cameras)}) {
      REQUIRE(plain.status == Status::kOk);
      CHECK(plain.inliers[70] == 1);
      CHECK(plain.inliers[100] == 1);
    }
    options.cheirality = true;
    for (const auto& chosen : {e_of(), f_of(cameras)}) {
      REQUIRE(chosen.status == Status::kOk);
      CHECK(std::count(chosen.inliers.begin(), chosen.inliers.begin() + 60, 1) == 60);
      // The score itself is that of the model, whatever lies where.
      CHECK(chosen.score == Approx(60.0).margin(10.0));
    }
    // Nothing is known of the cameras: the score alone chooses.
    CHECK(f_of(std::nullopt).inliers[100] == 1);
  }
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
