#pragma once

#include <Eigen/Core>
#include <vector>

#include "diffsac/consensus/scores/residual_density.h"

namespace diffsac {

/// What is kept of a hypothesis for the selection of models.
struct DensityHypothesis {
  std::vector<int> order;  ///< the points by ascending residual
  Eigen::VectorXd share;   ///< δ of each point over the area under δ (1 / unit of the residual)
  InlierExtent inliers;
  double median_density = 0.0;  ///< of δ over the inliers
  double area_share = 0.0;      ///< of the area under δ that lies within the inliers' extent, in [0, 1]
  double mean_residual = 0.0;   ///< of the inliers
};

DensityHypothesis DescribeHypothesis(const ResidualDensity& density, int minimal_size);

/// median_density · contrast: dense inliers, and a sharp end of them. 1 / unit of the residual.
double Goodness(const DensityHypothesis& hypothesis);

/// Agreement of two orders in their first `count` entries: 1 − F / (count (count + 1)), F Spearman's footrule of the
/// two top lists with every absent entry at place count + 1 (Fagin, Kumar and Sivakumar, "Comparing top k lists", SIAM
/// J. Discrete Math. 2003). 1 for equal lists, 0 for disjoint ones; `count` at most their length, 0 for count = 0.
double TopListCorrelation(const std::vector<int>& first, const std::vector<int>& second, int count);

/// One hypothesis for each structure, greedily (DGSAC's greedy selection): of those left, the one with the greatest
/// area_share / mean_residual opens a structure; with it go all that correlate with it, by TopListCorrelation over the
/// smaller number of inliers, by `same_structure` or more; of these the one with the greatest Goodness
/// stands for the structure. Hypotheses of a contrast below `min_contrast` are left out. Indices, first opened first.
std::vector<int> SelectStructures(const std::vector<DensityHypothesis>& hypotheses, double min_contrast,
                                  double same_structure);

/// The structure that each point belongs to: of the selected hypotheses that count it as an inlier, the one with the
/// greatest `share` of it, as an index into `selected`, the first where equal; −1 for an outlier of all.
std::vector<int> AssignPoints(const std::vector<DensityHypothesis>& hypotheses, const std::vector<int>& selected);

}  // namespace diffsac
