#include "diffsac/problem/point_features.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "diffsac/core/status.h"
#include "diffsac/problem/coordinates.h"
#include "diffsac/problem/neighborhood_features.h"
#include "diffsac/problem/residual_features.h"
#include "diffsac/problem/similarity_features.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/ransac/samplers/make_minimal_sampler.h"

namespace diffsac {
namespace {

using FeatureMatrix = decltype(FeatureSet::values);

// Mean and spread of matching ratios over all mutual matches of real pairs (docs/generators.md).
constexpr double kRatioMean = 0.7, kRatioSpread = 0.25;

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

// Which columns the kinds ask for, in their fixed order.
struct Columns {
  bool coordinates, ratio, neighborhood, descriptors, similarity, residual;
};

Columns ColumnsOf(const PointFeaturesOptions& options) {
  const bool ratio = options.Has(PointFeature::kRatio), descriptors = options.Has(PointFeature::kDescriptors);
  return {options.Has(PointFeature::kCoordinates) || ratio || descriptors,
          ratio,
          options.Has(PointFeature::kNeighborhood),
          descriptors,
          options.Has(PointFeature::kSimilarity),
          options.Has(PointFeature::kResidual)};
}

}  // namespace

bool PointFeaturesOptions::Has(PointFeature kind) const {
  return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

PointFeatures::PointFeatures(PointFeaturesOptions options, Task task) : options_(std::move(options)), task_(task) {
  const Columns columns = ColumnsOf(options_);
  if (!IsTwoView(task) && (columns.ratio || columns.neighborhood || columns.descriptors || columns.similarity))
    throw Error(
        "features: coordinates_ratio, neighborhood, coordinates_descriptors and similarity are for two views, not for "
        "task " +
        ToString(task));
  if (!IsTwoView(task) && !options_.use_calibration)
    throw Error("features: use_calibration is for two views, not for task " + ToString(task));
}

int PointFeatures::width() const {
  const Columns columns = ColumnsOf(options_);
  return (columns.coordinates ? PointDimension(task_) : 0) + (columns.ratio ? 1 : 0) +
         (columns.neighborhood ? kNeighborhoodColumns : 0) + (columns.descriptors ? 2 * options_.descriptor_size : 0) +
         (columns.similarity ? kSimilarityColumns : 0) +
         (columns.residual ? kColumnsPerHypothesis * options_.residual_kept : 0);
}

int PointFeatures::first_descriptor() const {
  const Columns columns = ColumnsOf(options_);
  if (!columns.descriptors) return -1;
  return PointDimension(task_) + (columns.ratio ? 1 : 0) + (columns.neighborhood ? kNeighborhoodColumns : 0);
}

int PointFeatures::first_neighborhood() const {
  const Columns columns = ColumnsOf(options_);
  if (!columns.neighborhood) return -1;
  return (columns.coordinates ? PointDimension(task_) : 0) + (columns.ratio ? 1 : 0);
}

int PointFeatures::first_residual() const {
  return options_.Has(PointFeature::kResidual) ? width() - kColumnsPerHypothesis * options_.residual_kept : -1;
}

FeatureSet PointFeatures::Compute(const NormalizedProblem& space, Rng rng) const {
  const Problem& problem = space.problem();
  std::vector<int> sets;
  if (ColumnsOf(options_).residual && problem.points.rows() >= MinimalSetSize(task_)) {
    MinimalSamplerOptions draws;
    if (options_.residual_from == ResidualDraws::kNapsac) draws.sampler = MinimalSamplerKind::kNapsac;
    const auto sampler = MakeMinimalSampler(draws, space.points(), MinimalSetSize(task_), rng.Fork("preference"));
    sets = DrawSets(*sampler, MinimalSetSize(task_), options_.residual_draws);
  }
  return ComputeFromSets(space, sets);
}

FeatureSet PointFeatures::ComputeFromSets(const NormalizedProblem& space, const std::vector<int>& sets) const {
  const Problem& problem = space.problem();
  const Columns columns = ColumnsOf(options_);
  FeatureSet features;
  features.values.resize(problem.points.rows(), width());
  if (problem.points.rows() == 0) return features;
  int column = 0;
  PointMatrix coordinates;
  if (columns.coordinates || columns.neighborhood || columns.similarity)
    coordinates =
        options_.use_calibration
            ? DispatchDescription(task_, [&]<class Description>() { return Description::FeatureCoordinates(space); })
            : MatchCoordinates(problem, false);
  if (columns.coordinates) {
    features.values.leftCols(coordinates.cols()) = coordinates.cast<float>();
    column += PointDimension(task_);
  }
  if (columns.ratio) {
    const bool known = !problem.scored && problem.snn_ratio.size() == problem.points.rows();
    features.values.col(column).setZero();
    if (known) features.values.col(column) = ((problem.snn_ratio.array() - kRatioMean) / kRatioSpread).cast<float>();
    ++column;
  }
  GoodNeighbors around;
  if (columns.neighborhood || columns.similarity) around = FindGoodNeighbors(coordinates, problem.snn_ratio);
  if (columns.neighborhood) {
    features.values.middleCols(column, kNeighborhoodColumns) = NeighborhoodFeatures(coordinates, around);
    column += kNeighborhoodColumns;
  }
  if (columns.descriptors) {
    if (!options_.descriptors_required && problem.descriptors.size() == 0)
      features.values.middleCols(column, 2 * options_.descriptor_size).setZero();
    else
      WriteDescriptors(problem, options_.descriptor_size, column, &features.values);
    column += 2 * options_.descriptor_size;
  }
  if (columns.similarity) {
    features.values.middleCols(column, kSimilarityColumns) = SimilarityFeatures(
        coordinates, InCoordinates(problem.scale_rotation_changes, problem.points, coordinates), around);
    column += kSimilarityColumns;
  }
  if (columns.residual) AddResidual(space, sets, {options_.residual_kept, options_.residual_choice}, column, &features);
  return features;
}

}  // namespace diffsac
