#include "diffsac/data/point_features.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "diffsac/consensus/hypothesis_source.h"
#include "diffsac/geometry/hyperplane.h"

namespace diffsac {
namespace {

using FeatureMatrix = decltype(FeatureSet::values);

// MSAC ranks hypotheses best at 1.5 ε (field measurements: docs/generators.md).
constexpr double kScoreThresholdFactor = 1.5;
// Soft agreement falls off with this multiple of ε.
constexpr float kAgreementSigma = 0.5f;
// log1p(r/ε) reaches about 4.9 across the synthetic picture; this brings it to about unit range.
constexpr float kDistanceScale = 0.25f;
constexpr int kColumnsPerHypothesis = 3;

double Median(std::vector<double> values) {
  const std::size_t middle = values.size() / 2;
  std::nth_element(values.begin(), values.begin() + middle, values.end());
  if (values.size() % 2 == 1) return values[middle];
  return 0.5 * (values[middle] + *std::max_element(values.begin(), values.begin() + middle));
}

// Centred on the coordinate-wise median, divided by the median distance from it (the mean distance where more than half
// of the points are equal).
PointMatrix NormalizedCoordinates(const PointMatrix& points) {
  PointMatrix centred = points;
  for (Eigen::Index k = 0; k < points.cols(); ++k) {
    const Eigen::VectorXd column = points.col(k);
    centred.col(k).array() -= Median({column.data(), column.data() + column.size()});
  }
  const Eigen::VectorXd distances = centred.rowwise().norm();
  double scale = Median({distances.data(), distances.data() + distances.size()});
  if (!(scale > 0.0)) scale = distances.mean();
  return scale > 0.0 ? PointMatrix(centred / scale) : centred;
}

// Hypotheses as they come out of the solver.
struct Pool {
  std::vector<int> sets;                              // γ indices each
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic> models;  // (D + 1) × H, one a column
  Eigen::ArrayXd scores;                              // H
  int count = 0;
};

template <class Model>
Pool SolveSets(const PointMatrix& points, const std::vector<int>& sets) {
  constexpr int kSize = Model::kMinimalSize;
  const auto drawn = static_cast<int>(sets.size()) / kSize;
  Pool pool;
  pool.models.resize(Model::kDimension + 1, drawn);
  pool.sets.reserve(sets.size());
  typename Model::Parameters model;
  for (int i = 0; i < drawn; ++i) {
    const int* set = sets.data() + i * kSize;
    if (Model::SolveMinimal(points, set, &model) == 0) continue;
    pool.models.col(pool.count++) = model;
    pool.sets.insert(pool.sets.end(), set, set + kSize);
  }
  return pool;
}

// |n · x + d| of all points to one model; `axes` holds a coordinate a column.
template <int D>
auto Residuals(const Eigen::ArrayXXd& axes, const double* model) {
  if constexpr (D == 2) {
    return (axes.col(0) * model[0] + axes.col(1) * model[1] + model[2]).abs();
  } else {
    return (axes.col(0) * model[0] + axes.col(1) * model[1] + axes.col(2) * model[2] + model[3]).abs();
  }
}

template <int D>
void ScoreByMsac(const Eigen::ArrayXXd& axes, double threshold, Pool* pool) {
  const double inverse = 1.0 / (threshold * threshold);
  pool->scores.resize(pool->count);
  for (int h = 0; h < pool->count; ++h)
    pool->scores[h] = (1.0 - Residuals<D>(axes, pool->models.col(h).data()).square() * inverse).max(0.0).sum();
}

// The best `kept` hypotheses with distinct sets, by score, then by order of drawing.
std::vector<int> BestDistinct(const Pool& pool, int set_size, int kept) {
  std::vector<int> order(pool.count);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return pool.scores[a] != pool.scores[b] ? pool.scores[a] > pool.scores[b] : a < b;
  });
  const auto same_set = [&](int a, int b) {
    const int* first = pool.sets.data() + a * set_size;
    return std::equal(first, first + set_size, pool.sets.data() + b * set_size);
  };
  std::vector<int> best;
  for (int candidate : order) {
    if (static_cast<int>(best.size()) == kept) break;
    if (std::none_of(best.begin(), best.end(), [&](int other) { return same_set(candidate, other); }))
      best.push_back(candidate);
  }
  return best;
}

