#include <catch2/catch.hpp>

#include "diffsac/core/status.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"
#include "lab/data/repeated_structures.h"
#include "lab/data/same_points.h"

namespace diffsac {
namespace {

std::unique_ptr<Dataset> Pairs(const std::string& task) {
  const auto config =
      ConfigFromYaml("{type: synthetic_two_view, task: " + task +
                         ", num_points: 200, outlier_ratio: 0.3, inlier_threshold_px: 1, noise_px: 0.2, "
                         "match_ratio: true}",
                     "pairs.yaml");
  return MakeDataset(config, 1);
}

int CountOf(const std::vector<char>& flags) { return static_cast<int>(std::count(flags.begin(), flags.end(), 1)); }

TEST_CASE("Moved groups of matches are wrong, and only they change") {
  for (const std::string task : {"homography", "fundamental", "essential"}) {
    const auto pairs = Pairs(task);
    int moved_in_all = 0, still_right = 0;
    for (int k = 0; k < 30; ++k) {
      const Example before = pairs->Get(k);
      Example after = before;
      const auto moved = MoveGroups(Rng(3).Fork("groups", k), &after);
      REQUIRE(moved.size() == 200);
      CHECK(after.problem.points.leftCols(2) == before.problem.points.leftCols(2));
      for (int i = 0; i < 200; ++i) {
        if (!moved[i]) {
          CHECK(after.problem.points.row(i) == before.problem.points.row(i));
          CHECK(after.problem.match_ratio[i] == before.problem.match_ratio[i]);
          CHECK(after.truth.inliers[i] == before.truth.inliers[i]);
        } else {
          CHECK(before.truth.inliers[i] == 1);
          CHECK(after.problem.points.row(i) != before.problem.points.row(i));
          still_right += after.truth.inliers[i];
        }
      }
      moved_in_all += CountOf(moved);
    }
    CHECK(moved_in_all > 30 * 10);
    // Along the epipolar line, F and E cannot tell.
    CHECK(still_right < moved_in_all / 5);
  }
}

TEST_CASE("A group moves together: what was near stays near") {
  const auto pairs = Pairs("fundamental");
  for (int k = 0; k < 20; ++k) {
    const Example before = pairs->Get(k);
    Example after = before;
    const auto moved = MoveGroups(Rng(4).Fork("groups", k), &after);
    // At most three vectors but for the scale: the spread of the steps is small beside their length within a group.
    Eigen::RowVector2d first;
    int near_first = 0, all = 0;
    for (int i = 0; i < 200; ++i) {
      if (!moved[i]) continue;
      const Eigen::RowVector2d step = after.problem.points.row(i).tail<2>() - before.problem.points.row(i).tail<2>();
      if (all++ == 0) first = step;
      near_first += (step - first).norm() < 0.5 * first.norm();
    }
    if (all >= 12) CHECK(near_first >= 3);
  }
}

TEST_CASE("Groups are the same for the same seed and others for another") {
  const auto pairs = Pairs("essential");
  Example a = pairs->Get(0), b = pairs->Get(0), c = pairs->Get(0);
  CHECK(MoveGroups(Rng(1), &a) == MoveGroups(Rng(1), &b));
  CHECK(a.problem.points == b.problem.points);
  MoveGroups(Rng(2), &c);
  CHECK_FALSE(testing::SamePoints(a.problem.points, c.problem.points));
}

TEST_CASE("Nothing is moved without known inliers, a model or enough of them") {
  const auto pairs = Pairs("essential");
  const Example example = pairs->Get(0);
  const auto unchanged = [&](Example changed) {
    const PointMatrix points = changed.problem.points;
    const auto moved = MoveGroups(Rng(1), &changed);
    return CountOf(moved) == 0 && changed.problem.points == points &&
           moved.size() == static_cast<std::size_t>(points.rows());
  };
  Example without = example;
  without.truth.inliers.clear();
  CHECK(unchanged(without));
  without = example;
  without.truth.model.resize(0);
  CHECK(unchanged(without));
  without = example;
  without.problem.cameras.reset();
  CHECK(unchanged(without));
  without = example;
  std::fill(without.truth.inliers.begin(), without.truth.inliers.end(), 0);
  CHECK(unchanged(without));
  without = example;
  without.problem.points.resize(0, 4);
  without.problem.match_ratio.resize(0);
  without.truth.inliers.clear();
  CHECK(unchanged(without));
}

}  // namespace
}  // namespace diffsac
