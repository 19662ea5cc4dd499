#include "lab/data/synthetic_two_view.h"
#include "diffsac/core/range.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/problem/tasks.h"
#include "lab/data/example_test_util.h"

namespace diffsac {
namespace {

constexpr Task kTasks[] = {Task::kHomography, Task::kFundamental, Task::kEssential};
constexpr const char* kKinds[] = {"general", "planar", "mixed", "forward"};

SyntheticTwoViewOptions Only(Task task, const std::string& kind) {
  SyntheticTwoViewOptions options;
  options.task = task;
  options.general = kind == "general";
  options.planar = kind == "planar";
  options.mixed = kind == "mixed";
  options.forward = kind == "forward";
  return options;
}

SyntheticTwoViewOptions Exact(Task task, const std::string& kind) {
  SyntheticTwoViewOptions options = Only(task, kind);
  options.matches.noise_px = 0.0;
  return options;
}

// The residual of a match to the truth, in pixels for H and F, in pixels by the mean focal length for E.
double TrueResidual(const Example& example, const PointMatrix& points, Eigen::Index i) {
  const Matrix3Parameters model = example.truth.model;
  const double* point = points.data() + 4 * i;
  if (example.problem.task == Task::kHomography) return Homography::Residual(model, point);
  const double scale = example.problem.task == Task::kEssential ? example.problem.cameras->MeanFocal() : 1.0;
  return scale * Fundamental::Residual(model, point);
}

PointMatrix SolverPoints(const Example& example) {
  const Problem& problem = example.problem;
  return problem.task == Task::kEssential
             ? NormalizedCoordinates(problem.points, problem.cameras->K1, problem.cameras->K2)
             : problem.points;
}

Eigen::VectorXd Weights(const Example& example) {
  Eigen::VectorXd weights(example.problem.points.rows());
  for (Eigen::Index i = 0; i < weights.size(); ++i) weights[i] = example.truth.inliers[i];
  return weights;
}

// How many inliers one homography explains, at best over some random sets of four.
int LargestPlane(const Example& example) {
  std::vector<int> inliers;
  for (int i = 0; i < static_cast<int>(example.truth.inliers.size()); ++i)
    if (example.truth.inliers[i]) inliers.push_back(i);
  int largest = 0;
  Rng rng(9);
  for (int trial = 0; trial < 300; ++trial) {
    int picks[4], set[4];
    rng.Distinct(static_cast<int>(inliers.size()), 4, picks);
    for (int k = 0; k < 4; ++k) set[k] = inliers[picks[k]];
    Matrix3Parameters h;
    if (Homography::SolveMinimal(example.problem.points, set, &h) == 0) continue;
    int near = 0;
    for (int i : inliers) near += Homography::Residual(h, example.problem.points.data() + 4 * i) < 1e-3;
    largest = std::max(largest, near);
  }
  return largest;
}

}  // namespace

TEST_CASE("synthetic two views: the truth explains the inliers of every task and kind") {
  for (const Task task : kTasks)
    for (const char* kind : kKinds) {
      CAPTURE(ToString(task), kind);
      const auto dataset = MakeSyntheticTwoView(Exact(task, kind), 5);
      int close_outliers = 0, outliers = 0;
      for (int index = 0; index < 12; ++index) {
        const Example example = dataset->Get(index);
        const Problem& problem = example.problem;
        CHECK(CheckProblem(problem) == Status::kOk);
        CHECK(problem.task == task);
        CHECK(problem.points.rows() >= 100);
        CHECK(problem.points.rows() <= 500);
        CHECK(CountInliers(example) > MinimalSetSize(problem.task));
        CHECK(problem.snn_ratio.size() == problem.points.rows());
        REQUIRE(example.truth.pose);
        REQUIRE(problem.size1.known());
        const PointMatrix points = SolverPoints(example);
        for (Eigen::Index i = 0; i < points.rows(); ++i) {
          const auto p = problem.points.row(i);
          CHECK((p.minCoeff() >= 0.0 && p[0] <= problem.size1.width && p[1] <= problem.size1.height &&
                 p[2] <= problem.size2.width && p[3] <= problem.size2.height));
          const double residual = TrueResidual(example, points, i);
          if (example.truth.inliers[i]) CHECK(residual < 1e-6);
          outliers += !example.truth.inliers[i];
          close_outliers += !example.truth.inliers[i] && residual < 1.0;
        }
      }
      CHECK(close_outliers < 0.05 * outliers);
    }
}

TEST_CASE("synthetic two views: the model's pose is the true one") {
  for (const char* kind : {"general", "mixed", "forward"})
    for (int index = 0; index < 10; ++index) {
      CAPTURE(kind, index);
      const Example e = MakeSyntheticTwoView(Exact(Task::kEssential, kind), 6)->Get(index);
      const Example f = MakeSyntheticTwoView(Exact(Task::kFundamental, kind), 6)->Get(index);
      const PoseChoice of_e = ChoosePose(AsMatrix(e.truth.model), SolverPoints(e), e.truth.inliers);
      CHECK(of_e.in_front == CountInliers(e));
      CHECK(RotationAngleDegrees(of_e.pose.rotation, e.truth.pose->rotation) < 1e-6);
      CHECK(DirectionAngleDegrees(of_e.pose.translation, e.truth.pose->translation) < 1e-6);
      const CameraPair& cameras = *f.problem.cameras;
      const PoseChoice of_f =
          ChoosePose(EssentialFromFundamental(AsMatrix(f.truth.model), cameras.K1, cameras.K2),
                     NormalizedCoordinates(f.problem.points, cameras.K1, cameras.K2), f.truth.inliers);
      CHECK(RotationAngleDegrees(of_f.pose.rotation, f.truth.pose->rotation) < 1e-6);
      CHECK(DirectionAngleDegrees(of_f.pose.translation, f.truth.pose->translation) < 1e-6);
      // Without noise the inliers alone give the model back, by another route than the generator's.
      Matrix3Parameters fit;
      REQUIRE(Fundamental::Fit(f.problem.points, Weights(f), &fit));
      CHECK(1.0 - std::abs(fit.dot(Matrix3Parameters(f.truth.model))) < 1e-6);
    }
  for (const char* kind : kKinds) {
    const Example h = MakeSyntheticTwoView(Exact(Task::kHomography, kind), 6)->Get(3);
    Matrix3Parameters fit;
    REQUIRE(Homography::Fit(h.problem.points, Weights(h), &fit));
    CHECK(1.0 - std::abs(fit.dot(Matrix3Parameters(h.truth.model))) < 1e-9);
  }
}

TEST_CASE("synthetic two views: scenes are of the kind they are called") {
  const auto share = [](const std::string& kind, int index) {
    SyntheticTwoViewOptions options = Exact(Task::kFundamental, kind);
    options.plane_share = 0.6;
    options.baseline = Range(0.2, 0.4);
    const Example example = MakeSyntheticTwoView(options, 7)->Get(index);
    return static_cast<double>(LargestPlane(example)) / CountInliers(example);
  };
  for (int index = 0; index < 6; ++index) {
    CHECK(share("planar", index) == 1.0);
    CHECK(share("mixed", index) == Approx(0.6).margin(0.05));
    CHECK(share("general", index) < 0.5);
  }
  SyntheticTwoViewOptions forward = Exact(Task::kEssential, "forward");
  int back = 0;
  for (int index = 0; index < 40; ++index) {
    const RelativePose pose = *MakeSyntheticTwoView(forward, 7)->Get(index).truth.pose;
    // The second camera's place, seen from the first.
    const Eigen::Vector3d centre = -(pose.rotation.transpose() * pose.translation);
    const double angle = DirectionAngleDegrees(centre, Eigen::Vector3d::UnitZ());
    CHECK(std::min(angle, 180.0 - angle) <= 10.0 + 1e-9);
    back += angle > 90.0;
  }
  CHECK((back > 5 && back < 35));
  // Homographies: a camera that only turns, and matches off the plane.
  CHECK(MakeSyntheticTwoView(Exact(Task::kHomography, "general"), 7)->Get(0).truth.pose->translation.norm() == 0.0);
  SyntheticTwoViewOptions mixed = Exact(Task::kHomography, "mixed");
  mixed.matches.displaced_share = 0.0;
  mixed.plane_share = 0.0;
  const Example off_plane = MakeSyntheticTwoView(mixed, 7)->Get(1);
  for (Eigen::Index i = 0; i < off_plane.problem.points.rows(); ++i)
    if (!off_plane.truth.inliers[i]) CHECK(TrueResidual(off_plane, off_plane.problem.points, i) >= 3.0);
}

TEST_CASE("synthetic two views: weights decide how often a kind is drawn") {
  SyntheticTwoViewOptions options = Exact(Task::kFundamental, "general");
  options.planar = 3.0;
  options.matches.num_points = 40;
  const auto dataset = MakeSyntheticTwoView(options, 8);
  int planar = 0;
  for (int index = 0; index < 200; ++index) {
    const Example example = dataset->Get(index);
    planar += LargestPlane(example) == CountInliers(example);
  }
  CHECK(planar == Approx(150).margin(25));
}

TEST_CASE("synthetic two views: both images are of one camera as often as asked") {
  SyntheticTwoViewOptions options = Exact(Task::kEssential, "general");
  options.matches.num_points = 20;
  const auto dataset = MakeSyntheticTwoView(options, 12);
  int same = 0;
  for (int index = 0; index < 200; ++index) {
    const Problem problem = dataset->Get(index).problem;
    same += problem.cameras->K1 == problem.cameras->K2;
  }
  CHECK(same == Approx(200.0 * options.cameras.same_camera).margin(25));
}

TEST_CASE("synthetic two views: noise has the asked size") {
  for (const Task task : {Task::kFundamental, Task::kEssential}) {
    SyntheticTwoViewOptions options = Only(task, "general");
    options.matches.noise_px = 0.5;
    options.cameras.same_camera = 1.0;
    double squares = 0.0;
    int count = 0;
    for (int index = 0; index < 60; ++index) {
      const Example example = MakeSyntheticTwoView(options, 9)->Get(index);
      const PointMatrix points = SolverPoints(example);
      for (Eigen::Index i = 0; i < points.rows(); ++i) {
        if (!example.truth.inliers[i]) continue;
        const double residual = TrueResidual(example, points, i);
        squares += residual * residual;
        ++count;
      }
    }
    // The Sampson distance of isotropic noise has the noise's σ (for E where the focal lengths are equal).
    CHECK(std::sqrt(squares / count) == Approx(0.5).epsilon(0.05));
  }
}

TEST_CASE("synthetic two views: ratios are lower for inliers, by the stated law") {
  SyntheticTwoViewOptions options = Only(Task::kFundamental, "general");
  options.matches.correct_ratio_power = 2.0;
  options.matches.wrong_ratio_power = 10.0;
  double inlier_sum = 0.0, outlier_sum = 0.0;
  int inliers = 0, outliers = 0, inliers_below = 0;
  for (int index = 0; index < 60; ++index) {
    const Example example = MakeSyntheticTwoView(options, 10)->Get(index);
    for (Eigen::Index i = 0; i < example.problem.snn_ratio.size(); ++i) {
      const double ratio = example.problem.snn_ratio[i];
      CHECK((ratio > 0.0 && ratio <= 1.0));
      const bool inlier = example.truth.inliers[i];
      (inlier ? inlier_sum : outlier_sum) += ratio;
      ++(inlier ? inliers : outliers);
      inliers_below += inlier && ratio <= 0.8;
    }
  }
  CHECK(inlier_sum / inliers == Approx(2.0 / 3.0).margin(0.01));
  CHECK(outlier_sum / outliers == Approx(10.0 / 11.0).margin(0.005));
  CHECK(static_cast<double>(inliers_below) / inliers == Approx(0.64).margin(0.02));
  options.matches.snn_ratio = false;
  const Example without = MakeSyntheticTwoView(options, 10)->Get(0);
  options.matches.snn_ratio = true;
  CHECK(without.problem.snn_ratio.size() == 0);
  CHECK(without.problem.points == MakeSyntheticTwoView(options, 10)->Get(0).problem.points);
}

TEST_CASE("synthetic two views: correct matches have the similarity around them, and nothing else changes with it") {
  for (const char* kind : kKinds) {
    SyntheticTwoViewOptions options = Only(Task::kFundamental, kind);
    const Example without = MakeSyntheticTwoView(options, 13)->Get(0);
    CHECK(without.problem.scale_rotation_changes.size() == 0);
    options.matches.scale_rotation_changes = true;
    options.matches.similarity_noise = 0.1;
    options.matches.gross_scale_rotation_changes = 0.0;
    const Example with = MakeSyntheticTwoView(options, 13)->Get(0);
    CHECK(with.problem.points == without.problem.points);
    CHECK(with.problem.snn_ratio == without.problem.snn_ratio);
    CHECK(with.truth.inliers == without.truth.inliers);
    REQUIRE(with.problem.scale_rotation_changes.rows() == with.problem.points.rows());
    CHECK(with.problem.scale_rotation_changes.allFinite());
    CHECK(with.problem.scale_rotation_changes.col(1).cwiseAbs().maxCoeff() <= std::numbers::pi);
    options.matches.similarity_noise = 0.0;
    const Example exact = MakeSyntheticTwoView(options, 13)->Get(0);
    double sum = 0.0;
    for (Eigen::Index i = 0; i < with.problem.points.rows(); ++i) {
      const bool same = with.problem.scale_rotation_changes.row(i) == exact.problem.scale_rotation_changes.row(i);
      CHECK(same == (with.truth.inliers[i] == 0));
      const Eigen::RowVector2d error =
          with.problem.scale_rotation_changes.row(i) - exact.problem.scale_rotation_changes.row(i);
      sum += error[0] * error[0] + std::pow(std::remainder(error[1], 2.0 * std::numbers::pi), 2);
    }
    CHECK(std::sqrt(sum / (2 * CountInliers(with))) == Approx(0.1).epsilon(0.25));
  }
}

TEST_CASE("synthetic two views: similarities of planar scenes move their neighbours") {
  SyntheticTwoViewOptions options = Exact(Task::kHomography, "planar");
  options.matches.scale_rotation_changes = true;
  options.matches.similarity_noise = 0.0;
  options.matches.gross_scale_rotation_changes = 0.0;
  options.plane_tilt_deg = 0.0;
  options.rotation_deg = 0.0;
  options.converging = 0.0;
  options.cameras.same_camera = 1.0;
  // Fronto-parallel, and seen so: the map is a similarity, all of one scale.
  const Example example = MakeSyntheticTwoView(options, 14)->Get(0);
  int first = -1;
  for (int i = 0; i < example.problem.points.rows(); ++i) {
    if (!example.truth.inliers[i]) continue;
    if (first < 0) first = i;
    const Eigen::RowVector4d step = example.problem.points.row(i) - example.problem.points.row(first);
    const double scale = std::exp(example.problem.scale_rotation_changes(i, 0));
    CHECK((scale * step.head<2>() - step.tail<2>()).norm() < 1e-6 * (1.0 + step.norm()));
    CHECK(std::abs(example.problem.scale_rotation_changes(i, 1)) < 1e-9);
  }
}

TEST_CASE("synthetic two views: displaced matches keep the first point and lie at the stated distance") {
  VirtualPair pair;
  pair.first = pair.second = RandomCamera({}, Rng(1));
  SyntheticMatchesOptions options;
  options.noise_px = 0.0;
  options.displacement_px = Range(5.0, 20.0);
  ExactMatches exact;
  Rng rng(2);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2d a = pair.first.RandomPixel(rng), b = pair.second.RandomPixel(rng);
    exact.displaced.emplace_back(a[0], a[1], b[0], b[1]);
  }
  const Example example = MakeMatches(options, Task::kFundamental, pair, exact, 80, Rng(3));
  REQUIRE(example.problem.points.rows() == 80);
  CHECK(CountInliers(example) == 0);
  int found = 0;
  for (const Eigen::Vector4d& match : exact.displaced)
    for (Eigen::Index i = 0; i < 80; ++i) {
      const Eigen::Vector4d point = example.problem.points.row(i);
      if (point.head<2>() != match.head<2>()) continue;
      ++found;
      const double distance = (point - match).tail<2>().norm();
      CHECK((distance >= 5.0 - 1e-9 && distance <= 20.0 + 1e-9));
    }
  CHECK(found == 50);
}

TEST_CASE("synthetic two views: hard ranges still end, with the overlap that was asked for") {
  for (const char* kind : kKinds) {
    SyntheticTwoViewOptions options = Exact(Task::kEssential, kind);
    options.rotation_deg = 180.0;
    options.forward_rotation_deg = 180.0;
    options.baseline = 10.0;
    options.plane_tilt_deg = 85.0;
    options.min_overlap = 0.8;
    options.cameras.same_camera = 0.0;
    for (int index = 0; index < 3; ++index)
      CHECK(CheckProblem(MakeSyntheticTwoView(options, 13)->Get(index).problem) == Status::kOk);
  }
}

}  // namespace diffsac
