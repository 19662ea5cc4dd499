#include "diffsac/train/validation.h"

#include <algorithm>
#include <cstdio>

#include "diffsac/core/status.h"
#include "diffsac/core/yaml_tree.h"
#include "diffsac/data/dataset_factory.h"

namespace diffsac {
namespace {

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

// `data` with what `validation.data` changes, or that alone where it is other data altogether.
Config ValidationData(const Config& config) {
  const Config own = config.Sub("validation.data");
  if (own.Has("type")) return own;
  Config data = config.Sub("data");
  if (data.Has("type") && data.Text("type") == "mixture") {
    data = data.Sequence("parts").at(0);
    Config part;
    part.impl_->document->root = *data.impl_->Get();
    std::erase_if(part.impl_->document->root.entries, [](const YamlEntry& entry) { return entry.key == "weight"; });
    data = part;
  }
  Config merged;
  if (const YamlTree* tree = data.impl_->Get()) merged.impl_->document->root = *tree;
  if (const YamlTree* over = own.impl_->Get()) MergeYaml(merged.impl_->document->root, *over);
  return merged;
}

bool HasSplits(const Config& data) {
  if (!data.Has("type")) return false;
  const std::string type = data.Text("type");
  return type.starts_with("synthetic_") || type == "modelnet40";
}

}  // namespace

Validation::Validation(Task task, const Config& config, const ValidationOptions& options, std::uint64_t seed)
    : options_(options),
      seed_(seed),
      tolerance_(options.ToleranceOf(task)) {
  Config data = ValidationData(config);
  if (HasSplits(data)) data.Set("split=validation");
  if (options.outlier_ratios.empty()) AddGroup(task, data, "");
  for (const double ratio : options.outlier_ratios) {
    data.Set("outlier_ratio=" + Number(ratio));
    AddGroup(task, data, "_outliers_" + Number(ratio));
  }
}

void Validation::AddGroup(Task task, const Config& data, const std::string& suffix) {
  const auto dataset = MakeDataset(data, seed_);
  if (dataset->task() != task)
    throw Error(data.Where() + ": validation data of task '" + ToString(dataset->task()) + "', but task is '" +
                ToString(task) + "'");
  const std::int64_t size = dataset->size();
  const std::int64_t count = size < 0 ? options_.problems : std::min<std::int64_t>(options_.problems, size);
  if (count == 0) throw Error(data.Where() + ": no validation problems");
  auto& group = examples_.emplace_back();
  // Evenly spread over a finite set, so that every scene has its share.
  for (std::int64_t i = 0; i < count; ++i) group.push_back(dataset->Get(size < 0 ? i : i * size / count));
  names_.push_back("mAA@" + Number(tolerance_.value) + (tolerance_.pixels ? "px" : "deg") + suffix);
}

std::vector<double> Validation::Run(const Method& method) const {
  std::vector<double> results;
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
      const auto estimates = method.EstimateBatch(problems, seeds);
      for (std::size_t i = 0; i < estimates.size(); ++i)
        sum += AverageAccuracyWithin(MainError(MeasureError(estimates[i], group[first + i]), tolerance_), tolerance_);
    }
    results.push_back(sum / static_cast<double>(group.size()));
  }
  return results;
}

}  // namespace diffsac
