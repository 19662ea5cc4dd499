#include "diffsac/consensus/samplers/density_selection.h"

#include <algorithm>
#include <cstdlib>
#include <limits>

namespace diffsac {
namespace {

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

double Goodness(const DensityHypothesis& hypothesis) { return hypothesis.median_density * hypothesis.inliers.contrast; }

DensityHypothesis DescribeHypothesis(const ResidualDensity& density, int minimal_size) {
  DensityHypothesis result;
  result.inliers = EstimateInlierExtent(density, minimal_size);
  result.order = density.order;
  const int count = result.inliers.count;
  if (count == 0) return result;
  const double area = Area(density, static_cast<int>(density.order.size()));
  result.share = density.AtPoints();
  if (area > 0.0) result.share /= area;
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

std::vector<int> SelectStructures(const std::vector<DensityHypothesis>& hypotheses, double min_contrast,
                                  double same_structure) {
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
      if (h != left.front() && TopListCorrelation(seed.order, hypotheses[h].order, count) < same_structure) {
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

std::vector<int> AssignPoints(const std::vector<DensityHypothesis>& hypotheses, const std::vector<int>& selected) {
  if (selected.empty()) return {};
  const std::size_t size = hypotheses[selected.front()].order.size();
  std::vector<int> owner(size, -1);
  std::vector<double> best(size, 0.0);
  for (std::size_t s = 0; s < selected.size(); ++s) {
    const DensityHypothesis& hypothesis = hypotheses[selected[s]];
    for (int k = 0; k < hypothesis.inliers.count; ++k) {
      const int point = hypothesis.order[k];
      if (owner[point] >= 0 && hypothesis.share[point] <= best[point]) continue;
      owner[point] = static_cast<int>(s);
      best[point] = hypothesis.share[point];
    }
  }
  return owner;
}

}  // namespace diffsac
