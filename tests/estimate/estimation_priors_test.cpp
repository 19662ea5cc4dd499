#include "diffsac/estimate/estimation_priors.h"

#include <catch2/catch.hpp>

#include "diffsac/problem/match_probabilities.h"
#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

Problem MakeProblem() {
  Problem problem;
  problem.task = Task::kFundamental;
  problem.points = PointMatrix::Random(10, 4);
  problem.size1 = {800, 600};
  problem.size2 = {300, 400};
  problem.snn_ratio = Eigen::VectorXd::LinSpaced(10, 0.1, 1.0);
  return problem;
}

TEST_CASE("A search is told of cameras and priors where they are asked for and known") {
  Problem problem = MakeProblem();
  ConsensusOptions options;
  const auto known = [&] { return PriorsOfProblem(NormalizedProblem(problem), options); };
  CHECK_FALSE(known().cameras);
  CHECK(known().inlier_priors.size() == 0);
  options.camera_prior = 0.3;
  options.inlier_prior_power = 1.0;
  REQUIRE(known().cameras);
  CHECK(known().cameras->strength == 0.3);
  CHECK(known().cameras->K1(0, 0) == kUsualFocal * 800.0);
  CHECK(known().cameras->K2(1, 1) == kUsualFocal * 400.0);
  CHECK(known().cameras->K1(0, 2) == 399.5);
  CHECK(known().cameras->K2(1, 2) == 199.5);
  REQUIRE(known().inlier_priors.size() == 10);
  CHECK(known().inlier_priors[2] == InlierProbabilityOfRatio(problem.snn_ratio[2]));
  problem.size2 = {};
  problem.snn_ratio = {};
  CHECK_FALSE(known().cameras);
  CHECK(known().inlier_priors.size() == 0);
}

TEST_CASE("Points in normalised coordinates say how many pixels their unit is") {
  Problem problem = MakeProblem();
  CHECK(PriorsOfProblem(NormalizedProblem(problem), {}).unit == 1.0);
  problem.task = Task::kEssential;
  problem.cameras = CameraPair{};
  for (Eigen::Matrix3d* camera : {&problem.cameras->K1, &problem.cameras->K2}) camera->topLeftCorner<2, 2>() *= 700.0;
  CHECK(PriorsOfProblem(NormalizedProblem(problem), {}).unit == Approx(700.0));
}

TEST_CASE("A match of lower ratio is likelier an inlier") {
  double last = 1.0;
  for (double ratio = 0.0; ratio <= 1.0; ratio += 0.05) {
    const double probability = InlierProbabilityOfRatio(ratio);
    CHECK(probability < last);
    CHECK(probability > 0.05);
    last = probability;
  }
}

}  // namespace
}  // namespace diffsac
