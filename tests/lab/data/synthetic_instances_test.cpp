#include "diffsac/core/range.h"
#include "lab/data/synthetic.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "diffsac/core/status.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"
#include "lab/data/example_test_util.h"
#include "lab/data/repeated_structures.h"

namespace diffsac {
namespace {

constexpr Task kTasks[] = {Task::kLine, Task::kPlane};

SyntheticInstancesOptions Fixed(Task task, Range instances) {
  SyntheticInstancesOptions options;
  options.task = task;
  options.instances.instances = instances;
  return options;
}

double Distance(const Example& example, Eigen::Index i, int instance) {
  const ModelParameters& model = example.truth.instances[instance];
  const Eigen::Index d = example.problem.points.cols();
  return std::abs(example.problem.points.row(i).dot(model.head(d)) + model[d]);
}

}  // namespace

TEST_CASE("structures: labels, models and inliers agree, for lines and planes") {
  for (const Task task : kTasks)
    for (int k = 1; k <= 6; ++k) {
      const auto dataset = MakeSyntheticInstances(Fixed(task, k), 3);
      for (int index = 0; index < 10; ++index) {
        const Example example = dataset->Get(index);
        CAPTURE(ToString(task), k, index);
        CHECK(CheckProblem(example.problem) == Status::kOk);
        REQUIRE(example.problem.points.rows() == 100);
        REQUIRE(example.truth.instances.size() == static_cast<std::size_t>(k));
        CHECK(CountLabelled(example) == 70);
        CHECK(example.truth.model == example.truth.instances[0]);
        const std::vector<int> sizes = InstanceSizes(example);
        CHECK(std::is_sorted(sizes.rbegin(), sizes.rend()));
        CHECK(sizes.back() >= MinimalSetSize(task) + 2);
        int close = 0;
        for (Eigen::Index i = 0; i < 100; ++i) {
          const int label = example.truth.assignment[i];
          CHECK(example.truth.inliers[i] == (label > 0));
          if (label == 0) continue;
          CHECK(Distance(example, i, label - 1) < 5.0 * 0.1 / 3.0);
          close += Distance(example, i, label - 1) < 2.0 * 0.1 / 3.0;
        }
        CHECK(close > 55);  // 95 % of 70 within 2 σ
      }
    }
}

TEST_CASE("structures: two of a problem are told apart") {
  for (const Task task : kTasks) {
    SyntheticInstancesOptions options = Fixed(task, 6);
    options.num_points = 600;
    options.sigma = 1e-9;
    const auto dataset = MakeSyntheticInstances(options, 4);
    for (int index = 0; index < 20; ++index) {
      const Example example = dataset->Get(index);
      const std::vector<int> sizes = InstanceSizes(example);
      for (int a = 0; a < 6; ++a)
        for (int b = 0; b < 6; ++b) {
          int near = 0;
          for (Eigen::Index i = 0; i < 600; ++i)
            near += a != b && example.truth.assignment[i] == a + 1 && Distance(example, i, b) <= 0.2;
          CHECK(near < 0.7 * sizes[a]);  // half of it, on other points
        }
    }
  }
}

TEST_CASE("structures: their number and sizes are drawn over the whole ranges") {
  SyntheticInstancesOptions options = Fixed(Task::kLine, {2, 5});
  options.instances.size_ratio = Range(1.0, 6.0);
  options.num_points = 400;
  options.outlier_ratio = Range(0.1, 0.6);
  const auto dataset = MakeSyntheticInstances(options, 5);
  std::set<std::size_t> counts;
  double largest = 1.0, smallest = 10.0, low = 1.0, high = 0.0;
  for (int index = 0; index < 300; ++index) {
    const Example example = dataset->Get(index);
    const std::vector<int> sizes = InstanceSizes(example);
    counts.insert(sizes.size());
    const double ratio = static_cast<double>(sizes.front()) / sizes.back();
    largest = std::max(largest, ratio), smallest = std::min(smallest, ratio);
    const double outliers = 1.0 - CountLabelled(example) / 400.0;
    low = std::min(low, outliers), high = std::max(high, outliers);
  }
  CHECK(counts == std::set<std::size_t>{2, 3, 4, 5});
  CHECK((largest > 5.0 && largest < 7.5));
  CHECK(smallest < 1.15);
  CHECK((low > 0.098 && low < 0.13 && high < 0.602 && high > 0.57));  // up to rounding
  options.instances.size_ratio = 4.0;
  const std::vector<int> sizes = InstanceSizes(MakeSyntheticInstances(options, 5)->Get(0));
  CHECK(static_cast<double>(sizes.front()) / sizes.back() == Approx(4.0).epsilon(0.15));
}

TEST_CASE("structures: with more of them the first models stay, and crowded problems keep the fewest points") {
  for (int index = 0; index < 5; ++index) {
    const Example two = MakeSyntheticInstances(Fixed(Task::kLine, 2), 6)->Get(index);
    const Example four = MakeSyntheticInstances(Fixed(Task::kLine, 4), 6)->Get(index);
    for (int k = 0; k < 2; ++k) CHECK(two.truth.instances[k] == four.truth.instances[k]);
  }
  SyntheticInstancesOptions crowded = Fixed(Task::kPlane, 6);
  crowded.num_points = 30;
  crowded.outlier_ratio = 0.9;
  crowded.instances.size_ratio = 20.0;
  CHECK(InstanceSizes(MakeSyntheticInstances(crowded, 6)->Get(0)) == std::vector<int>(6, 5));
}

TEST_CASE("structures are arranged by size, and small ones become outliers") {
  GroundTruth truth;
  truth.assignment = {1, 3, 3, 0, 2, 2, 2, 4, 4, 0};
  for (int k = 1; k <= 4; ++k) truth.instances.push_back(ModelParameters::Constant(3, k));
  ArrangeInstances(2, &truth);
  CHECK(truth.assignment == std::vector<std::int32_t>{0, 2, 2, 0, 1, 1, 1, 3, 3, 0});
  CHECK(truth.inliers == std::vector<std::uint8_t>{0, 1, 1, 0, 1, 1, 1, 1, 1, 0});
  REQUIRE(truth.instances.size() == 3);
  CHECK(truth.instances[0][0] == 2.0);
  CHECK(truth.instances[1][0] == 3.0);
  CHECK(truth.instances[2][0] == 4.0);
  CHECK(truth.model[0] == 2.0);
  ArrangeInstances(10, &truth);
  CHECK(truth.instances.empty());
  CHECK(truth.model.size() == 0);
  CHECK(std::count(truth.assignment.begin(), truth.assignment.end(), 0) == 10);
}

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
          CHECK(after.problem.snn_ratio[i] == before.problem.snn_ratio[i]);
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
  without.problem.snn_ratio.resize(0);
  without.truth.inliers.clear();
  CHECK(unchanged(without));
}

}  // namespace

}  // namespace diffsac
