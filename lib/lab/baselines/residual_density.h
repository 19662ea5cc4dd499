#pragma once

#include <Eigen/Core>
#include <vector>

namespace diffsac {

/// The kernel residual density δ of one hypothesis over all points (Tiwari and Anand, "DGSAC: Density guided sampling
/// and consensus", WACV 2018), in 1 / unit of the residual: docs/dgsac.md, with how the paper is read.
struct ResidualDensity {
  std::vector<int> order;     ///< points by ascending residual, by index where equal
  Eigen::VectorXd residuals;  ///< ascending, as they are; one that is not finite counts as the largest that is
  Eigen::VectorXd density;    ///< δ by rank; even up to the peak; empty when no residual is finite
  /// δ of each point.
  Eigen::VectorXd AtPoints() const;
};

/// The rank from which densities are looked at: γ points and at least γ + 1 or 5 % of all points more, at most n.
int FirstDensityRank(int num_points, int minimal_size);

/// minimal_size: γ < n. Residuals are unsigned.
ResidualDensity ComputeResidualDensity(const Eigen::VectorXd& residuals, int minimal_size);

/// Where the inliers of a hypothesis end, found from its residuals alone.
struct InlierExtent {
  int count = 0;          ///< points within `residual`: the first in order
  double residual = 0.0;  ///< the largest residual of an inlier
  /// How many times denser residuals lie within `residual` than in the shell behind it (one more point counted there,
  /// so that an empty shell gives a number).
  double contrast = 0.0;
  /// Log-likelihood ratio, in nats, of two densities against one for the points within twice `residual`.
  double evidence = 0.0;
};

/// The rank k with the greatest evidence that residuals within s = r_k are denser than those in the shell (s, e]
/// behind, e = min(2 s, r_n), of equal ranks the last (docs/dgsac.md). Outliers thin out towards the ends of the data
/// as well, and there are more of them, so the search goes outward and ends at twice the extent of a clear drop.
/// `count` is 0 when no rank is denser than its shell.
InlierExtent EstimateInlierExtent(const ResidualDensity& density, int minimal_size);

/// What is kept of a hypothesis for the selection of models.
struct DensityHypothesis {
  std::vector<int> order;  ///< the points by ascending residual
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
std::vector<int> SelectInstances(const std::vector<DensityHypothesis>& hypotheses, double min_contrast,
                                 double same_instance);

}  // namespace diffsac
