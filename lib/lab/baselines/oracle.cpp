#include "lab/baselines/oracle.h"

#include "diffsac/estimate/task_dispatch.h"
#include "lab/config/estimator_registry.h"
#include "lab/options/options.h"

namespace diffsac {
namespace {

/// Least squares on the true inliers, from the true model where a fit needs a start (essential matrices).
template <MinimalModel Model>
bool FitFromTruth(const PointMatrix& points, const Eigen::VectorXd& weights, const ModelParameters& truth,
                  typename Model::Parameters* model) {
  if (truth.size() != Model::Parameters::SizeAtCompileTime) return Model::Fit(points, weights, model);
  *model = truth;
  return FitAgain<Model>(points, weights, model);
}

template <MinimalModel Model>
Estimate FitTruth(const NormalizedProblem& space, const GroundTruth& truth) {
  Estimate estimate;
  const Eigen::Index size = space.points().rows();
  if (static_cast<Eigen::Index>(truth.inliers.size()) != size) return estimate;
  Eigen::VectorXd weights(size);
  for (Eigen::Index i = 0; i < size; ++i) weights[i] = truth.inliers[i] != 0 ? 1.0 : 0.0;
  typename Model::Parameters model;
  estimate.stats.hypotheses = 1;
  if (!FitFromTruth<Model>(space.points(), weights, truth.model, &model)) return estimate;
  AcceptModel<Model>(space, model, &estimate);
  return estimate;
}

/// The same of each structure, with the true labels.
template <MinimalModel Model>
Estimate FitInstances(const NormalizedProblem& space, const GroundTruth& truth) {
  InstancesResult found;
  if (static_cast<Eigen::Index>(truth.assignment.size()) != space.points().rows()) return EstimateOf(std::move(found));
  const auto count = static_cast<std::int32_t>(truth.instances.size());
  std::vector<std::int32_t> place(static_cast<std::size_t>(count) + 1, 0);
  for (std::int32_t label = 1; label <= count; ++label) {
    Eigen::VectorXd weights(space.points().rows());
    for (Eigen::Index i = 0; i < weights.size(); ++i) weights[i] = truth.assignment[i] == label ? 1.0 : 0.0;
    typename Model::Parameters model;
    ++found.hypotheses;
    if (!FitFromTruth<Model>(space.points(), weights, truth.instances[label - 1], &model)) continue;
    found.models.emplace_back(model);
    place[label] = static_cast<std::int32_t>(found.models.size());
  }
  for (const std::int32_t label : truth.assignment) found.assignment.push_back(label <= count ? place[label] : 0);
  if (!found.models.empty()) found.status = Status::kOk;
  return EstimateOf(std::move(found));
}

}  // namespace

Estimate OracleEstimate(const Problem& problem, const GroundTruth& truth) {
  return TimedEstimate(NormalizedProblem(problem), [&]<MinimalModel Model>(const NormalizedProblem& space) {
    return truth.instances.empty() ? FitTruth<Model>(space, truth) : FitInstances<Model>(space, truth);
  });
}

namespace {

struct OracleOptions {
  void Bind(OptionsBinder&) {}
};

const RegisteredEstimator<OracleOptions> kOracle(
    "oracle", "The ceiling: least squares on the true inliers. No keys.", [](Task) { return OracleOptions(); },
    [](const OracleOptions&) {
      return TableRow(
          [](const Example& example, const RowCall&) { return OracleEstimate(example.problem, example.truth); });
    });

}  // namespace

}  // namespace diffsac
