#include "diffsac/train/validation.h"

#include <sstream>

#include "diffsac/data/dataset_factory.h"
#include "diffsac/eval/metrics.h"
#include "diffsac/geometry/hyperplane.h"

namespace diffsac {

Validation::Validation(Task task, const Config& data, const ValidationOptions& options, std::uint64_t seed)
    : options_(options), seed_(seed) {
  for (const double ratio : options.outlier_ratios) {
    auto config = Config::FromString(data.Dump(), data.Where());
    std::ostringstream assignment;
    assignment << "outlier_ratio=" << ratio;
    config.Set(assignment.str());
    config.Set("split=validation");
    const auto dataset = MakeDataset(config, seed);
    if (dataset->task() != task) throw Error(data.Where() + ": this data is not of task '" + ToString(task) + "'");
    auto& group = examples_.emplace_back();
    for (int i = 0; i < options.problems; ++i) group.push_back(dataset->Get(i));
  }
}

std::vector<double> Validation::Run(const DiffsacMethod& method) const {
  std::vector<double> results;
  for (const auto& group : examples_) {
    std::vector<double> errors;
    const std::size_t batch = method.PreferredBatch();
    for (std::size_t first = 0; first < group.size(); first += batch) {
      std::vector<Problem> problems;
      std::vector<std::uint64_t> seeds;
      for (std::size_t i = first; i < std::min(first + batch, group.size()); ++i) {
        problems.push_back(group[i].problem);
        seeds.push_back(Rng(seed_).Fork("validation", i).Seed());
      }
      const auto estimates = method.EstimateBatch(problems, seeds);
      for (std::size_t i = 0; i < estimates.size(); ++i)
        errors.push_back(estimates[i].status == Status::kOk
                             ? AngleBetweenDegrees(estimates[i].model, group[first + i].truth.model)
                             : 90.0);
    }
    results.push_back(MeanAverageAccuracy(errors, options_.threshold_deg));
  }
  return results;
}

}  // namespace diffsac
