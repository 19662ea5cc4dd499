#include "diffsac/train/training_source.h"

#include <utility>

namespace diffsac {

TrainingSource::TrainingSource(const Dataset& dataset, PointFeatures features, LabelOptions labels, int copies,
                               int schedule_steps, std::uint64_t seed)
    : dataset_(dataset),
      features_(std::move(features)),
      labels_(std::move(labels)),
      copies_(copies),
      schedule_steps_(schedule_steps),
      rng_(Rng(seed).Fork("training_source")) {}

TrainingItem TrainingSource::Make(std::uint64_t index) const {
  // A finite dataset is seen again each epoch, with other labels, times and noise.
  const std::uint64_t position =
      dataset_.size() > 0 ? index % static_cast<std::uint64_t>(dataset_.size()) : index;
  const Example example = dataset_.Get(position);
  const Rng rng = rng_.Fork("item", index);
  TrainingItem item;
  item.features = features_.Compute(example.problem, rng.Fork("features"));
  item.inliers.assign(example.truth.inliers.begin(), example.truth.inliers.end());

  const auto sets = OptimalMinimalSets(example, labels_, labels_.top_m);
  const std::size_t points = item.inliers.size();
  item.labels.assign(copies_ * points, -1.0f);
  Rng choice = rng.Fork("label");
  Rng noise = rng.Fork("noise");
  Rng time = rng.Fork("time");
  for (int k = 0; k < copies_; ++k) {
    if (!sets.empty())
      for (const int i : sets[choice.Below(sets.size())].points) item.labels[k * points + i] = 1.0f;
    item.times.push_back(static_cast<int>(time.Below(schedule_steps_)));
  }
  item.noise.resize(copies_ * points);
  for (float& value : item.noise) value = static_cast<float>(noise.Normal());
  return item;
}

}  // namespace diffsac