// Writes the three columns of each kept hypothesis, from column `first` on.
template <int D>
void WriteColumns(const Eigen::ArrayXXd& axes, double threshold, const Pool& pool, const std::vector<int>& best,
                  int kept, int first, FeatureMatrix* values) {
  if (best.empty()) {
    values->middleCols(first, kColumnsPerHypothesis * kept).setZero();
    return;
  }
  // Whole SIMD packets only: a value must not depend on where in the array its point stands.
  const Eigen::Index count = axes.rows(), padded = (count + 15) / 16 * 16;
  Eigen::ArrayXf scaled = Eigen::ArrayXf::Zero(padded);
  Eigen::ArrayXf agreement(padded), distance(padded);
  for (int j = 0; j < kept; ++j) {
    const int h = best[j < static_cast<int>(best.size()) ? j : 0];
    scaled.head(count) = (Residuals<D>(axes, pool.models.col(h).data()) / threshold).template cast<float>();
    agreement = (scaled.square() * (-0.5f / (kAgreementSigma * kAgreementSigma))).exp();
    distance = (scaled + 1.0f).log() * kDistanceScale;
    const int column = first + kColumnsPerHypothesis * j;
    values->col(column) = agreement.head(count);
    values->col(column + 1) = distance.head(count);
    values->col(column + 2).setConstant(static_cast<float>(pool.scores[h] / static_cast<double>(count)));
  }
}

template <class Model>
void AddPreference(const Problem& problem, const std::vector<int>& sets, int kept, int first, FeatureSet* features) {
  constexpr int kDimension = Model::kDimension;
  const Eigen::ArrayXXd axes = problem.points.array();  // column-major: a coordinate is contiguous
  Pool pool = SolveSets<Model>(problem.points, sets);
  ScoreByMsac<kDimension>(axes, kScoreThresholdFactor * problem.inlier_threshold, &pool);
  const std::vector<int> best = BestDistinct(pool, Model::kMinimalSize, kept);
  WriteColumns<kDimension>(axes, problem.inlier_threshold, pool, best, kept, first, &features->values);
  features->hypotheses = pool.count;
  for (int h : best) {
    features->models.emplace_back(pool.models.col(h));
    features->scores.push_back(pool.scores[h]);
  }
}

bool Contains(const std::vector<std::string>& kinds, const char* kind) {
  return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

}  // namespace

void PointFeaturesOptions::Bind(OptionsBinder& b) {
  b.Choices("kinds", kinds, {"coordinates", "preference"});
  b.Field("preference_draws", preference_draws, AtLeast(1));
  b.Field("preference_kept", preference_kept, AtLeast(1));
  b.Require(!kinds.empty(), "kinds", "at least one of coordinates, preference");
}

PointFeatures::PointFeatures(PointFeaturesOptions options, Task task) : options_(std::move(options)), task_(task) {
  if (IsTwoView(task)) throw Error("features: a network sees lines and planes, not task " + ToString(task));
}

int PointFeatures::width() const {
  int width = 0;
  if (Contains(options_.kinds, "coordinates")) width += PointDimension(task_);
  if (Contains(options_.kinds, "preference")) width += kColumnsPerHypothesis * options_.preference_kept;
  return width;
}

FeatureSet PointFeatures::Compute(const Problem& problem, Rng rng) const {
  std::vector<int> sets;
  if (Contains(options_.kinds, "preference") && problem.points.rows() >= MinimalSetSize(task_)) {
    const auto count = static_cast<int>(problem.points.rows());
    UniformSource().Draw(count, MinimalSetSize(task_), options_.preference_draws, rng.Fork("preference"), &sets);
  }
  return ComputeFromSets(problem, sets);
}

FeatureSet PointFeatures::ComputeFromSets(const Problem& problem, const std::vector<int>& sets) const {
  FeatureSet features;
  features.values.resize(problem.points.rows(), width());
  int column = 0;
  // The columns stand in a fixed order, whatever the order in the options.
  if (Contains(options_.kinds, "coordinates") && problem.points.rows() > 0) {
    features.values.leftCols(PointDimension(task_)) = NormalizedCoordinates(problem.points).cast<float>();
    column += PointDimension(task_);
  }
  if (!Contains(options_.kinds, "preference") || problem.points.rows() == 0) return features;
  if (task_ == Task::kLine) {
    AddPreference<Line>(problem, sets, options_.preference_kept, column, &features);
  } else {
    AddPreference<Plane>(problem, sets, options_.preference_kept, column, &features);
  }
  return features;
}

}  // namespace diffsac
