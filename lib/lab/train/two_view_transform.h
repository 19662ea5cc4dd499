#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/problem/point_features.h"
#include "lab/ground_truth/example.h"
#include "lab/options/options.h"

namespace diffsac {

/// What training does to the matches of two views before the network sees them; all drawn anew each time.
struct TwoViewTrainingOptions {
  int max_points = 0;
  std::vector<double> max_ratios;
  bool augment = false;
  double repeats = 0.0;
  double thinned = 0.0;
  std::vector<double> thinned_to = {0.03, 0.25};
  int likeliest = 0;
  void Bind(OptionsBinder& b);
};

/// Points of each set, as rows of an example.
using MinimalSets = std::vector<std::vector<int>>;

/// An example with the minimal sets that labels are drawn from.
struct LabelledExample {
  Example example;
  std::shared_ptr<const MinimalSets> sets;
};

/// What is left of an example of two views after repeats, a drawn ratio and thinning, with the sets that lie within, as
/// its rows; where none does, those that `search` finds in what is left.
LabelledExample Restricted(const TwoViewTrainingOptions& options, LabelledExample drawn,
                           const std::function<MinimalSets(const Example&)>& search, const Rng& rng);

/// The rows that the network is shown, ascending: all, or max_points of two views.
std::vector<int> ShownRows(const TwoViewTrainingOptions& options, const NormalizedProblem& space,
                           const PointFeatures& kinds, const FeatureSet& features, const MinimalSets& sets,
                           const Rng& rng);

/// A problem of two views with its images mirrored, turned and exchanged, about the principal points or, where these
/// are unknown, the middles. What is known of keypoints goes with them; of descriptors that they do not see an image
/// turn is what they are made for. Minimal sets and, in the images' own coordinates, distances from the true model stay
/// what they are. Points may leave their images, whose sizes stay.
Problem Augmented(Problem problem, Rng rng);

/// Where a row of ascending `rows` stands among them.
int PlaceOf(int row, const std::vector<int>& rows);

}  // namespace diffsac
