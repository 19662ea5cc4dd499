#pragma once

#include <chrono>
#include <utility>

#include "diffsac/estimate/pose_covariance.h"
#include "diffsac/estimate/robust_estimator.h"
#include "diffsac/problem/normalized_problem.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/ransac/instances/instances.h"
#include "diffsac/ransac/sample_consensus.h"

namespace diffsac {

using EstimatorClock = std::chrono::steady_clock;

inline double MillisecondsSince(EstimatorClock::time_point start) {
  return std::chrono::duration<double, std::milli>(EstimatorClock::now() - start).count();
}

/// The estimate of a row that does all its work in the consensus stage, with its time: DispatchTask of a body that is
/// called with the problem's NormalizedProblem and returns an Estimate. Points that cannot be estimated from do not
/// reach it.
template <class Body>
Estimate TimedEstimate(const NormalizedProblem& space, const Body& body) {
  const auto start = EstimatorClock::now();
  const Task task = space.problem().task;
  Estimate estimate;
  estimate.status = CheckSpace(space, {task});
  if (estimate.status == Status::kOk)
    estimate = DispatchTask(task, [&]<MinimalModel Model>() { return body.template operator()<Model>(space); });
  estimate.stats.ms_consensus = estimate.stats.ms_total = MillisecondsSince(start);
  return estimate;
}

/// What consensus found in the problem's space, without times.
inline Estimate EstimateOf(const NormalizedProblem& space, ConsensusResult result) {
  Estimate estimate;
  estimate.status = result.status;
  estimate.model = std::move(result.model);
  estimate.inliers = std::move(result.inliers);
  estimate.score = result.score;
  estimate.inlier_threshold = space.unit() * result.inlier_threshold;
  estimate.sigma = space.unit() * result.sigma;
  if (estimate.status == Status::kOk) estimate.pose = PoseOfEstimate(estimate.model, estimate.inliers, space);
  if (estimate.pose)
    estimate.cheirality_failure_ratio =
        LeaveOutBehind(space, estimate.model, *estimate.pose, result.inlier_threshold, &estimate.inliers);
  // A rival of so few points is one that chance gives.
  if (result.other && result.other_inliers > 0 &&
      Log10NfaOf(space.problem(), result.other_inliers, estimate.inlier_threshold) > 0.0)
    result.other.reset();
  if (result.other) estimate.ambiguous_pose = PoseOfEstimate(*result.other, estimate.inliers, space);
  if (result.fit && !result.other && estimate.pose)
    estimate.pose_covariance = PoseCovarianceOf(space, estimate.model, *estimate.pose, *result.fit);
  estimate.minimal_sets = std::move(result.first_sets);
  estimate.stats.hypotheses = result.hypotheses;
  estimate.stats.unique_minimal_sets = result.unique_minimal_sets;
  estimate.stats.iterations = result.iterations;
  if (result.focal) estimate.focal = FocalEstimateOf(*result.focal, space.problem());
  return estimate;
}

/// The same of several structures; `score` is the number of points that they explain.
inline Estimate EstimateOf(InstancesResult found) {
  Estimate estimate;
  estimate.status = found.status;
  estimate.minimal_sets = std::move(found.first_sets);
  estimate.stats.hypotheses = found.hypotheses;
  estimate.stats.unique_minimal_sets = found.unique_minimal_sets;
  estimate.stats.iterations = found.iterations;
  if (found.status != Status::kOk) return estimate;
  estimate.model = found.models.front();
  for (const std::int32_t label : found.assignment) {
    estimate.inliers.push_back(label > 0);
    estimate.score += label > 0;
  }
  estimate.instances = std::move(found.models);
  estimate.assignment = std::move(found.assignment);
  estimate.instance_values = std::move(found.values);
  return estimate;
}

/// Makes *estimate a success with `model`: its inliers at the threshold, their number as the score.
template <MinimalModel Model>
void AcceptModel(const NormalizedProblem& space, const typename Model::Parameters& model, Estimate* estimate) {
  estimate->status = Status::kOk;
  estimate->model = model;
  estimate->inliers = InlierMask<Model>(space.points(), model, space.threshold());
  estimate->score = 0.0;
  for (std::uint8_t inlier : estimate->inliers) estimate->score += inlier;
}

}  // namespace diffsac
