#include <utility>

#include "diffsac/estimators/diffsac_options.h"
#include "diffsac/estimators/learned_estimator.h"
#include "lab/config/estimator_registry.h"
#include "lab/config/yaml.h"

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

/// What the type `diffsac` makes of a row of this type.
EstimatorEntry Offered() {
  const auto learned = []() -> const EstimatorEntry& {
    return Registry<EstimatorEntry>::Instance().Find("diffsac", "");
  };
  const auto own = [](const Config& row) { return row.MergedWith(ConfigFromYaml("{type: diffsac}", "offered")); };
  EstimatorEntry entry;
  entry.help =
      "The row `diffsac` with the true model among its hypotheses: what is still wrong is chosen "
      "wrongly.";
  entry.make = [=](const Config& row, Task task, const EstimatorContext& context) {
    const std::shared_ptr<const RobustEstimator> estimator = learned().make(own(row), task, context).TakeEstimator();
    return TableRow([estimator](const Example& example, const RowCall& call) {
      const auto& row = dynamic_cast<const LearnedEstimator&>(*estimator);
      return OfferingEstimator(row, example.truth.model).Run(example.problem, call.seed);
    });
  };
  entry.resolve = [=](const Config& row, Task task, const EstimatorContext& context) {
    return learned().resolve(own(row), task, context).MergedWith(ConfigFromYaml("{type: offered}", "offered"));
  };
  entry.describe = [=](Task task) { return learned().describe(task); };
  entry.options = typeid(DiffsacOptions);
  return entry;
}

const Registered<EstimatorEntry> kOffered("offered", Offered());

}  // namespace
}  // namespace diffsac
