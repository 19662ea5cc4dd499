#include "diffsac/data/point_features.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "diffsac/consensus/hypothesis_source.h"
#include "diffsac/core/status.h"
#include "diffsac/data/neighborhood_features.h"
#include "diffsac/data/task_dispatch.h"
#include "diffsac/geometry/hyperplane.h"
#include "diffsac/geometry/pose.h"

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
// Two views: a residual beyond so many ε, or none at all (a point sent to infinity), counts as this many.
constexpr double kFarthest = 1e6;
// An image's focal length over its longer side, where the calibration is unknown.
constexpr double kUsualFocal = 1.2;
// Mean and spread of matching ratios over all mutual matches of real pairs (docs/generators.md).
constexpr double kRatioMean = 0.7, kRatioSpread = 0.25;

double Median(std::vector<double> values) {
  const std::size_t middle = values.size() / 2;
  std::nth_element(values.begin(), values.begin() + middle, values.end());
  if (values.size() % 2 == 1) return values[middle];
  return 0.5 * (values[middle] + *std::max_element(values.begin(), values.begin() + middle));
}

// Centred on the coordinate-wise median, divided by the median distance from it (the mean distance where more than half
// of the points are equal).
PointMatrix CentredCoordinates(const PointMatrix& points) {
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

void CentreImage(const ImageSize& size, int first, PointMatrix* points) {
  const double unit = kUsualFocal * std::max(size.width, size.height);
  points->col(first).array() = (points->col(first).array() - 0.5 * size.width) / unit;
  points->col(first + 1).array() = (points->col(first + 1).array() - 0.5 * size.height) / unit;
}

PointMatrix TwoViewCoordinates(const Problem& problem) {
  if (problem.cameras) return NormalizedCoordinates(problem.points, problem.cameras->K1, problem.cameras->K2);
  PointMatrix points = problem.points;
  if (problem.size1.known() && problem.size2.known()) {
    CentreImage(problem.size1, 0, &points);
    CentreImage(problem.size2, 2, &points);
  } else {
    points.leftCols(2) = CentredCoordinates(problem.points.leftCols(2));
    points.rightCols(2) = CentredCoordinates(problem.points.rightCols(2));
  }
  return points;
}

// Each image's descriptor with unit root mean square; one of zeros stays.
void WriteDescriptors(const Problem& problem, int size, int first, FeatureMatrix* values) {
  if (problem.descriptors.rows() != problem.points.rows() || problem.descriptors.cols() != 2 * size)
    throw Error("features: coordinates_descriptors needs " + std::to_string(2 * size) +
                " descriptor values a match, the data has " + std::to_string(problem.descriptors.cols()) +
                (problem.descriptors.size() == 0 ? " (descriptors.h5, read with 'descriptors: true')" : ""));
  for (Eigen::Index i = 0; i < problem.points.rows(); ++i)
    for (int image = 0; image < 2; ++image) {
      const auto descriptor = problem.descriptors.row(i).segment(image * size, size);
      const float norm = descriptor.norm();
      const float scale = norm > 0.0f ? std::sqrt(static_cast<float>(size)) / norm : 0.0f;
      values->row(i).segment(first + image * size, size) = scale * descriptor;
    }
}

// What a model is solved and scored on: pixels, but normalised coordinates for the essential matrix.
struct SolverView {
  PointMatrix points;
  double threshold;
};

SolverView ViewOf(const Problem& problem) {
  if (problem.task != Task::kEssential || !problem.cameras) return {problem.points, problem.inlier_threshold};
  return {NormalizedCoordinates(problem.points, problem.cameras->K1, problem.cameras->K2),
          problem.inlier_threshold / problem.cameras->MeanFocal()};
}

// Hypotheses as they come out of the solver.
struct Pool {
  std::vector<int> sets;   // γ indices each; a set with several solutions stands here as often
  Eigen::MatrixXd models;  // parameters × H, one a column
  Eigen::ArrayXd scores;   // H
  int count = 0;
};

template <class Model>
Pool SolveSets(const PointMatrix& points, const std::vector<int>& sets) {
  constexpr int kSize = Model::kMinimalSize;
  const auto drawn = static_cast<int>(sets.size()) / kSize;
  Pool pool;
  pool.models.resize(Model::Parameters::SizeAtCompileTime, drawn * Model::kMaxSolutions);
  pool.sets.reserve(sets.size());
  typename Model::Parameters models[Model::kMaxSolutions];
  for (int i = 0; i < drawn; ++i) {
    const int* set = sets.data() + i * kSize;
    const int solutions = Model::SolveMinimal(points, set, models);
    for (int k = 0; k < solutions; ++k) {
      pool.models.col(pool.count++) = models[k];
      pool.sets.insert(pool.sets.end(), set, set + kSize);
    }
  }
  return pool;
}

// Residuals of all points to one model; `axes` holds a coordinate a column.
template <class Model>
auto Residuals(const Eigen::ArrayXXd& axes, const double* model, [[maybe_unused]] double threshold) {
  if constexpr (Model::kDimension == 2) {
    return (axes.col(0) * model[0] + axes.col(1) * model[1] + model[2]).abs();
  } else if constexpr (Model::kDimension == 3) {
    return (axes.col(0) * model[0] + axes.col(1) * model[1] + axes.col(2) * model[2] + model[3]).abs();
  } else {
    const double* columns[4];
    for (int k = 0; k < 4; ++k) columns[k] = axes.col(k).data();
    Eigen::ArrayXd residuals(axes.rows());
    Model::Residuals(Eigen::Map<const Matrix3Parameters>(model), columns, 0, static_cast<int>(axes.rows()),
                     residuals.data());
    const double farthest = kFarthest * threshold;
    for (double& r : residuals) r = r < farthest ? r : farthest;  // a NaN too
    return residuals;
  }
}

template <class Model>
void ScoreByMsac(const Eigen::ArrayXXd& axes, double threshold, Pool* pool) {
  const double inverse = 1.0 / (threshold * threshold);
  pool->scores.resize(pool->count);
  for (int h = 0; h < pool->count; ++h)
    pool->scores[h] =
        (1.0 - Residuals<Model>(axes, pool->models.col(h).data(), threshold).square() * inverse).max(0.0).sum();
}

// The best `kept` hypotheses with distinct sets, by score, then by order of drawing.
std::vector<int> BestDistinct(const Pool& pool, int set_size, int kept) {
  std::vector<int> order(pool.count);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return pool.scores[a] != pool.scores[b] ? pool.scores[a] > pool.scores[b] : a < b; });
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
template <class Model>
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
    scaled.head(count) =
        (Residuals<Model>(axes, pool.models.col(h).data(), threshold) / threshold).template cast<float>();
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
  const SolverView view = ViewOf(problem);
  const Eigen::ArrayXXd axes = view.points.array();  // column-major: a coordinate is contiguous
  Pool pool = SolveSets<Model>(view.points, sets);
  ScoreByMsac<Model>(axes, kScoreThresholdFactor * view.threshold, &pool);
  const std::vector<int> best = BestDistinct(pool, Model::kMinimalSize, kept);
  WriteColumns<Model>(axes, view.threshold, pool, best, kept, first, &features->values);
  features->hypotheses = pool.count;
  for (int h : best) {
    features->models.emplace_back(pool.models.col(h));
    features->scores.push_back(pool.scores[h]);
  }
}

