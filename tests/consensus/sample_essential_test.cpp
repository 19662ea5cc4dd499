#include <catch2/catch.hpp>
#include <limits>

#include "diffsac/consensus/two_view_consensus.h"
#include "diffsac/geometry/pose.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

ConsensusOptions Options() {
  ConsensusOptions options;
  options.score = options.final_score = "msac";
  options.max_iterations = 200;
  return options;
}

TEST_CASE("An essential matrix from pixels is the one from normalised coordinates") {
  Rng rng(3);
  for (int trial = 0; trial < 10; ++trial) {
    auto problem = testing::RandomProblem(80, rng, 0.3);
    for (int i = 0; i < 20; ++i) problem.pixels(i, 3) += rng.Uniform(30.0, 200.0);
    const ConsensusResult found =
        SampleEssential(problem.pixels, problem.k1, problem.k2, 1.5, UniformSource(), Options(), Rng(trial));
    REQUIRE(found.status == Status::kOk);
    const ConsensusResult same = SampleConsensus<Essential>(
        NormalizedCoordinates(problem.pixels, problem.k1, problem.k2), 1.5 / MeanFocal(problem.k1, problem.k2),
        UniformSource(), Options(), Rng(trial));
    CHECK(found.model == same.model);
    CHECK(found.inliers == same.inliers);
    const auto pose = ChoosePose(AsMatrix(Matrix3Parameters(found.model)),
                                 NormalizedCoordinates(problem.pixels, problem.k1, problem.k2), found.inliers);
    CHECK(RotationAngleDegrees(pose.pose.rotation, problem.pose.rotation) < 2.0);
  }
}

TEST_CASE("Calibration that is none gives a status") {
  Rng rng(4);
  const auto problem = testing::RandomProblem(30, rng);
  const auto status = [&](const PointMatrix& pixels, const Eigen::Matrix3d& k1) {
    return SampleEssential(pixels, k1, problem.k2, 1.0, UniformSource(), Options(), Rng(1)).status;
  };
  CHECK(status(problem.pixels, problem.k1) == Status::kOk);
  CHECK(status(problem.pixels, Eigen::Matrix3d::Zero()) == Status::kDegenerate);
  CHECK(status(problem.pixels, -problem.k1 * 10.0) == Status::kDegenerate);
  Eigen::Matrix3d not_finite = problem.k1;
  not_finite(0, 2) = std::numeric_limits<double>::quiet_NaN();
  CHECK(status(problem.pixels, not_finite) == Status::kDegenerate);
  CHECK(status(problem.pixels.topRows(4), problem.k1) == Status::kTooFewPoints);
  CHECK(status(PointMatrix(), problem.k1) == Status::kTooFewPoints);
  CHECK(status(PointMatrix::Ones(30, 3), problem.k1) == Status::kDegenerate);
}

}  // namespace
}  // namespace diffsac
