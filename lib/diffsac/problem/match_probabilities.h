#pragma once

#include <Eigen/Core>

#include "diffsac/problem/problem.h"

namespace diffsac {

/// The probability that a match of this ratio is an inlier: so many of the mutual matches of RootSIFT lie within 3 px
/// of the refined truth, on the mean of eleven development scenes (docs/experiments.md), within .08 at every ratio.
double InlierProbabilityOfRatio(double ratio);

/// The same of a matcher's score, for matchers whose score is about that probability (LightGlue); no match is sure.
double InlierProbabilityOfScore(double score);

/// N such probabilities of a problem's matches, by their ratios or scores; empty where they have neither.
Eigen::VectorXd MatchPriors(const Problem& problem);

}  // namespace diffsac
