#include "diffsac/problem/match_probabilities.h"

#include <cmath>

namespace diffsac {

double InlierProbabilityOfRatio(double ratio) { return 0.05 + 0.9 / (1.0 + std::exp((ratio - 0.79) / 0.06)); }

double InlierProbabilityOfScore(double score) { return 0.05 + 0.9 * score; }

Eigen::VectorXd MatchPriors(const Problem& problem) {
  if (problem.snn_ratio.size() != problem.points.rows()) return {};
  if (problem.scored) return (1.0 - problem.snn_ratio.array()).unaryExpr(&InlierProbabilityOfScore);
  return problem.snn_ratio.unaryExpr(&InlierProbabilityOfRatio);
}

}  // namespace diffsac
