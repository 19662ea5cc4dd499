#include "diffsac/methods/oracle.h"

#include "diffsac/methods/method_registry.h"
#include "diffsac/methods/task_dispatch.h"

namespace diffsac {
namespace {

template <MinimalModel Model>
Estimate FitTruth(const SolverSpace& space, const GroundTruth& truth) {
  Estimate estimate;
  const Eigen::Index size = space.points().rows();
  if (static_cast<Eigen::Index>(truth.inliers.size()) != size) return estimate;
  Eigen::VectorXd weights(size);
  for (Eigen::Index i = 0; i < size; ++i) weights[i] = truth.inliers[i] != 0 ? 1.0 : 0.0;
  typename Model::Parameters model;
  estimate.report.hypotheses = 1;
  if (!Model::Fit(space.points(), weights, &model)) return estimate;
  AcceptModel<Model>(space, model, &estimate);
  return estimate;
}

}  // namespace

Estimate OracleEstimate(const Problem& problem, const GroundTruth& truth) {
  return TimedEstimate(problem,
                       [&]<MinimalModel Model>(const SolverSpace& space) { return FitTruth<Model>(space, truth); });
}

namespace {

struct OracleOptions {
  void Bind(OptionsBinder&) {}
};

const RegisteredMethod<OracleOptions> kOracle(
    "oracle", "The ceiling: least squares on the true inliers. No keys.", [](Task) { return OracleOptions(); },
    [](const OracleOptions&) -> std::unique_ptr<Method> {
      throw Error("oracle: is shown the truth, so it is no method but the experiment's");
    });

}  // namespace

}  // namespace diffsac
