#pragma once

#include <chrono>

#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/data/problem.h"
#include "diffsac/methods/method.h"

namespace diffsac {

/// Calls `body.template operator()<Model>()` with the geometry model of a task.
template <class Body>
auto DispatchTask(Task task, Body&& body) {
  if (task == Task::kPlane) return body.template operator()<Plane>();
  return body.template operator()<Line>();
}

/// DispatchTask for a body that returns an Estimate and does all its work in the consensus stage; reports the time.
template <class Body>
Estimate TimedEstimate(Task task, Body&& body) {
  const auto start = std::chrono::steady_clock::now();
  Estimate estimate = DispatchTask(task, body);
  const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start;
  estimate.report.ms_consensus = estimate.report.ms_total = elapsed.count();
  return estimate;
}

/// Makes *estimate a success with `model`: its inliers at the problem's threshold, their number as the score.
template <MinimalModel Model>
void AcceptModel(const Problem& problem, const typename Model::Parameters& model, Estimate* estimate) {
  estimate->status = Status::kOk;
  estimate->model = model;
  estimate->inliers = InlierMask<Model>(problem.points, model, problem.inlier_threshold);
  estimate->score = 0.0;
  for (std::uint8_t inlier : estimate->inliers) estimate->score += inlier;
}

}  // namespace diffsac