bool Contains(const std::vector<std::string>& kinds, const char* kind) {
  return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

// Which columns the kinds ask for, in their fixed order.
struct Columns {
  bool coordinates, ratio, neighborhood, descriptors, preference;
};

Columns ColumnsOf(const PointFeaturesOptions& options) {
  const auto& kinds = options.kinds;
  const bool ratio = Contains(kinds, "coordinates_ratio"), descriptors = Contains(kinds, "coordinates_descriptors");
  return {Contains(kinds, "coordinates") || ratio || descriptors, ratio, Contains(kinds, "neighborhood"), descriptors,
          Contains(kinds, "preference")};
}

}  // namespace

void PointFeaturesOptions::Bind(OptionsBinder& b) {
  b.Choices("kinds", kinds,
            {"coordinates", "coordinates_ratio", "neighborhood", "coordinates_descriptors", "preference"})
      .Help("their columns stand side by side in this order, those of the coordinates once; ratios, neighborhoods and "
            "descriptors are for two views");
  b.Field("descriptor_size", descriptor_size, Within(1, 4096))
      .Help("`coordinates_descriptors`: values of one descriptor (128 for SIFT: the paper's 260 columns)");
  b.Field("descriptors_required", descriptors_required)
      .Help("`coordinates_descriptors`: a problem without descriptors is an error; else its columns are 0");
  b.Field("preference_draws", preference_draws, AtLeast(1)).Help("`preference`: minimal sets that are drawn");
  b.Field("preference_kept", preference_kept, AtLeast(1))
      .Help("`preference`: how many of the best-scored are kept as columns");
  b.Require(!kinds.empty(), "kinds",
            "at least one of coordinates, coordinates_ratio, neighborhood, coordinates_descriptors, preference");
}

