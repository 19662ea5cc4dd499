#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "diffsac/core/options.h"
#include "diffsac/problem/point_features.h"
#include "diffsac/problem/problem.h"
#include "lab/truth/labels.h"

namespace diffsac {

/// One problem with everything a training step draws for it.
struct TrainingItem {
  std::uint64_t index = 0;  ///< in the training run
  FeatureSet features;
  std::vector<float> inliers;  ///< N, 1 for a true inlier
  std::vector<float> labels;   ///< copies × N, ±1
  std::vector<float> noise;    ///< copies × N, standard normal
  std::vector<int> times;      ///< copies, uniform in [0, T)
  /// The points behind the features, in their order, with their truth; not augmented.
  std::shared_ptr<const Example> example;
};

/// What training does to the matches of two views before the network sees them; all drawn anew each time.
struct TwoViewTrainingOptions {
  /// At most so many matches: those of the drawn labels and random others; 0 keeps all.
  int max_points = 0;
  /// One is drawn for each item and only matches of at most this ratio are kept. Empty: all matches.
  std::vector<double> max_ratios;
  /// Both images mirrored and turned together, one turned a little more, the images exchanged: minimal sets stay what
  /// they are, so that one pair stands for many cameras and motions.
  bool augment = false;
  /// Share of the items in which groups of correct matches become wrong ones (lab/data/repeated_structures.h).
  double repeats = 0.0;
  /// Share of the items in which correct matches are left out at random until only such a share of the matches, drawn
  /// between these two with a uniform logarithm, is correct: hard pairs of easy ones. Twelve correct ones stay, and
  /// what is harder stays as it is.
  double thinned = 0.0;
  std::vector<double> thinned_to = {0.03, 0.25};
  /// The random others of max_points are among so many matches of highest prior, as with the key max_encoded_points of
  /// an estimator (PointPrior); 0: among all.
  int likeliest = 0;
  void Bind(OptionsBinder& b);
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
/// Thread-safe. Labels of finite two-view datasets are searched for once and kept in memory; none with 0 copies.
class TrainingSource {
 public:
  TrainingSource(std::vector<TrainingPart> parts, PointFeatures features, LabelOptions labels,
                 TwoViewTrainingOptions two_view, int copies, int schedule_steps, std::uint64_t seed);
  /// One dataset, which must outlive the source.
  TrainingSource(const Dataset& dataset, PointFeatures features, LabelOptions labels, int copies, int schedule_steps,
                 std::uint64_t seed);
  /// Throws Error when many examples in a row have too few points.
  TrainingItem Make(std::uint64_t index) const;

 private:
  using Sets = std::vector<std::vector<int>>;
  struct Drawn {
    Example example;
    std::shared_ptr<const Sets> sets;
  };
  Drawn Draw(std::uint64_t index) const;
  /// What is left of an example after repeats and the drawn ratio, with the sets that lie within, as its rows.
  Drawn Restricted(Drawn drawn, const Rng& rng) const;
  std::shared_ptr<const Sets> SetsOf(std::size_t part, std::uint64_t position, const Example& example) const;

  std::vector<TrainingPart> parts_;
  PointFeatures features_;
  LabelOptions labels_;
  TwoViewTrainingOptions two_view_;
  int copies_;
  int schedule_steps_;
  Rng rng_;
  /// A part's label sets by position; empty for parts that are not kept.
  mutable std::vector<std::vector<std::shared_ptr<const Sets>>> kept_;
  mutable std::mutex mutex_;
};

}  // namespace diffsac
