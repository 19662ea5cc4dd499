#include "diffsac/problem/shared_focal_task.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "diffsac/problem/tasks.h"
#include "geometry/two_view_problems.h"
#include "lab/ground_truth/pair_truth.h"
#include "lab/ground_truth/task_truth.h"

namespace diffsac {
namespace {

/// A pair whose images, of 1000 × 800 pixels, have their principal points at the centre, before it is any task's.
Example Pair(double focal1, double focal2) {
  Rng rng(3);
  const testing::TwoViewProblem views = testing::RandomProblem(50, rng);
  CameraPair cameras;
  cameras.K1 << focal1, 0.0, 499.5, 0.0, focal1, 399.5, 0.0, 0.0, 1.0;
  cameras.K2 << focal2, 0.0, 499.5, 0.0, focal2, 399.5, 0.0, 0.0, 1.0;
  Example pair;
  pair.problem.points.resize(50, 4);
  for (int i = 0; i < 50; ++i) {
    const Eigen::RowVector4d x = views.normalized.row(i);
    pair.problem.points.row(i) << focal1 * x[0] + 499.5, focal1 * x[1] + 399.5, focal2 * x[2] + 499.5,
        focal2 * x[3] + 399.5;
  }
  pair.problem.size1 = pair.problem.size2 = {1000, 800};
  pair.problem.cameras = cameras;
  pair.truth.motion = RigidMotion{views.pose.rotation, views.pose.translation};
  CompleteTruth(pair.problem, &pair.truth);
  return pair;
}

const std::vector<std::uint8_t> kAll(50, 1);

void CheckTruth(const Example& pair, Task task) {
  const NormalizedProblem space(pair.problem);
  REQUIRE(space.is_accepted());
  REQUIRE(pair.truth.model.size() == 11);
  DispatchDescription(task, [&]<class Description>() {
    if constexpr (requires { Description::kUnknownFocal; }) {
      const typename Description::Model::Parameters model = pair.truth.model;
      for (int i = 0; i < 50; ++i) {
        CHECK(Description::Model::Residual(model, space.points().row(i).data()) < 1e-9);
        CHECK(Description::PixelResidual(Description::PixelModel(pair.truth.model, pair.problem),
                                         pair.problem.points.row(i).data()) < 1e-6);
      }
      const EstimateError error = TruthOf(task).error(&pair.truth.model, kAll, pair);
      CHECK(error.angle_deg < 1e-5);
      CHECK(error.focal < 1e-12);
      const auto pose = Description::Pose(pair.truth.model, kAll, NormalizedProblem(pair.problem));
      REQUIRE(pose);
      CHECK(pose->rotation.isApprox(pair.truth.motion->rotation, 1e-9));
    }
  });
}

}  // namespace

TEST_CASE("a task of unknown focal length keeps the calibration from the problem and measures by the truth") {
  Example pair = Pair(900.0, 900.0);
  SetTask(Task::kSharedFocal, 1.0, &pair);
  CHECK_FALSE(pair.problem.cameras);
  CHECK_FALSE(pair.problem.camera_prior1.K);
  REQUIRE(pair.truth.cameras);
  CheckTruth(pair, Task::kSharedFocal);

  Example one = Pair(700.0, 1100.0);
  SetTask(Task::kOneFocal, 1.0, &one);
  CHECK_FALSE(one.problem.cameras);
  REQUIRE(one.problem.camera_prior1.K);
  CheckTruth(one, Task::kOneFocal);

  Example two = Pair(700.0, 1100.0);
  SetTask(Task::kTwoFocals, 1.0, &two);
  CHECK_FALSE(two.problem.camera_prior1.K);
  two.problem.camera_prior1.focal = FocalPrior{650.0, 0.1};
  two.truth.model = TrueModel(two.problem, two.truth);
  CheckTruth(two, Task::kTwoFocals);
  CHECK(TwoFocalsTask::PriorsOf(two.problem, 0.4)[0].log_sigma == 0.1);
  CHECK(TwoFocalsTask::PriorsOf(two.problem, 0.4)[1].log_sigma == 0.4);

  SECTION("the calibrated image may be the second") {
    one.problem.camera_prior2.K = one.truth.cameras->K2;
    one.problem.camera_prior1.K.reset();
    one.truth.model = TrueModel(one.problem, one.truth);
    CheckTruth(one, Task::kOneFocal);
    const FocalEstimate focal =
        OneFocalTask::InPixels({{{1.0, 1.0, 1.0, true, {1.0, 0.0}}, {1.0, 0.9, 1.1, true, {1.0, 0.2}}}}, one.problem);
    CHECK(focal.focal_px[1] == Approx(1100.0));
    CHECK(focal.low_px[1] == focal.focal_px[1]);
    CHECK(focal.low_px[0] == Approx(0.9 * focal.focal_px[0]));
  }
  SECTION("errors are those of pose and focal length") {
    ModelParameters model = pair.truth.model;
    model[10] *= 1.25;
    CHECK(TruthOf(Task::kSharedFocal).error(&model, kAll, pair).focal == Approx(0.25));
    const EstimateError failure = TruthOf(Task::kSharedFocal).error(nullptr, {}, pair);
    CHECK(failure.failed);
    CHECK(failure.angle_deg == kWorstRotationDeg);
    CHECK(std::isinf(failure.focal));
  }
}

TEST_CASE("the solver's unit is the prior's focal length") {
  Example pair = Pair(900.0, 900.0);
  SetTask(Task::kSharedFocal, 1.0, &pair);
  Problem& problem = pair.problem;
  const double usual = NormalizedProblem(problem).unit();
  CHECK(usual > 800.0);
  CHECK(usual < 1200.0);
  CHECK(SharedFocalTask::PriorsOf(problem, 0.4)[1].log_sigma == 0.4);
  problem.camera_prior1.focal = FocalPrior{950.0, 0.1};
  // One camera: what is said of one image is said of the other.
  CHECK(NormalizedProblem(problem).unit() == Approx(950.0));
  CHECK(SharedFocalTask::PriorsOf(problem, 0.4)[1].log_sigma == 0.1);
  problem.camera_prior2.focal = FocalPrior{1050.0, 0.1};
  CHECK(NormalizedProblem(problem).unit() == Approx(std::sqrt(950.0 * 1050.0)));
  CHECK(SharedFocalTask::PriorsOf(problem, 0.4)[1].log_sigma == 0.1);
  problem.camera_prior2.focal = FocalPrior{1050.0, 0.3};
  CHECK(NormalizedProblem(problem).unit() < 962.0);
  const FocalEstimate focal =
      *FocalEstimateOf({{{1.1, 1.0, 1.2, false, {1.0, 0.1}}, {1.1, 1.0, 1.2, false, {1.0, 0.1}}}}, problem);
  CHECK(focal.focal_px[0] == Approx(1.1 * NormalizedProblem(problem).unit()));
  CHECK(focal.prior_focal_px[0] == Approx(NormalizedProblem(problem).unit()));
  CHECK_FALSE(focal.observable[0]);
}

TEST_CASE("what a task of unknown focal length needs") {
  Example pair = Pair(900.0, 900.0);
  SetTask(Task::kSharedFocal, 1.0, &pair);
  Problem problem = pair.problem;
  CHECK(HasItsNeeds(problem));
  problem.size1 = {};
  CHECK_FALSE(HasItsNeeds(problem));
  CHECK(CheckProblem(problem) == Status::kDegenerate);
  problem.camera_prior1.principal_point = Eigen::Vector2d(499.5, 399.5);
  CHECK(HasItsNeeds(problem));  // The other image's size says what camera it is.
  problem.camera_prior1.principal_point->x() = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(HasItsNeeds(problem));
  problem = pair.problem;
  problem.camera_prior1.focal = FocalPrior{-1.0, 0.1};
  CHECK_FALSE(HasItsNeeds(problem));

  problem = pair.problem;
  problem.task = Task::kOneFocal;
  CHECK_FALSE(HasItsNeeds(problem));
  problem.camera_prior1.K = Eigen::Matrix3d::Zero();
  CHECK_FALSE(HasItsNeeds(problem));
  problem.camera_prior1.K = pair.truth.cameras->K1;
  CHECK(HasItsNeeds(problem));
}

}  // namespace diffsac
