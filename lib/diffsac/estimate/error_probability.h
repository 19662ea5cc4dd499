#pragma once

#include "diffsac/estimate/robust_estimator.h"

namespace diffsac {

/// How likely an essential or fundamental matrix is wrong, by more than 10° of R or t: a logistic of the number and the
/// share of the inliers, of how many of them the network expected (where one was used), and of how well neighbouring
/// inliers of one image are neighbours in the other. Trained on the matches of photographs of the training and tuning
/// scenes (docs/results/verdicts.md); of other matches take it as an order. NaN for other tasks and without a model.
double ErrorProbability(const Problem& problem, const Estimate& estimate);

}  // namespace diffsac
