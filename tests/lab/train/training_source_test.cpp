#include "lab/train/training_source.h"

#include <catch2/catch.hpp>

#include <algorithm>

#include "diffsac/problem/tasks.h"
#include "lab/data/synthetic.h"

namespace diffsac {

TEST_CASE("a training item is a function of its index") {
  const auto dataset = MakeSynthetic(Task::kLine, {}, 1);
  const PointFeatures features(PointFeaturesOptions{}, Task::kLine);
  LabelOptions labels;
  labels.top_m = 4;
  const TrainingSource a(*dataset, features, labels, 3, 100, 1), b(*dataset, features, labels, 3, 100, 1),
      c(*dataset, features, labels, 3, 100, 2);
  const auto x = a.Make(7), y = b.Make(7), z = c.Make(7);
  CHECK(x.noise == y.noise);
  CHECK(x.labels == y.labels);
  CHECK(x.times == y.times);
  CHECK(x.features.values == y.features.values);
  CHECK(x.noise != z.noise);
  CHECK(x.noise != a.Make(8).noise);
}

TEST_CASE("labels are ±1 with γ points set, and only on true inliers") {
  const auto dataset = MakeSynthetic(Task::kPlane, {}, 1);
  LabelOptions labels;
  labels.top_m = 5;
  const TrainingSource source(*dataset, PointFeatures(PointFeaturesOptions{}, Task::kPlane), labels, 4, 100, 1);
  for (std::uint64_t index = 0; index < 5; ++index) {
    const auto item = source.Make(index);
    const std::size_t points = item.inliers.size();
    for (int k = 0; k < 4; ++k) {
      int set = 0;
      for (std::size_t i = 0; i < points; ++i) {
        const float label = item.labels[k * points + i];
        CHECK((label == 1.0f || label == -1.0f));
        if (label > 0) {
          ++set;
          CHECK(item.inliers[i] == 1.0f);
        }
      }
      CHECK(set == 3);
      CHECK((item.times[k] >= 0 && item.times[k] < 100));
    }
  }
}

}  // namespace diffsac
