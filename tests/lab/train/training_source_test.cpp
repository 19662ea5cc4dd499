#include "lab/train/training_source.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/problem/tasks.h"
#include "lab/data/synthetic.h"
#include "lab/train/prefetcher.h"

namespace diffsac {

TEST_CASE("a training item is a function of its index") {
  const std::vector<TrainingPart> parts = {{MakeSynthetic(Task::kLine, {}, 1), 1.0}};
  const PointFeatures features(PointFeaturesOptions{}, Task::kLine);
  LabelOptions labels;
  labels.top_m = 4;
  const TrainingSource a(parts, features, {labels, 8}, {}, 1), b(parts, features, {labels, 8}, {}, 1),
      c(parts, features, {labels, 8}, {}, 2);
  const auto x = a.Make(7), y = b.Make(7), z = c.Make(7);
  CHECK(x.labels == y.labels);
  CHECK(x.features.values == y.features.values);
  CHECK(x.labels != z.labels);
  CHECK(RandomOf(1, 7).Seed() == RandomOf(1, 7).Seed());
  CHECK(RandomOf(1, 7).Seed() != RandomOf(1, 8).Seed());
}

namespace {

class Truthless : public Dataset {
 public:
  Task task() const override { return Task::kFundamental; }
  std::int64_t size() const override { return 3; }
  Example Get(std::uint64_t) const override {
    Example example;
    example.problem.task = Task::kFundamental;
    example.problem.points = PointMatrix::Random(40, 4);
    return example;
  }
  std::string FolderOf(const std::string&) const override { return "data/scene"; }
};

}  // namespace

TEST_CASE("data without truth cannot teach and says so") {
  const PointFeatures features(PointFeaturesOptions{}, Task::kFundamental);
  const TrainingSource source({{std::make_shared<Truthless>(), 1.0}}, features, {{}, 1}, {}, 1);
  CHECK_THROWS_WITH(source.Make(0), Catch::Contains("data/scene: no truth to learn from: R.h5 and T.h5"));
}

TEST_CASE("labels are γ true inliers") {
  LabelOptions labels;
  labels.top_m = 5;
  const TrainingSource source({{MakeSynthetic(Task::kPlane, {}, 1), 1.0}},
                              PointFeatures(PointFeaturesOptions{}, Task::kPlane), {labels, 4}, {}, 1);
  for (std::uint64_t index = 0; index < 5; ++index) {
    const auto item = source.Make(index);
    REQUIRE(item.labels.size() == 4);
    for (const auto& label : item.labels) {
      CHECK(label.size() == 3);
      for (const int i : label) CHECK(item.inliers[i] == 1.0f);
    }
  }
}

namespace {

std::vector<std::uint64_t> Take(int workers, int depth, std::uint64_t first, int count) {
  Prefetcher<std::uint64_t> items(
      [](std::uint64_t index) {
        Rng rng = Rng(4).Fork("item", index);
        // Items that take different times finish out of order.
        std::this_thread::sleep_for(std::chrono::microseconds(rng.Below(300)));
        return rng.NextU64();
      },
      workers, depth, first);
  std::vector<std::uint64_t> taken;
  for (int i = 0; i < count; ++i) taken.push_back(items.Next());
  CHECK(items.wait_seconds() >= 0.0);
  return taken;
}

}  // namespace

TEST_CASE("the sequence does not depend on workers and queue depth") {
  const auto expected = Take(0, 1, 0, 200);
  CHECK(Take(1, 1, 0, 200) == expected);
  CHECK(Take(1, 8, 0, 200) == expected);
  CHECK(Take(4, 2, 0, 200) == expected);
  CHECK(Take(4, 16, 0, 200) == expected);
  const auto later = Take(4, 8, 150, 50);
  CHECK(std::equal(later.begin(), later.end(), expected.begin() + 150));
}

TEST_CASE("an exception reaches the consumer at its place and stays") {
  for (int workers : {0, 1, 4}) {
    Prefetcher<int> items(
        [](std::uint64_t index) {
          if (index == 7) throw std::runtime_error("item seven");
          return static_cast<int>(index);
        },
        workers, 8);
    for (int i = 0; i < 7; ++i) CHECK(items.Next() == i);
    CHECK_THROWS_WITH(items.Next(), "item seven");
    CHECK_THROWS_WITH(items.Next(), "item seven");
  }
}

TEST_CASE("no more than the queue's depth is made ahead") {
  std::atomic<int> made{0};
  Prefetcher<int> items(
      [&](std::uint64_t index) {
        ++made;
        return static_cast<int>(index);
      },
      2, 5);
  items.Next();
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
  CHECK(made <= 6);
  CHECK(made >= 1);
}

TEST_CASE("it stops cleanly with items unread, and moves items that cannot be copied") {
  for (int repeat = 0; repeat < 20; ++repeat) {
    Prefetcher<std::unique_ptr<int>> items(
        [](std::uint64_t index) { return std::make_unique<int>(static_cast<int>(index)); }, 3, 4);
    if (repeat % 2 == 0) CHECK(*items.Next() == 0);
  }
}

}  // namespace diffsac
