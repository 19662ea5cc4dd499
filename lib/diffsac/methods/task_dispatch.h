#pragma once

#include <chrono>

#include "diffsac/data/task_dispatch.h"
#include "diffsac/methods/method.h"
#include "diffsac/methods/solver_space.h"

namespace diffsac {

/// DispatchTask for a body that returns an Estimate and does all its work in the consensus stage; reports the time.
template <class Body>
Estimate TimedEstimate(Task task, Body&& body) {
  const auto start = std::chrono::steady_clock::now();
  Estimate estimate = DispatchTask(task, body);
  const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start;
  estimate.report.ms_consensus = estimate.report.ms_total = elapsed.count();
  return estimate;
}

/// Makes *estimate a success with `model`: its inliers at the threshold, their number as the score.
template <MinimalModel Model>
void AcceptModel(const SolverSpace& space, const typename Model::Parameters& model, Estimate* estimate) {
  estimate->status = Status::kOk;
  estimate->model = model;
  estimate->inliers = InlierMask<Model>(space.points(), model, space.threshold());
  estimate->score = 0.0;
  for (std::uint8_t inlier : estimate->inliers) estimate->score += inlier;
}

}  // namespace diffsac
