#include "diffsac/train/training_source.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "diffsac/core/status.h"
#include "diffsac/data/repeated_structures.h"

namespace diffsac {
namespace {

// Examples that are passed over for having too few points before the data is called useless.
constexpr int kAttempts = 64;
// Standard deviations of the turns of augmentation, degrees.
constexpr double kCommonTurnDeg = 10.0, kRelativeTurnDeg = 5.0;

using Sets = std::vector<std::vector<int>>;

Sets FindSets(const Example& example, const LabelOptions& options) {
  Sets sets;
  for (auto& ranked : OptimalMinimalSets(example, options, options.top_m)) sets.push_back(std::move(ranked.points));
  return sets;
}

// A pair whose plane was not found, say, would teach that all of its matches are wrong.
bool KnowsTruth(const Example& example) {
  const auto& inliers = example.truth.inliers;
  return !IsTwoView(example.problem.task) || example.truth.model.size() > 0 ||
         std::find(inliers.begin(), inliers.end(), 1) != inliers.end();
}

// Matches of at most the drawn ratio; all where there are too few of them.
std::vector<int> PointsWithin(const Problem& problem, double max_ratio, int fewest) {
  const int count = static_cast<int>(problem.points.rows());
  std::vector<int> kept;
  if (problem.quality.size() == count)
    for (int i = 0; i < count; ++i)
      if (problem.quality[i] <= max_ratio) kept.push_back(i);
  if (static_cast<int>(kept.size()) < fewest) {
    kept.resize(count);
    std::iota(kept.begin(), kept.end(), 0);
  }
  return kept;
}

void KeepPoints(const std::vector<int>& kept, Example* example) {
  Problem& problem = example->problem;
  const auto count = static_cast<std::size_t>(problem.points.rows());
  if (kept.size() == count) return;
  if (problem.quality.size() == problem.points.rows()) problem.quality = Eigen::VectorXd(problem.quality(kept));
  if (problem.descriptors.rows() == problem.points.rows())
    problem.descriptors = DescriptorMatrix(problem.descriptors(kept, Eigen::all));
  problem.points = PointMatrix(problem.points(kept, Eigen::all));
  if (example->truth.inliers.size() == count) {
    std::vector<std::uint8_t> inliers;
    for (const int i : kept) inliers.push_back(example->truth.inliers[i]);
    example->truth.inliers = std::move(inliers);
  }
}

// `must` and random others of `from`, `count` in all, ascending.
std::vector<int> RandomSubset(const std::vector<int>& from, const std::vector<int>& must, int count, Rng rng) {
  std::vector<int> others;
  std::set_difference(from.begin(), from.end(), must.begin(), must.end(), std::back_inserter(others));
  std::vector<int> subset = must;
  for (std::size_t i = 0; static_cast<int>(subset.size()) < count && i < others.size(); ++i) {
    std::swap(others[i], others[i + rng.Below(others.size() - i)]);
    subset.push_back(others[i]);
  }
  std::sort(subset.begin(), subset.end());
  return subset;
}

void Turn(double degrees, int first, FeatureSet* features) {
  const double angle = degrees * std::numbers::pi / 180.0;
  Eigen::Matrix2f turn;
  turn << std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle);
  features->values.middleCols(first, 2) = (features->values.middleCols(first, 2) * turn).eval();
}

void ExchangeColumns(int first, int size, FeatureSet* features) {
  const auto kept = features->values.middleCols(first, size).eval();
  features->values.middleCols(first, size) = features->values.middleCols(first + size, size).eval();
  features->values.middleCols(first + size, size) = kept;
}

// The coordinates' columns are the first four, about the principal point. Descriptors are exchanged with the images;
// that they do not see an image turn or mirror is what they are made for, as far as turns go.
void Augment(const PointFeatures& kinds, Rng rng, FeatureSet* features) {
  auto& values = features->values;
  if (rng.Uniform() < 0.5) {
    ExchangeColumns(0, 2, features);
    if (kinds.first_descriptor() >= 0) ExchangeColumns(kinds.first_descriptor(), kinds.descriptor_size(), features);
  }
  if (rng.Uniform() < 0.5) {
    values.col(0) *= -1.0f;
    values.col(2) *= -1.0f;
  }
  const double common = 90.0 * static_cast<double>(rng.Below(4)) + kCommonTurnDeg * rng.Normal();
  const double relative = kRelativeTurnDeg * rng.Normal();
  Turn(common, 0, features);
  Turn(common + relative, 2, features);
}

}  // namespace

