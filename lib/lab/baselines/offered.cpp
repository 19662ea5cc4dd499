#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "diffsac/estimators/diffsac_options.h"
#include "diffsac/estimators/learned_estimator.h"
#include "lab/config/estimator_registry.h"
#include "lab/config/yaml.h"
#include "lab/truth/task_truth.h"

namespace diffsac {
namespace {

/// A learned row that finds the true model among its hypotheses: it is optimised, refined and chosen, or not, as one
/// that was drawn.
class OfferingEstimator : public RobustEstimator {
 public:
  /// Borrows both.
  OfferingEstimator(const LearnedEstimator& row, const ModelParameters& truth) : row_(row), truth_(truth) {}

 private:
  Estimate DoRun(const Problem& problem, std::uint64_t seed) const override {
    const SolverSpace space(problem);
    Estimate estimate;
    estimate.status = CheckSpace(space, ModelFromString(problem.task, ""));
    if (estimate.status != Status::kOk) return estimate;
    Prediction prediction = std::move(row_.Predict({&space, 1}, {&seed, 1}).front());
    prediction.models = {truth_};
    return row_.EstimateFrom(space, prediction, seed);
  }

  const LearnedEstimator& row_;
  const ModelParameters& truth_;
};

enum class Chosen { kByScore, kByTruth };

/// Of four runs of a learned row by seeds of their own, the estimate of the best score or the one nearest to the truth,
/// with what all of them cost.
Estimate OneOfFour(const RobustEstimator& row, const Example& example, std::uint64_t seed, Chosen chosen) {
  constexpr int kRuns = 4;
  const TaskTruth& truth = TruthOf(example.problem.task);
  const auto worth = [&](const Estimate& estimate) {
    if (estimate.status != Status::kOk) return -std::numeric_limits<double>::infinity();
    if (chosen == Chosen::kByScore) return estimate.score;
    const EstimateError error = truth.error(&estimate.model, estimate.inliers, example);
    return -(truth.error_in_pixels || std::isnan(error.angle_deg) ? error.error_px : error.angle_deg);
  };
  Estimate best = row.Run(example.problem, seed);
  EstimateReport all = best.report;
  Rng seeds(seed);
  for (int run = 1; run < kRuns; ++run) {
    Estimate other = row.Run(example.problem, seeds.NextU64());
    all.hypotheses += other.report.hypotheses;
    all.draws += other.report.draws;
    for (const auto cost : {&EstimateReport::ms_features, &EstimateReport::ms_network, &EstimateReport::ms_consensus,
                            &EstimateReport::ms_total})
      all.*cost += other.report.*cost;
    if (worth(other) > worth(best)) best = std::move(other);
  }
  all.unique_minimal_sets = best.report.unique_minimal_sets;
  best.report = all;
  return best;
}

/// What the type `diffsac` makes of a row of another type, which runs it on an example in its own way.
using RunRow = Estimate (*)(const LearnedEstimator& row, const Example& example, std::uint64_t seed);
EstimatorEntry OverLearned(const std::string& type, const std::string& help, RunRow run) {
  const auto learned = []() -> const EstimatorEntry& {
    return Registry<EstimatorEntry>::Instance().Find("diffsac", "");
  };
  const auto own = [type](const Config& row) { return row.MergedWith(ConfigFromYaml("{type: diffsac}", type)); };
  EstimatorEntry entry;
  entry.help = help;
  entry.make = [=](const Config& row, Task task, const EstimatorContext& context) {
    const std::shared_ptr<const RobustEstimator> estimator = learned().make(own(row), task, context).TakeEstimator();
    return TableRow([estimator, run](const Example& example, const RowCall& call) {
      return run(dynamic_cast<const LearnedEstimator&>(*estimator), example, call.seed);
    });
  };
  entry.resolve = [=](const Config& row, Task task, const EstimatorContext& context) {
    return learned().resolve(own(row), task, context).MergedWith(ConfigFromYaml("{type: " + type + "}", type));
  };
  entry.describe = [=](Task task) { return learned().describe(task); };
  entry.options = typeid(DiffsacOptions);
  return entry;
}

Registered<EstimatorEntry> Register(const std::string& type, const std::string& help, RunRow run) {
  return {type, OverLearned(type, help, run)};
}

const auto kOffered = Register(
    "offered", "The row `diffsac` with the true model among its hypotheses: what is still wrong is chosen wrongly.",
    [](const LearnedEstimator& row, const Example& example, std::uint64_t seed) {
      return OfferingEstimator(row, example.truth.model).Run(example.problem, seed);
    });
const auto kBestOfFour = Register("best_of_four", "Of four runs of the row `diffsac` the one of the best score.",
                                  [](const LearnedEstimator& row, const Example& example, std::uint64_t seed) {
                                    return OneOfFour(row, example, seed, Chosen::kByScore);
                                  });
const auto kNearestOfFour =
    Register("nearest_of_four",
             "Of four runs of the row `diffsac` the one nearest to the truth: what a better choice could gain.",
             [](const LearnedEstimator& row, const Example& example, std::uint64_t seed) {
               return OneOfFour(row, example, seed, Chosen::kByTruth);
             });

}  // namespace
}  // namespace diffsac