PointFeatures::PointFeatures(PointFeaturesOptions options, Task task) : options_(std::move(options)), task_(task) {
  const Columns columns = ColumnsOf(options_);
  if (!IsTwoView(task) && (columns.ratio || columns.neighborhood || columns.descriptors))
    throw Error(
        "features: coordinates_ratio, neighborhood and coordinates_descriptors are for two views, not for task " +
        ToString(task));
}

int PointFeatures::width() const {
  const Columns columns = ColumnsOf(options_);
  return (columns.coordinates ? PointDimension(task_) : 0) + (columns.ratio ? 1 : 0) +
         (columns.neighborhood ? kNeighborhoodColumns : 0) + (columns.descriptors ? 2 * options_.descriptor_size : 0) +
         (columns.preference ? kColumnsPerHypothesis * options_.preference_kept : 0);
}

int PointFeatures::first_descriptor() const {
  const Columns columns = ColumnsOf(options_);
  if (!columns.descriptors) return -1;
  return PointDimension(task_) + (columns.ratio ? 1 : 0) + (columns.neighborhood ? kNeighborhoodColumns : 0);
}

FeatureSet PointFeatures::Compute(const Problem& problem, Rng rng) const {
  std::vector<int> sets;
  if (ColumnsOf(options_).preference && problem.points.rows() >= MinimalSetSize(task_)) {
    const auto count = static_cast<int>(problem.points.rows());
    UniformSource source(count, MinimalSetSize(task_), rng.Fork("preference"));
    sets = DrawSets(source, MinimalSetSize(task_), options_.preference_draws);
  }
  return ComputeFromSets(problem, sets);
}

FeatureSet PointFeatures::ComputeFromSets(const Problem& problem, const std::vector<int>& sets) const {
  const Columns columns = ColumnsOf(options_);
  FeatureSet features;
  features.values.resize(problem.points.rows(), width());
  if (problem.points.rows() == 0) return features;
  int column = 0;
  if (columns.coordinates) {
    const PointMatrix points = IsTwoView(task_) ? TwoViewCoordinates(problem) : CentredCoordinates(problem.points);
    features.values.leftCols(points.cols()) = points.cast<float>();
    column += PointDimension(task_);
  }
  if (columns.ratio) {
    const bool known = problem.quality.size() == problem.points.rows();
    features.values.col(column).setZero();
    if (known) features.values.col(column) = ((problem.quality.array() - kRatioMean) / kRatioSpread).cast<float>();
    ++column;
  }
  if (columns.neighborhood) {
    features.values.middleCols(column, kNeighborhoodColumns) =
        NeighborhoodFeatures(TwoViewCoordinates(problem), problem.quality);
    column += kNeighborhoodColumns;
  }
  if (columns.descriptors) {
    if (!options_.descriptors_required && problem.descriptors.size() == 0)
      features.values.middleCols(column, 2 * options_.descriptor_size).setZero();
    else
      WriteDescriptors(problem, options_.descriptor_size, column, &features.values);
    column += 2 * options_.descriptor_size;
  }
  if (columns.preference)
    DispatchTask(task_, [&]<MinimalModel Model>() {
      AddPreference<Model>(problem, sets, options_.preference_kept, column, &features);
    });
  return features;
}

}  // namespace diffsac
