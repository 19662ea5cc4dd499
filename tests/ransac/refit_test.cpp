// A refit makes an estimate better or is left out.

#include <algorithm>
#include <catch2/catch.hpp>

#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "geometry/planar_scene.h"
#include "ransac/random_problems.h"

namespace diffsac {
namespace {

using testing::MakePlanarScene;
using testing::SearchUniformly;

int Inliers(const ConsensusResult& result) {
  return static_cast<int>(std::count(result.inliers.begin(), result.inliers.end(), 1));
}

TEST_CASE("the default refit does not ruin essential matrices (21 inliers of 1068 were left)") {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed);
    const auto scene = MakePlanarScene(1000, 0.97, 0.4, 0.5, rng);
    const double threshold = 1.0 / MeanFocal(scene.views.k1, scene.views.k2);
    ConsensusOptions options, unrefined;
    unrefined.refit = Refit::kNone;
    const auto refined = SearchUniformly<Essential>(scene.views.normalized, threshold, options, Rng(seed));
    const auto plain = SearchUniformly<Essential>(scene.views.normalized, threshold, unrefined, Rng(seed));
    REQUIRE(refined.status == Status::kOk);
    CAPTURE(seed, Inliers(plain), Inliers(refined));
    CHECK(Inliers(refined) >= 0.97 * Inliers(plain));
  }
}

/// Points of a plane as a model whose least squares are wrong: what a refit must not keep.
struct WronglyFitted : Plane {
  static bool Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out) {
    if (!Plane::Fit(points, weights, out)) return false;
    (*out)[kDimension] += 0.3;
    return true;
  }
};

}  // namespace
}  // namespace diffsac

#include "diffsac/ransac/instantiate.h"

namespace diffsac {
DIFFSAC_INSTANTIATE_CONSENSUS(WronglyFitted)

namespace {

TEST_CASE("a refit that makes the model worse is left out, whichever it is") {
  const auto problem = testing::MakeRandomProblem<3>(100, 0.3, 0.02, Rng(3));
  for (const Refit refit : {Refit::kInliers, Refit::kIterated, Refit::kMixture, Refit::kReweighted}) {
    ConsensusOptions options;
    options.score = options.final_score = ScoreKind::kMsac;
    options.sigma_prior = refit == Refit::kMixture ? 30.0 : 0.0;
    options.max_iterations = 200;
    options.refit = Refit::kNone;
    const auto plain = SearchUniformly<WronglyFitted>(problem.points, 0.1, options, Rng(1));
    options.refit = refit;
    CHECK(SearchUniformly<WronglyFitted>(problem.points, 0.1, options, Rng(1)).model == plain.model);
  }
}

}  // namespace
}  // namespace diffsac
