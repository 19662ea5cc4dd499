#pragma once

#include <Eigen/Core>
#include <vector>

#include "diffsac/problem/normalized_problem.h"
#include "diffsac/problem/point_features.h"

namespace diffsac {

/// How likely each point is an inlier by its features alone, next to free where these are known:
/// matches: a logistic regression on the ratio's probability (estimate/estimation_priors.h) and on what the good
/// matches around do (neighborhood features), fitted on the matches of eleven development scenes (docs/experiments.md);
/// by the ratio alone for networks without neighborhood features, and .5 without either; lines and planes: how far a
/// point agrees with the hypotheses of the residual features, those of high score most. Values in [0, 1]; of the
/// latter only the order means something. features: of `kinds` for the problem.
Eigen::VectorXf PointPrior(const NormalizedProblem& space, const FeatureSet& features, const PointFeatures& kinds);

/// The `count` points of highest prior (the first where some tie), ascending.
std::vector<int> LikeliestPoints(const Eigen::VectorXf& prior, int count);

}  // namespace diffsac
