#include "lab/train/validation.h"

#include <algorithm>

#include "diffsac/core/status.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"
#include "lab/eval/format.h"

namespace diffsac {

Config ValidationData(const TrainConfig& options) {
  const Config own = options.validation.data.value_or(Config());
  // A copy: groups change it.
  if (own.Has("type")) return own.MergedWith(Config());
  return FirstTrainingPart(options.data).MergedWith(own);
}

Validation::Validation(const TrainConfig& options)
    : problems_(options.validation.problems),
      seed_(options.train.seed),
      tolerance_(options.validation.ToleranceOf(options.task)) {
  Config data = ValidationData(options);
  if (IsGenerated(data)) SetYaml(&data, "split=validation");
  const auto& ratios = options.validation.outlier_ratios;
  if (ratios.empty()) AddGroup(options.task, data, "");
  for (const double ratio : ratios) {
    SetYaml(&data, "outlier_ratio=" + Format("%g", ratio));
    AddGroup(options.task, data, "_outliers_" + Format("%g", ratio));
  }
}

void Validation::AddGroup(Task task, const Config& data, const std::string& suffix) {
  const auto dataset = MakeDataset(data, seed_);
  if (dataset->task() != task)
    throw Error(data.Where() + ": validation data of task '" + ToString(dataset->task()) + "', but task is '" +
                ToString(task) + "'");
  const std::int64_t size = dataset->size();
  const std::int64_t count = size < 0 ? problems_ : std::min<std::int64_t>(problems_, size);
  if (count == 0) throw Error(data.Where() + ": no validation problems");
  auto& group = examples_.emplace_back();
  // Evenly spread over a finite set, so that every scene has its share.
  for (std::int64_t i = 0; i < count; ++i) group.push_back(dataset->Get(size < 0 ? i : i * size / count));
  const bool several = !group.front().truth.instances.empty();
  names_.push_back(several ? "recall" + suffix
                           : Format("mAA@%g", tolerance_.value) + (tolerance_.pixels ? "px" : "deg") + suffix);
}

std::int64_t Validation::size() const {
  std::int64_t size = 0;
  for (const auto& group : examples_) size += static_cast<std::int64_t>(group.size());
  return size;
}

std::optional<std::vector<double>> Validation::Run(const RobustEstimator& method, const Watch& watch) const {
  std::vector<double> results;
  std::int64_t done = 0;
  for (const auto& group : examples_) {
    double sum = 0.0;
    const std::size_t batch = method.PreferredBatch();
    for (std::size_t first = 0; first < group.size(); first += batch) {
      std::vector<const Problem*> problems;
      std::vector<std::uint64_t> seeds;
      for (std::size_t i = first; i < std::min(first + batch, group.size()); ++i) {
        problems.push_back(&group[i].problem);
        seeds.push_back(Rng(seed_).Fork("validation", i).Seed());
      }
      const auto estimates = method.RunBatch(problems, seeds);
      for (std::size_t i = 0; i < estimates.size(); ++i)
        sum += AccuracyOf(MeasureError(estimates[i], group[first + i]), tolerance_);
      done += static_cast<std::int64_t>(estimates.size());
      if (!watch(done)) return std::nullopt;
    }
    results.push_back(sum / static_cast<double>(group.size()));
  }
  return results;
}

}  // namespace diffsac