void TwoViewTrainingOptions::Bind(OptionsBinder& b) {
  b.Field("max_points", max_points, AtLeast(0));
  b.Field("max_ratios", max_ratios, Within(0.01, 1.0));
  b.Field("augment", augment);
  b.Field("repeats", repeats, Within(0.0, 1.0));
  b.Require(max_points == 0 || max_points >= 16, "max_points", "0 or at least 16");
}

TrainingSource::TrainingSource(std::vector<TrainingPart> parts, PointFeatures features, LabelOptions labels,
                               TwoViewTrainingOptions two_view, int copies, int schedule_steps, std::uint64_t seed)
    : parts_(std::move(parts)),
      features_(std::move(features)),
      labels_(std::move(labels)),
      two_view_(std::move(two_view)),
      copies_(copies),
      schedule_steps_(schedule_steps),
      rng_(Rng(seed).Fork("training_source")) {
  for (const auto& part : parts_) {
    const bool keep = part.dataset->size() > 0 && IsTwoView(part.dataset->task());
    kept_.emplace_back(keep ? part.dataset->size() : 0);
  }
}

TrainingSource::TrainingSource(const Dataset& dataset, PointFeatures features, LabelOptions labels, int copies,
                               int schedule_steps, std::uint64_t seed)
    : TrainingSource({{std::shared_ptr<const Dataset>(std::shared_ptr<const Dataset>(), &dataset), 1.0}},
                     std::move(features), std::move(labels), {}, copies, schedule_steps, seed) {}

std::shared_ptr<const TrainingSource::Sets> TrainingSource::SetsOf(std::size_t part, std::uint64_t position,
                                                                   const Example& example) const {
  if (copies_ == 0) return std::make_shared<const Sets>();
  if (kept_[part].empty()) return std::make_shared<const Sets>(FindSets(example, labels_));
  {
    const std::lock_guard lock(mutex_);
    if (kept_[part][position]) return kept_[part][position];
  }
  auto sets = std::make_shared<const Sets>(FindSets(example, labels_));
  const std::lock_guard lock(mutex_);
  return kept_[part][position] = std::move(sets);
}

TrainingSource::Drawn TrainingSource::Draw(std::uint64_t index) const {
  Rng rng = rng_.Fork("part", index);
  std::size_t part = 0;
  if (parts_.size() > 1) {
    double total = 0.0;
    for (const auto& p : parts_) total += p.weight;
    for (double u = rng.Uniform() * total; part + 1 < parts_.size() && u >= parts_[part].weight; ++part)
      u -= parts_[part].weight;
  }
  const Dataset& dataset = *parts_[part].dataset;
  // A finite dataset is seen again each epoch, with other labels, times and noise.
  const std::uint64_t size = dataset.size() > 0 ? static_cast<std::uint64_t>(dataset.size()) : 0;
  std::uint64_t position = index;
  if (size > 0) position = parts_.size() > 1 ? rng.Below(size) : index % size;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    Example example = dataset.Get(position);
    if (example.problem.points.rows() > MinimalSetSize(example.problem.task) && KnowsTruth(example)) {
      auto sets = SetsOf(part, position, example);
      return {std::move(example), std::move(sets)};
    }
    position = size > 0 ? (position + 1) % size : position + 1;
  }
  throw Error("the training data has " + std::to_string(kAttempts) + " examples in a row with too few points, up to '" +
              dataset.Get(position).id + "'");
}

