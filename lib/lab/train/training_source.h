#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/problem/point_features.h"
#include "diffsac/problem/problem.h"
#include "lab/ground_truth/labels.h"
#include "lab/options/options.h"
#include "lab/train/two_view_transform.h"

namespace diffsac {

/// The labels that each item of a training run gets.
struct ItemLabels : LabelOptions {
  int count = 0;  ///< Drawn anew each time; 0: none are searched for.
};

/// The random numbers of an item: what is drawn of it, and what a learner draws for it (RandomOf(seed, item.index)).
inline Rng RandomOf(std::uint64_t seed, std::uint64_t item) {
  return Rng(seed).Fork("training_source").Fork("item", item);
}

/// One problem of a training run.
struct TrainingItem {
  std::uint64_t index = 0;  ///< in the training run
  FeatureSet features;
  std::vector<float> inliers;  ///< N, 1 for a true inlier
  MinimalSets labels;          ///< The points of each label; none where the example has no set to draw from.
  /// The points behind the features, in their order, with their truth; not augmented.
  std::shared_ptr<const Example> example;
};

/// One of the datasets of a training run, drawn with a probability in proportion to its weight.
struct TrainingPart {
  std::shared_ptr<const Dataset> dataset;
  double weight = 1.0;
};

/// The key `data`: one dataset, or `type: mixture` with a list `parts` of datasets, each with a `weight` beside its own
/// keys. Throws Error: as MakeDataset, no parts, parts of different tasks, a weight that is not positive.
std::vector<TrainingPart> MakeTrainingParts(const Config& data, std::uint64_t seed);

/// The data itself, or the first of a mixture's.
Config FirstTrainingPart(const Config& data);

/// The keys of a mixture.
std::vector<OptionDescription> DescribeMixture();

/// The resolved options of `data` as YAML.
std::string WriteTrainingData(const Config& data);

/// Makes item `index` of a training run: a function of (seed, index) alone, so that resuming needs only a number.
/// Thread-safe. Labels of finite two-view datasets are searched for once and kept in memory.
class TrainingSource {
 public:
  TrainingSource(std::vector<TrainingPart> parts, PointFeatures features, ItemLabels labels,
                 TwoViewTrainingOptions two_view, std::uint64_t seed);
  /// Throws Error when many examples in a row have too few points, or no truth.
  TrainingItem Make(std::uint64_t index) const;

 private:
  LabelledExample Draw(std::uint64_t index) const;
  std::shared_ptr<const MinimalSets> SetsOf(std::size_t part, std::uint64_t position, const Example& example) const;

  std::vector<TrainingPart> parts_;
  PointFeatures features_;
  ItemLabels labels_;
  TwoViewTrainingOptions two_view_;
  std::uint64_t seed_;
  /// A part's label sets by position; empty for parts that are not kept.
  mutable std::vector<std::vector<std::shared_ptr<const MinimalSets>>> kept_;
  mutable std::mutex mutex_;
};

}  // namespace diffsac
