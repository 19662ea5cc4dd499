#include "lab/data/synthetic_plane_views.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "core/errors.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/problem/tasks.h"
#include "lab/data/example_test_util.h"

namespace diffsac {
namespace {

SyntheticPlaneViewsOptions Planes(Range structures, double noise_px = 0.0) {
  SyntheticPlaneViewsOptions options;
  options.structures.structures = structures;
  options.matches.noise_px = noise_px;
  return options;
}

double Distance(const Example& example, Eigen::Index i, int structure) {
  return Homography::Residual(Matrix3Parameters(example.truth.structures[structure]),
                              example.problem.points.data() + 4 * i);
}

}  // namespace

TEST_CASE("plane views: labels, homographies and inliers agree") {
  for (int k = 1; k <= 6; ++k) {
    const auto dataset = MakeSyntheticPlaneViews(Planes(k), 3);
    int outliers = 0, close_outliers = 0;
    for (int index = 0; index < 15; ++index) {
      CAPTURE(k, index);
      const Example example = dataset->Get(index);
      const Problem& problem = example.problem;
      CHECK(problem.task == Task::kHomography);
      CHECK(CheckProblem(problem) == Status::kOk);
      CHECK((problem.points.rows() >= 100 && problem.points.rows() <= 300));
      CHECK(problem.inlier_threshold == 2.0);
      CHECK(problem.match_ratio.size() == problem.points.rows());
      REQUIRE(problem.cameras);
      REQUIRE(example.truth.pose);
      REQUIRE(example.truth.structures.size() == static_cast<std::size_t>(k));
      CHECK(example.truth.model == example.truth.structures[0]);
      CHECK(AsParameters(*example.truth.homography) == Matrix3Parameters(example.truth.model));
      const std::vector<int> sizes = StructureSizes(example);
      CHECK(std::is_sorted(sizes.rbegin(), sizes.rend()));
      CHECK(sizes.back() >= 6);
      const double share = static_cast<double>(CountLabelled(example)) / problem.points.rows();
      CHECK((share > 0.39 && share < 0.91));
      for (Eigen::Index i = 0; i < problem.points.rows(); ++i) {
        const int label = example.truth.assignment[i];
        CHECK(example.truth.inliers[i] == (label > 0));
        if (label > 0) CHECK(Distance(example, i, label - 1) < 1e-6);
        outliers += label == 0;
        for (int s = 0; s < k && label == 0; ++s) close_outliers += Distance(example, i, s) < 1.0;
      }
    }
    CHECK(close_outliers < 0.05 * outliers);
  }
}

TEST_CASE("plane views: planes of a scene are told apart and lie in regions of their own") {
  const auto dataset = MakeSyntheticPlaneViews(Planes(4), 4);
  for (int index = 0; index < 20; ++index) {
    const Example example = dataset->Get(index);
    const std::vector<int> sizes = StructureSizes(example);
    const auto& points = example.problem.points;
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b) {
        int near = 0;
        for (Eigen::Index i = 0; i < points.rows(); ++i)
          near += a != b && example.truth.assignment[i] == a + 1 && Distance(example, i, b) <= 4.0;
        CHECK(near <= 0.5 * sizes[a]);
      }
    // In image 1 the nearest labelled match is mostly of the same plane.
    int same = 0, labelled = 0;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      if (example.truth.assignment[i] == 0) continue;
      Eigen::Index nearest = -1;
      double least = 1e12;
      for (Eigen::Index j = 0; j < points.rows(); ++j) {
        if (j == i || example.truth.assignment[j] == 0) continue;
        const double distance = (points.row(i) - points.row(j)).head<2>().squaredNorm();
        if (distance < least) least = distance, nearest = j;
      }
      ++labelled;
      same += example.truth.assignment[i] == example.truth.assignment[nearest];
    }
    CHECK(same > 0.7 * labelled);
  }
}

TEST_CASE("plane views: noise, number and sizes are as asked") {
  SyntheticPlaneViewsOptions options = Planes({2, 5}, 0.5);
  options.structures.size_ratio = 4.0;
  options.matches.num_points = 400;
  options.matches.outlier_ratio = 0.25;
  const auto dataset = MakeSyntheticPlaneViews(options, 5);
  std::set<std::size_t> counts;
  double squares = 0.0;
  int inliers = 0;
  for (int index = 0; index < 40; ++index) {
    const Example example = dataset->Get(index);
    const std::vector<int> sizes = StructureSizes(example);
    counts.insert(sizes.size());
    CHECK(static_cast<double>(sizes.front()) / sizes.back() == Approx(4.0).epsilon(0.15));
    CHECK(CountLabelled(example) == 300);
    for (Eigen::Index i = 0; i < 400; ++i) {
      if (example.truth.assignment[i] == 0) continue;
      const double distance =
          TransferError(Matrix3Parameters(example.truth.structures[example.truth.assignment[i] - 1]),
                        example.problem.points.data() + 4 * i);
      CHECK(distance < 30.0);
      squares += std::min(distance, 5.0) * std::min(distance, 5.0);
      ++inliers;
    }
  }
  CHECK(counts == std::set<std::size_t>{2, 3, 4, 5});
  // About √2 · 0.5 px in each of two coordinates, 1 px together; planes that recede magnify the first image's.
  CHECK((std::sqrt(squares / inliers) > 0.7 && std::sqrt(squares / inliers) < 1.5));
}

TEST_CASE("plane views: hard ranges still end, impossible ones are an error at once") {
  SyntheticPlaneViewsOptions hard = Planes(6);
  hard.rotation_deg = 180.0;
  hard.plane_tilt_deg = 85.0;
  hard.min_overlap = 0.8;
  hard.cameras.same_camera = 0.0;
  const auto dataset = MakeSyntheticPlaneViews(hard, 13);
  for (int index = 0; index < 3; ++index) CHECK(dataset->Get(index).truth.structures.size() == 6);
  SyntheticPlaneViewsOptions still = Planes(3);
  still.baseline = 1e-4;
  CHECK(Has(ErrorOf([&] { MakeSyntheticPlaneViews(still, 1); }), "no scene of 3 planes"));
}

}  // namespace diffsac
