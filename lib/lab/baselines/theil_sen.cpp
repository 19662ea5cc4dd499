#include <algorithm>
#include <array>
#include <cmath>

#include "diffsac/estimate/robust_estimator.h"
#include "diffsac/estimate/task_dispatch.h"
#include "lab/config/estimator_registry.h"
#include "lab/options/options.h"

namespace diffsac {
namespace {

struct TheilSenOptions {
  int max_iterations = 20000;
  void Bind(OptionsBinder& b) {
    b.Field("max_iterations", max_iterations, Within(1, 1e7))
        .Help("most minimal sets to solve: all, where there are no more than this, else this many random ones");
  }
};

/// The middle value, or the mean of the two middle values. `values` is reordered and must not be empty.
double Median(std::vector<double>* values) {
  const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  if (values->size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values->begin(), middle));
}

std::vector<int> DrawSets(int num_points, int set_size, int budget, std::uint64_t seed) {
  return DrawAllOrSome(num_points, set_size, budget, Rng(seed).Fork("theil_sen"));
}

/// The slopes of a model, −n_i / n_D; false when it is parallel to the last axis.
template <int D>
bool Slopes(const typename Hyperplane<D>::Parameters& model, std::array<double, D - 1>* slopes) {
  constexpr double kParallel = 1e-12;
  const double last = model[D - 1];
  if (std::abs(last) <= kParallel) return false;
  for (int i = 0; i < D - 1; ++i) (*slopes)[i] = -model[i] / last;
  return true;
}

/// The hyperplane of given slopes whose intercept is the median one.
template <int D>
typename Hyperplane<D>::Parameters FromSlopes(const PointMatrix& points, const std::array<double, D - 1>& slopes) {
  std::vector<double> intercepts(points.rows());
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    intercepts[i] = points(i, D - 1);
    for (int j = 0; j < D - 1; ++j) intercepts[i] -= slopes[j] * points(i, j);
  }
  typename Hyperplane<D>::Parameters model;
  for (int j = 0; j < D - 1; ++j) model[j] = slopes[j];
  model[D - 1] = -1.0;
  model[D] = Median(&intercepts);
  return model / model.template head<D>().norm();
}

template <int D>
Estimate EstimateHyperplane(const NormalizedProblem& space, int budget, std::uint64_t seed) {
  using Model = Hyperplane<D>;
  Estimate estimate;
  const std::vector<int> sets = DrawSets(static_cast<int>(space.points().rows()), D, budget, seed);
  std::array<std::vector<double>, D - 1> samples;
  typename Model::Parameters solved;
  std::array<double, D - 1> slopes;
  for (std::size_t start = 0; start < sets.size(); start += D) {
    if (Model::SolveMinimal(space.points(), sets.data() + start, &solved) == 0 || !Slopes<D>(solved, &slopes)) continue;
    for (int i = 0; i < D - 1; ++i) samples[i].push_back(slopes[i]);
  }
  estimate.stats.hypotheses = static_cast<int>(sets.size() / D);
  estimate.stats.unique_minimal_sets = CountUniqueSets(sets, D);
  if (samples[0].empty()) return estimate;
  for (int i = 0; i < D - 1; ++i) slopes[i] = Median(&samples[i]);
  const typename Model::Parameters model = FromSlopes<D>(space.points(), slopes);
  if (!model.allFinite()) return estimate;
  AcceptModel<Model>(space, model, &estimate);
  return estimate;
}

/// Theil–Sen. Lines: the median slope of all pairs and the median of y − slope·x (Theil 1950; Sen, JASA 1968). Planes:
/// z = a x + b y + c with the coordinate-wise medians of (a, b) over triplets and the median of z − a x − b y, the
/// coordinate-wise form of multivariate Theil–Sen (Dang, Peng, Wang, Zhang, "Theil–Sen estimators in a multiple linear
/// regression model", 2008).
///
/// Not invariant to rotation: errors are taken along the last axis, sets that are parallel to it are left out, and the
/// breakdown point is 29 % for lines. It is here because the paper's tables have it as a row.
/// kNoModel when every set is parallel to the last axis. The score is the inlier count.
class TheilSenEstimator : public RobustEstimator {
 public:
  explicit TheilSenEstimator(const TheilSenOptions& options) : options_(options) { CheckOptions(options); }
  Estimate DoRun(const NormalizedProblem& given, std::uint64_t seed) const override {
    return TimedEstimate(given, [&]<MinimalModel Model>(const NormalizedProblem& space) {
      if constexpr (HyperplaneModel<Model>)
        return EstimateHyperplane<Model::kDimension>(space, options_.max_iterations, seed);
      return Estimate{};
    });
  }

 private:
  TheilSenOptions options_;
};

const RegisteredEstimator<TheilSenOptions> kTheilSen(
    "theil_sen", "Lines and planes: coordinate-wise medians of the minimal sets' models.",
    [](Task task) {
      const bool suits = DispatchTask(task, []<class Model>() { return HyperplaneModel<Model>; });
      if (!suits) throw Error("theil_sen estimates lines and planes only");
      return TheilSenOptions();
    },
    [](const TheilSenOptions& options) { return std::make_unique<TheilSenEstimator>(options); });

}  // namespace
}  // namespace diffsac
