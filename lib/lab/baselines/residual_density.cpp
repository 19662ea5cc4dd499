#include "lab/baselines/residual_density.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

namespace diffsac {
namespace {

constexpr double kSmoothingShare = 1.0 / 40.0;
constexpr double kFirstShare = 0.05;
constexpr double kClearContrast = 3.0;

/// Residuals that are not numbers become the largest that is one; false when there is none.
bool ReplaceNonFinite(Eigen::VectorXd* residuals) {
  double largest = -1.0;
  for (const double value : *residuals)
    if (std::isfinite(value)) largest = std::max(largest, value);
  if (largest < 0.0) return false;
  for (double& value : *residuals)
    if (!std::isfinite(value)) value = largest;
  return true;
}

/// The mean over `half` ranks to either side, of those there are. Of ascending values it is ascending.
Eigen::VectorXd Smoothed(const Eigen::VectorXd& ascending, int half) {
  const int size = static_cast<int>(ascending.size());
  // Sums of the first k values: a window costs the same whatever its width, which grows with the number of points. They
  // hold the sum of any doubles.
  std::vector<long double> sums(size + 1, 0.0L);
  for (int k = 0; k < size; ++k) sums[k + 1] = sums[k] + ascending[k];
  Eigen::VectorXd smooth(size);
  for (int k = 0; k < size; ++k) {
    const int reach = std::min({half, k, size - 1 - k});
    smooth[k] = static_cast<double>((sums[k + reach + 1] - sums[k - reach]) / (2 * reach + 1));
    if (k > 0) smooth[k] = std::max(smooth[k], smooth[k - 1]);  // Rounding alone could make it less.
  }
  return smooth;
}

/// n ln(n / (total · share)), 0 for n = 0: how much likelier `count` is than its share of `total`.
double PartEvidence(double count, double total, double share) {
  return count > 0.0 ? count * std::log(count / (total * share)) : 0.0;
}

/// Trapezoids under δ over the first `count` residuals.
double Area(const ResidualDensity& density, int count) {
  double area = 0.0;
  for (int k = 1; k < count; ++k)
    area += 0.5 * (density.density[k - 1] + density.density[k]) * (density.residuals[k] - density.residuals[k - 1]);
  return area;
}

double SeedGoodness(const DensityHypothesis& hypothesis) {
  return hypothesis.area_share / std::max(hypothesis.mean_residual, std::numeric_limits<double>::min());
}

}  // namespace

Eigen::VectorXd ResidualDensity::AtPoints() const {
  Eigen::VectorXd values(density.size());
  for (Eigen::Index k = 0; k < density.size(); ++k) values[order[k]] = density[k];
  return values;
}

int FirstDensityRank(int num_points, int minimal_size) {
  const int share = static_cast<int>(std::ceil(kFirstShare * num_points));
  return std::min(num_points, minimal_size + std::max(minimal_size + 1, share));
}

ResidualDensity ComputeResidualDensity(const Eigen::VectorXd& residuals, int minimal_size) {
  ResidualDensity result;
  Eigen::VectorXd values = residuals;
  const int size = static_cast<int>(values.size());
  if (size <= minimal_size || !ReplaceNonFinite(&values)) return result;
  // Values and points side by side: sorting points by values elsewhere waits for memory.
  std::vector<std::pair<double, int>> ascending(size);
  for (int i = 0; i < size; ++i) ascending[i] = {values[i], i};
  std::sort(ascending.begin(), ascending.end());
  result.order.resize(size);
  result.residuals.resize(size);
  for (int k = 0; k < size; ++k) std::tie(result.residuals[k], result.order[k]) = ascending[k];

  const int window = static_cast<int>(std::ceil(kSmoothingShare * size));
  const Eigen::VectorXd smooth = Smoothed(result.residuals, window / 2);
  // Points exactly on the model would be infinitely dense; beyond this ratio to the largest residual they are alike.
  const double least = std::max(result.residuals[size - 1] * 1e-12, std::numeric_limits<double>::min());
  result.density.resize(size);
  const int first = FirstDensityRank(size, minimal_size);
  int peak = first - 1;
  for (int k = first - 1; k < size; ++k) {
    result.density[k] = (k + 1 - minimal_size) / (size * std::max(smooth[k], least));
    if (result.density[k] > result.density[peak]) peak = k;
  }
  result.density.head(peak).setConstant(result.density[peak]);
  return result;
}

InlierExtent EstimateInlierExtent(const ResidualDensity& density, int minimal_size) {
  InlierExtent best;
  const int size = static_cast<int>(density.density.size());
  if (size == 0) return best;
  const Eigen::VectorXd& residuals = density.residuals;
  const double largest = residuals[size - 1];
  bool is_clear = false;
  int shell_end = 0;
  for (int k = FirstDensityRank(size, minimal_size); k <= size; ++k) {
    const double extent = residuals[k - 1];
    if (is_clear && extent > 2.0 * best.residual) break;
    if (k < size && residuals[k] == extent) continue;
    while (shell_end < size && residuals[shell_end] <= 2.0 * extent) ++shell_end;
    const double inside = k - minimal_size, behind = shell_end - k;
    // Nothing lies behind the largest residual because the data end there, so the shell ends there too.
    const double share = extent > 0.0 ? extent / std::min(2.0 * extent, largest) : 0.5;
    if (share >= 1.0 || inside * (1.0 - share) <= behind * share) continue;
    const double total = inside + behind;
    const double evidence = PartEvidence(inside, total, share) + PartEvidence(behind, total, 1.0 - share);
    if (evidence < best.evidence) continue;
    best = {k, extent, inside * (1.0 - share) / ((behind + 1.0) * share), evidence};
    is_clear = best.contrast >= kClearContrast && evidence >= std::log(size);
  }
  return best;
}

double Goodness(const DensityHypothesis& hypothesis) { return hypothesis.median_density * hypothesis.inliers.contrast; }

DensityHypothesis DescribeHypothesis(const ResidualDensity& density, int minimal_size) {
  DensityHypothesis result;
  result.inliers = EstimateInlierExtent(density, minimal_size);
  result.order = density.order;
  const int count = result.inliers.count;
  if (count == 0) return result;
  const double area = Area(density, static_cast<int>(density.order.size()));
  Eigen::VectorXd densities = density.density.head(count);
  std::nth_element(densities.begin(), densities.begin() + count / 2, densities.end());
  result.median_density = densities[count / 2];
  result.area_share = area > 0.0 ? Area(density, count) / area : 1.0;
  result.mean_residual = density.residuals.head(count).mean();
  return result;
}

double TopListCorrelation(const std::vector<int>& first, const std::vector<int>& second, int count) {
  if (count < 1) return 0.0;
  std::vector<int> place(std::max(first.size(), second.size()), count);
  for (int k = 0; k < count; ++k) place[second[k]] = k;
  double footrule = 0.0;
  for (int k = 0; k < count; ++k) {
    footrule += std::abs(place[first[k]] - k);
    place[first[k]] = -1;
  }
  for (int k = 0; k < count; ++k)
    if (place[second[k]] >= 0) footrule += count - k;
  return 1.0 - footrule / (static_cast<double>(count) * (count + 1));
}

std::vector<int> SelectInstances(const std::vector<DensityHypothesis>& hypotheses, double min_contrast,
                                 double same_instance) {
  std::vector<int> left;
  for (int h = 0; h < static_cast<int>(hypotheses.size()); ++h)
    if (hypotheses[h].inliers.count > 0 && hypotheses[h].inliers.contrast >= min_contrast) left.push_back(h);
  std::stable_sort(left.begin(), left.end(),
                   [&](int a, int b) { return SeedGoodness(hypotheses[a]) > SeedGoodness(hypotheses[b]); });
  std::vector<int> selected;
  while (!left.empty()) {
    const DensityHypothesis& seed = hypotheses[left.front()];
    int best = left.front();
    std::vector<int> others;
    for (const int h : left) {
      const int count = std::min(seed.inliers.count, hypotheses[h].inliers.count);
      if (h != left.front() && TopListCorrelation(seed.order, hypotheses[h].order, count) < same_instance) {
        others.push_back(h);
      } else if (Goodness(hypotheses[h]) > Goodness(hypotheses[best])) {
        best = h;
      }
    }
    selected.push_back(best);
    left = std::move(others);
  }
  return selected;
}

}  // namespace diffsac
