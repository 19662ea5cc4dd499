#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "diffsac/core/parallel.h"
#include "diffsac/methods/task_dispatch.h"

namespace diffsac {

/// What a row with a network returns: EstimateOf, the hypotheses of the features counted as well, and the time since
/// `start` as that of consensus.
inline Estimate EstimateOf(ConsensusResult result, int feature_hypotheses, MethodClock::time_point start) {
  Estimate estimate = EstimateOf(std::move(result));
  estimate.report.hypotheses += feature_hypotheses;
  estimate.report.ms_consensus = MillisecondsSince(start);
  return estimate;
}

/// Several problems through one network: those that cannot be estimated from get their status, the others go through
/// `predict(problems, seeds, &ms_features, &ms_network)` together, which returns a prediction for each, and then in
/// parallel through `finish(problem, prediction, seed)`. Times are shared equally.
template <class Predict, class Finish>
std::vector<Estimate> EstimateTogether(std::span<const Problem> problems, std::span<const std::uint64_t> seeds,
                                       int threads, const Predict& predict, const Finish& finish) {
  const auto start = MethodClock::now();
  std::vector<Estimate> estimates(problems.size());
  std::vector<const Problem*> good;
  std::vector<std::uint64_t> good_seeds;
  std::vector<std::size_t> place;
  for (std::size_t i = 0; i < problems.size(); ++i) {
    estimates[i].status = CheckProblem(problems[i]);
    if (estimates[i].status != Status::kOk) continue;
    good.push_back(&problems[i]);
    good_seeds.push_back(seeds[i]);
    place.push_back(i);
  }
  if (good.empty()) return estimates;

  double ms_features = 0.0, ms_network = 0.0;
  const auto predictions = predict(good, good_seeds, &ms_features, &ms_network);
  ParallelFor(static_cast<std::int64_t>(good.size()), threads,
              [&](std::int64_t b) { estimates[place[b]] = finish(*good[b], predictions[b], good_seeds[b]); });
  const double share = 1.0 / static_cast<double>(good.size());
  const double ms_total = MillisecondsSince(start);
  for (const std::size_t i : place) {
    estimates[i].report.ms_features = ms_features * share;
    estimates[i].report.ms_denoise = ms_network * share;
    estimates[i].report.ms_total = ms_total * share;
  }
  return estimates;
}

}  // namespace diffsac
