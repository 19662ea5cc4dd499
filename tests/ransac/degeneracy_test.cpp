// A dominant plane: where the plain loop finds the plane and any epipole, the degeneracy hook finds both.

#include <algorithm>
#include <catch2/catch.hpp>
#include <utility>

#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/ransac/instantiate.h"
#include "diffsac/ransac/samplers/make_minimal_sampler.h"
#include "geometry/planar_scene.h"
#include "geometry/two_view_problems.h"
#include "ransac/random_problems.h"

namespace diffsac {
namespace {

using testing::SearchUniformly;

/// A model without its degeneracy hook.
template <class Model>
struct Plain {
  using Parameters = typename Model::Parameters;
  static constexpr int kDimension = Model::kDimension;
  static constexpr int kMinimalSize = Model::kMinimalSize;
  static constexpr int kMaxSolutions = Model::kMaxSolutions;
  static int SolveMinimal(const PointMatrix& points, const int* set, Parameters* out) {
    return Model::SolveMinimal(points, set, out);
  }
  static bool Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out) {
    return Model::Fit(points, weights, out);
  }
  static bool Determined(const PointMatrix& points) { return Model::Determined(points); }
  static bool Refine(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                     Parameters* model, int steps) {
    return Model::Refine(points, weights, loss, model, steps);
  }
  static double Residual(const Parameters& model, const double* point) { return Model::Residual(model, point); }
};
using PlainFundamental = Plain<Fundamental>;
using PlainFundamental8 = Plain<Fundamental8>;
static_assert(HasDegeneracyRecovery<Fundamental> && HasDegeneracyRecovery<Fundamental8>);
static_assert(!HasDegeneracyRecovery<PlainFundamental>);

}  // namespace

DIFFSAC_INSTANTIATE_CONSENSUS(PlainFundamental)
DIFFSAC_INSTANTIATE_CONSENSUS(PlainFundamental8)