TrainingItem TrainingSource::Make(std::uint64_t index) const {
  auto [example, all_sets] = Draw(index);
  const Rng rng = rng_.Fork("item", index);
  const bool two_view = IsTwoView(example.problem.task);
  const int total = static_cast<int>(example.problem.points.rows());
  std::vector<char> moved(total, 0);
  if (two_view && two_view_.repeats > 0.0 && rng.Fork("repeats").Uniform() < two_view_.repeats)
    moved = MoveGroups(rng.Fork("moved_groups"), &example);

  std::vector<int> within;
  Sets usable;
  if (two_view && !two_view_.max_ratios.empty()) {
    Rng choice = rng.Fork("max_ratio");
    within = PointsWithin(example.problem, two_view_.max_ratios[choice.Below(two_view_.max_ratios.size())],
                          MinimalSetSize(example.problem.task) + 1);
  } else {
    within.resize(total);
    std::iota(within.begin(), within.end(), 0);
  }
  std::vector<char> present(total, 0);
  for (const int i : within) present[i] = !moved[i];
  for (const auto& set : *all_sets)
    if (std::all_of(set.begin(), set.end(), [&](int i) { return present[i] != 0; })) usable.push_back(set);
  if (usable.empty() && !all_sets->empty()) {
    // None of the kept sets lies within: search among what is left.
    KeepPoints(within, &example);
    usable = FindSets(example, labels_);
    within.resize(example.problem.points.rows());
    std::iota(within.begin(), within.end(), 0);
  }

  Rng choice = rng.Fork("label");
  std::vector<const std::vector<int>*> chosen;
  for (int k = 0; k < copies_ && !usable.empty(); ++k) chosen.push_back(&usable[choice.Below(usable.size())]);
  std::vector<int> must;
  for (const auto* set : chosen) must.insert(must.end(), set->begin(), set->end());
  std::sort(must.begin(), must.end());
  must.erase(std::unique(must.begin(), must.end()), must.end());
  const bool reduce = two_view && two_view_.max_points > 0 && static_cast<int>(within.size()) > two_view_.max_points;
  const auto subset = reduce ? RandomSubset(within, must, two_view_.max_points, rng.Fork("subset")) : within;
  // Features are those of all matches, as at inference; only then is the subset taken.
  Example full = example;
  KeepPoints(within, &full);
  std::vector<int> places;
  for (const int i : subset)
    places.push_back(static_cast<int>(std::lower_bound(within.begin(), within.end(), i) - within.begin()));
  TrainingItem item;
  item.index = index;
  item.features = features_.Compute(full.problem, rng.Fork("features"));
  item.features.values = decltype(item.features.values)(item.features.values(places, Eigen::all));
  KeepPoints(subset, &example);
  if (two_view && two_view_.augment && item.features.values.cols() >= 4)
    Augment(features_, rng.Fork("augment"), &item.features);
  const std::size_t points = static_cast<std::size_t>(example.problem.points.rows());
  item.inliers.assign(points, 0.0f);
  std::copy(example.truth.inliers.begin(), example.truth.inliers.end(), item.inliers.begin());

  item.labels.assign(copies_ * points, -1.0f);
  for (std::size_t k = 0; k < chosen.size(); ++k)
    for (const int i : *chosen[k]) {
      const auto at = std::lower_bound(subset.begin(), subset.end(), i) - subset.begin();
      item.labels[k * points + static_cast<std::size_t>(at)] = 1.0f;
    }
  Rng time = rng.Fork("time");
  for (int k = 0; k < copies_; ++k) item.times.push_back(static_cast<int>(time.Below(schedule_steps_)));
  Rng noise = rng.Fork("noise");
  item.noise.resize(copies_ * points);
  for (float& value : item.noise) value = static_cast<float>(noise.Normal());
  item.example = std::make_shared<const Example>(std::move(example));
  return item;
}

}  // namespace diffsac
