#include "diffsac/methods/oracle.h"

#include <chrono>

#include "diffsac/consensus/sample_consensus.h"

namespace diffsac {
namespace {

template <MinimalModel Model>
Estimate FitTruth(const Problem& problem, const GroundTruth& truth) {
  Estimate estimate;
  estimate.status = CheckPoints<Model>(problem.points);
  if (estimate.status != Status::kOk) return estimate;
  estimate.status = Status::kNoModel;
  const Eigen::Index size = problem.points.rows();
  if (static_cast<Eigen::Index>(truth.inliers.size()) != size) return estimate;
  Eigen::VectorXd weights(size);
  for (Eigen::Index i = 0; i < size; ++i) weights[i] = truth.inliers[i] != 0 ? 1.0 : 0.0;
  typename Model::Parameters model;
  estimate.report.hypotheses = 1;
  if (!Model::Fit(problem.points, weights, &model)) return estimate;
  estimate.status = Status::kOk;
  estimate.model = model;
  estimate.inliers = InlierMask<Model>(problem.points, model, problem.inlier_threshold);
  for (std::uint8_t inlier : estimate.inliers) estimate.score += inlier;
  return estimate;
}

}  // namespace

Estimate OracleEstimate(const Problem& problem, const GroundTruth& truth) {
  const auto start = std::chrono::steady_clock::now();
  Estimate estimate = problem.task == Task::kLine ? FitTruth<Line>(problem, truth) : FitTruth<Plane>(problem, truth);
  const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start;
  estimate.report.ms_consensus = estimate.report.ms_total = elapsed.count();
  return estimate;
}

}  // namespace diffsac
