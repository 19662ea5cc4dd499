#include "diffsac/problem/deduplicated_points.h"

#include <catch2/catch.hpp>
#include <limits>
#include <map>

#include "diffsac/core/random.h"
#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Problem Lines(std::initializer_list<std::array<double, 2>> points) {
  Problem problem;
  problem.points.resize(static_cast<Eigen::Index>(points.size()), 2);
  Eigen::Index i = 0;
  for (const auto& point : points) problem.points.row(i++) << point[0], point[1];
  return problem;
}

TEST_CASE("A segment says the same from either end, and counts once") {
  Problem problem;
  problem.task = Task::kVanishingPoint;
  problem.points.resize(3, 4);
  problem.points << 1, 2, 3, 4, 3, 4, 1, 2, 5, 6, 7, 8;
  CHECK(DeduplicatedPoints(problem).repeated() == 1);
  problem.task = Task::kFundamental;
  CHECK(DeduplicatedPoints(problem).repeated() == 0);
}

}  // namespace

TEST_CASE("where every row is usable the problem itself is, not a copy") {
  const Problem problem = Lines({{1, 2}, {2, 1}, {1, 1}});
  const DeduplicatedPoints rows(problem);
  CHECK(&rows.problem() == &problem);
  CHECK(rows.left_out() == 0);
  CHECK(rows.repeated() == 0);
  CHECK(rows.RowOf(2) == 2);
  std::vector<int> values = {7, 8, 9};
  rows.Spread(&values);
  CHECK(values == std::vector<int>{7, 8, 9});
  const Problem none = Lines({});
  CHECK(&DeduplicatedPoints(none).problem() == &none);
}

TEST_CASE("of equal rows the one with the best ratio stays, in the place of the first, with all that is its own") {
  Problem problem = Lines({{5, 0}, {1, 2}, {kNan, 2}, {5, -0.0}, {1, 2}, {3, 3}, {1, 2}});
  problem.snn_ratio.resize(7);
  problem.snn_ratio << 0.9, 0.8, 0.1, 0.9, 0.6, 0.5, 0.7;
  problem.scale_rotation_changes.resize(7, 2);
  problem.descriptors.resize(7, 1);
  for (int i = 0; i < 7; ++i) {
    problem.scale_rotation_changes.row(i) << i, -i;
    problem.descriptors(i, 0) = static_cast<float>(10 * i);
  }
  problem.size1 = {640, 480};
  const DeduplicatedPoints rows(problem);
  CHECK(rows.left_out() == 1);
  CHECK(rows.repeated() == 3);
  const Problem& used = rows.problem();
  REQUIRE(used.points.rows() == 3);
  CHECK(used.points.row(0) == Eigen::RowVector2d(5, 0));
  CHECK(used.points.row(1) == Eigen::RowVector2d(1, 2));
  CHECK(used.snn_ratio == Eigen::Vector3d(0.9, 0.6, 0.5));
  CHECK(used.scale_rotation_changes.col(0) == Eigen::Vector3d(0, 4, 5));
  CHECK(used.descriptors.col(0) == Eigen::Vector3f(0, 40, 50));
  CHECK(used.size1 == problem.size1);
  CHECK(rows.RowOf(1) == 4);
  std::vector<std::uint8_t> mask = {0, 1, 1}, nothing;
  rows.Spread(&mask);
  CHECK(mask == std::vector<std::uint8_t>{0, 1, 0, 0, 1, 1, 1});
  rows.Spread(&nothing);
  CHECK(nothing.empty());
}

TEST_CASE("without ratios the first of equal rows stays") {
  const Problem problem = Lines({{1, 2}, {2, 1}, {1, 2}});
  CHECK(DeduplicatedPoints(problem).RowOf(0) == 0);
}

TEST_CASE("rows in random order are merged as comparing everything with everything says") {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed);
    Problem problem;
    problem.task = Task::kFundamental;
    problem.points.resize(300, 4);
    for (Eigen::Index i = 0; i < problem.points.size(); ++i)
      problem.points.data()[i] = static_cast<double>(rng.Below(4)) - 1.0;
    std::map<std::array<double, 4>, int> known;
    std::vector<int> expected;
    for (Eigen::Index i = 0; i < 300; ++i) {
      const auto row = problem.points.row(i);
      const int next = static_cast<int>(known.size());
      expected.push_back(known.try_emplace({row[0], row[1], row[2], row[3]}, next).first->second);
    }
    const DeduplicatedPoints rows(problem);
    std::vector<int> numbers;
    for (int i = 0; i < rows.problem().points.rows(); ++i) numbers.push_back(i);
    rows.Spread(&numbers);
    CHECK(numbers == expected);
  }
}

}  // namespace diffsac