namespace {

using testing::MakePlanarScene;
using testing::PlanarScene;
using testing::PoseErrorDegrees;

constexpr double kThreshold = 2.0;

/// LO-RANSAC to a confidence of 99 %, Levenberg-Marquardt at the end.
ConsensusOptions Options() {
  ConsensusOptions options;
  options.score = options.final_score = ScoreKind::kMsac;
  options.score_threshold_factor = 1.5;
  options.local_optimization = LocalOptimization::kInnerSamples;
  options.stopping = Stopping::kConfidence;
  options.max_iterations = 500;
  options.refit = Refit::kNone;
  options.final_refinement = FinalRefinement::kRefinement;
  return options;
}

template <class Model>
int Successes(int count, double on_plane, double outliers, int scenes, const ConsensusOptions& options) {
  int good = 0;
  for (int i = 0; i < scenes; ++i) {
    Rng rng = Rng(7).Fork("scene", i);
    const PlanarScene scene = MakePlanarScene(count, on_plane, outliers, 0.5, rng);
    const ConsensusResult result = SearchUniformly<Model>(scene.views.pixels, kThreshold, options, Rng(i));
    good += result.status == Status::kOk && PoseErrorDegrees(scene.views, result.model, result.inliers) < 5.0 ? 1 : 0;
  }
  return good;
}

TEST_CASE("A dominant plane: the hook finds the pose where the plain loop does not") {
  struct Case {
    int count;
    double on_plane, outliers;
    int scenes, most_without, least;
  };
  for (const Case& c : {Case{200, 0.95, 0.0, 50, 49, 49}, Case{200, 0.95, 0.2, 50, 39, 44},
                        Case{200, 0.98, 0.0, 50, 36, 45}, Case{1000, 0.98, 0.2, 25, 19, 24}}) {
    CAPTURE(c.count, c.on_plane, c.outliers);
    CHECK(Successes<Fundamental>(c.count, c.on_plane, c.outliers, c.scenes, Options()) >= c.least);
    CHECK(Successes<Fundamental8>(c.count, c.on_plane, c.outliers, c.scenes, Options()) >= c.least - 2);
    CHECK(Successes<PlainFundamental>(c.count, c.on_plane, c.outliers, c.scenes, Options()) <= c.most_without);
    CHECK(Successes<PlainFundamental8>(c.count, c.on_plane, c.outliers, c.scenes, Options()) <= c.most_without);
  }
}

/// Plain RANSAC: inlier count, no local optimisation, least squares on the inliers.
ConsensusOptions PlainRansac() {
  ConsensusOptions options;
  options.stopping = Stopping::kConfidence;
  options.max_iterations = 500;
  return options;
}

// COLMAP's figures for its own scenes of this kind (pull request 4520; poses within 5 degrees, LO-RANSAC to DEGENSAC):
// 200 points, 95 % on a plane: 39.7 to 100 %; with 20 % outliers 28.7 to 98.7 %; 98 % on a plane 9.7 to 96.3 %;
// 1000 points, 95 % and 20 % outliers 42.7 to 100 %.
TEST_CASE("A dominant plane: plain RANSAC fails where DEGENSAC recovers F") {
  struct Case {
    int count;
    double on_plane, outliers;
    int least;
  };
  for (const Case& c :
       {Case{200, 0.95, 0.0, 49}, Case{200, 0.95, 0.2, 43}, Case{200, 0.98, 0.0, 43}, Case{1000, 0.95, 0.2, 49}}) {
    CAPTURE(c.count, c.on_plane, c.outliers);
    CHECK(Successes<Fundamental>(c.count, c.on_plane, c.outliers, 50, PlainRansac()) >= c.least);
    CHECK(Successes<PlainFundamental>(c.count, c.on_plane, c.outliers, 50, PlainRansac()) <= 12);
    CHECK(Successes<PlainFundamental8>(c.count, c.on_plane, c.outliers, 50, PlainRansac()) <= 12);
  }
}

TEST_CASE("Without a dominant plane the hook costs nothing in accuracy") {
  const int mended = Successes<Fundamental>(200, 0.0, 0.3, 50, Options());
  const int plain = Successes<PlainFundamental>(200, 0.0, 0.3, 50, Options());
  CHECK(mended >= plain - 1);
  CHECK(mended >= 47);
}

TEST_CASE("A scene that is one plane: an F that fits it, and no invented support") {
  for (int trial = 0; trial < 20; ++trial) {
    Rng rng = Rng(8).Fork("scene", trial);
    const PlanarScene scene = MakePlanarScene(100, 1.0, 0.0, 0.5, rng);
    const PointMatrix& points = scene.views.pixels;
    const auto mended = SearchUniformly<Fundamental>(points, kThreshold, Options(), Rng(trial));
    const auto plain = SearchUniformly<PlainFundamental>(points, kThreshold, Options(), Rng(trial));
    REQUIRE(mended.status == Status::kOk);
    CHECK(mended.inliers == InlierMask<Fundamental>(points, mended.model, kThreshold));
    CHECK(std::count(mended.inliers.begin(), mended.inliers.end(), 1) >= 95);
    // Nothing lies off the plane, so there was nothing to mend.
    CHECK(mended.model == plain.model);
    CHECK(mended.score == plain.score);
  }
}

TEST_CASE("Mending changes nothing in the loop's determinism") {
  Rng rng(9);
  const PlanarScene scene = MakePlanarScene(300, 0.95, 0.3, 0.5, rng);
  for (const LocalOptimization optimizer :
       {LocalOptimization::kNone, LocalOptimization::kInnerSamples, LocalOptimization::kRefinement}) {
    ConsensusOptions options = Options();
    options.local_optimization = optimizer;
    options.max_iterations = 200;
    const auto run = [&](int threads, int block) {
      options.block_size = block;
      return SearchUniformly<Fundamental>(scene.views.pixels, kThreshold, options, Rng(3), {}, threads);
    };
    const ConsensusResult one = run(1, 0);
    REQUIRE(one.status == Status::kOk);
    for (const auto& [threads, block] : {std::pair{4, 0}, {1, 7}, {3, 64}}) {
      const ConsensusResult other = run(threads, block);
      CHECK(other.model == one.model);
      CHECK(other.inliers == one.inliers);
      CHECK(other.score == one.score);
      CHECK(other.hypotheses == one.hypotheses);
    }
  }
}

}  // namespace
}  // namespace diffsac
