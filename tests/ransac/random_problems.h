#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "diffsac/geometry/hyperplane.h"
#include "diffsac/ransac/sample_consensus.h"

namespace diffsac::testing {

/// Points on a random hyperplane with Gaussian noise across it, and uniform outliers in a box of side 10.
template <int D>
struct HyperplaneProblem {
  PointMatrix points;
  ModelParameters truth;
  std::vector<std::uint8_t> inliers;
};

template <int D>
HyperplaneProblem<D> MakeRandomProblem(int num_points, double outlier_ratio, double sigma, Rng rng) {
  using Vector = Eigen::Matrix<double, D, 1>;
  HyperplaneProblem<D> problem;
  Vector normal, center;
  for (double& value : normal) value = rng.Normal();
  normal.normalize();
  for (double& value : center) value = rng.Uniform(-1.0, 1.0);
  problem.truth.resize(D + 1);
  problem.truth << normal, -normal.dot(center);
  problem.points.resize(num_points, D);
  problem.inliers.assign(num_points, 0);
  const int outliers = static_cast<int>(std::lround(outlier_ratio * num_points));
  for (int i = 0; i < num_points; ++i) {
    Vector point;
    for (double& value : point) value = rng.Uniform(-5.0, 5.0);
    if (i >= outliers) {
      point += (sigma * rng.Normal() - normal.dot(point - center)) * normal;
      problem.inliers[i] = 1;
    }
    for (int j = 0; j < D; ++j) problem.points(i, j) = point[j];
  }
  return problem;
}

inline std::vector<int> AllSets(int num_points, int set_size) {
  ExhaustiveSampler source(num_points, set_size);
  return DrawSets(source, set_size, Combinations(num_points, set_size));
}

inline std::vector<int> RandomSets(int num_points, int set_size, int count, std::uint64_t seed) {
  UniformSampler source(num_points, set_size, Rng(seed));
  return DrawSets(source, set_size, count);
}

/// The loop over uniform sets, drawn from the same generator as the rest.
template <MinimalModel Model>
ConsensusResult SearchUniformly(const PointMatrix& points, double threshold, const ConsensusOptions& options,
                                const Rng& rng, const EstimationPriors& priors = {}, int threads = 1) {
  UniformSampler source(static_cast<int>(points.rows()), Model::kMinimalSize, rng.Fork("minimal_sets"));
  return SampleConsensus<Model>(points, threshold, source, options, rng, priors, threads);
}

/// The loop over every set, as far as the budget goes.
template <MinimalModel Model>
ConsensusResult SearchExhaustively(const PointMatrix& points, double threshold, const ConsensusOptions& options,
                                   const Rng& rng, const EstimationPriors& priors = {}, int threads = 1) {
  ExhaustiveSampler source(static_cast<int>(points.rows()), Model::kMinimalSize);
  return SampleConsensus<Model>(points, threshold, source, options, rng, priors, threads);
}

/// The loop over given sets, all of them unless the search is confident before.
template <MinimalModel Model>
ConsensusResult SearchSets(const PointMatrix& points, double threshold, std::span<const int> sets,
                           ConsensusOptions options, const Rng& rng, const EstimationPriors& priors = {},
                           int threads = 1) {
  PrecomputedSampler source(sets);
  options.max_iterations = std::max(1, static_cast<int>(sets.size()) / Model::kMinimalSize);
  return SampleConsensus<Model>(points, threshold, source, options, rng, priors, threads);
}

}  // namespace diffsac::testing
