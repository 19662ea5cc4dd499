#include "diffsac/estimate/point_prior.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "diffsac/problem/neighborhood_features.h"
#include "diffsac/problem/residual_features.h"

namespace diffsac {
namespace {

/// Of the logit: constant, the ratio's logit, and the three neighborhood features (the second by its absolute value).
constexpr float kConstant = -0.76f, kOfRatio = 0.56f, kOfShared = 3.0f, kOfStretch = 1.4f, kOfIncoherence = -3.0f;

Eigen::VectorXf OfMatches(const NormalizedProblem& space, const FeatureSet& features, int first_neighborhood) {
  const Eigen::Index count = space.points().rows();
  Eigen::ArrayXf prior = Eigen::ArrayXf::Constant(count, 0.5f);
  if (space.match_probabilities().size() == count) prior = space.match_probabilities().cast<float>().array();
  if (first_neighborhood < 0) return prior;
  const auto column = [&](int i) { return features.values.col(first_neighborhood + i).array(); };
  const Eigen::ArrayXf logit = kConstant + kOfRatio * (prior / (1.0f - prior)).log() + kOfShared * column(0) +
                               kOfStretch * column(1).abs() + kOfIncoherence * column(2);
  return 1.0f / (1.0f + (-logit).exp());
}

Eigen::VectorXf OfResiduals(const FeatureSet& features, int first) {
  const auto hypotheses = static_cast<int>(features.values.cols() - first) / kColumnsPerHypothesis;
  Eigen::VectorXf prior = Eigen::VectorXf::Zero(features.values.rows());
  float total = 1e-12f;
  for (int j = 0; j < hypotheses; ++j) {
    const int column = first + j * kColumnsPerHypothesis;
    const float score = features.values(0, column + 2);  // the same for all points
    prior += score * score * features.values.col(column);
    total += score * score;
  }
  return prior / total;
}

}  // namespace

Eigen::VectorXf PointPrior(const NormalizedProblem& space, const FeatureSet& features, const PointFeatures& kinds) {
  const Problem& problem = space.problem();
  if (IsTwoView(problem.task)) return OfMatches(space, features, kinds.first_neighborhood());
  if (kinds.first_residual() >= 0 && features.values.rows() > 0) return OfResiduals(features, kinds.first_residual());
  return Eigen::VectorXf::Constant(problem.points.rows(), 0.5f);
}

std::vector<int> LikeliestPoints(const Eigen::VectorXf& prior, int count) {
  std::vector<int> order(prior.size());
  std::iota(order.begin(), order.end(), 0);
  if (count >= static_cast<int>(order.size())) return order;
  const auto likelier = [&](int a, int b) { return prior[a] != prior[b] ? prior[a] > prior[b] : a < b; };
  std::nth_element(order.begin(), order.begin() + count, order.end(), likelier);
  order.resize(count);
  std::sort(order.begin(), order.end());
  return order;
}

}  // namespace diffsac
