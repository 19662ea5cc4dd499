#include "lab/train/training_source.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "diffsac/core/status.h"
#include "diffsac/estimators/point_prior.h"
#include "lab/data/pair_filter.h"
#include "lab/data/repeated_structures.h"

namespace diffsac {
namespace {

// Examples that are passed over for having too few points before the data is called useless.
constexpr int kAttempts = 64;
// Correct matches that thinning leaves at least.
constexpr int kFewestCorrect = 12;
// Standard deviations of the turns of augmentation, degrees.
constexpr double kCommonTurnDeg = 10.0, kRelativeTurnDeg = 5.0;

using Sets = std::vector<std::vector<int>>;

// A pair whose plane was not found, say, would teach that all of its matches are wrong.
bool KnowsTruth(const Example& example) {
  const auto& inliers = example.truth.inliers;
  return !IsTwoView(example.problem.task) || example.truth.model.size() > 0 ||
         std::find(inliers.begin(), inliers.end(), 1) != inliers.end();
}

std::vector<int> AllRows(Eigen::Index count) {
  std::vector<int> rows(static_cast<std::size_t>(count));
  std::iota(rows.begin(), rows.end(), 0);
  return rows;
}

// Matches of at most the drawn ratio; all where there are too few of them.
std::vector<int> PointsWithin(const Problem& problem, double max_ratio, int fewest) {
  const int count = static_cast<int>(problem.points.rows());
  std::vector<int> kept;
  if (problem.match_ratio.size() == count)
    for (int i = 0; i < count; ++i)
      if (problem.match_ratio[i] <= max_ratio) kept.push_back(i);
  return static_cast<int>(kept.size()) < fewest ? AllRows(count) : kept;
}

// Where a row of ascending `rows` stands among them.
int PlaceOf(int row, const std::vector<int>& rows) {
  return static_cast<int>(std::lower_bound(rows.begin(), rows.end(), row) - rows.begin());
}

// The sets whose points are all `present`, as places among `rows`.
Sets SetsWithin(const Sets& sets, const std::vector<char>& present, const std::vector<int>& rows) {
  Sets within;
  for (const auto& set : sets) {
    if (!std::all_of(set.begin(), set.end(), [&](int i) { return present[i] != 0; })) continue;
    within.push_back(set);
    for (int& i : within.back()) i = PlaceOf(i, rows);
  }
  return within;
}

Sets ChooseSets(const Sets& sets, int count, Rng rng) {
  Sets chosen;
  for (int k = 0; k < count && !sets.empty(); ++k) chosen.push_back(sets[rng.Below(sets.size())]);
  return chosen;
}

// The points of the sets and random others of `among` (ascending), `count` in all, ascending.
std::vector<int> RandomSubset(const std::vector<int>& among, const Sets& sets, int count, Rng rng) {
  std::vector<int> must;
  for (const auto& set : sets) must.insert(must.end(), set.begin(), set.end());
  std::sort(must.begin(), must.end());
  must.erase(std::unique(must.begin(), must.end()), must.end());
  std::vector<int> others;
  std::set_difference(among.begin(), among.end(), must.begin(), must.end(), std::back_inserter(others));
  std::vector<int> subset = must;
  for (std::size_t i = 0; static_cast<int>(subset.size()) < count && i < others.size(); ++i) {
    std::swap(others[i], others[i + rng.Below(others.size() - i)]);
    subset.push_back(others[i]);
  }
  std::sort(subset.begin(), subset.end());
  return subset;
}

// Rows without so many of the correct matches that `share` of what is left is correct. Those of one of the sets stay,
// so that there is a label.
std::vector<int> Thinned(const std::vector<int>& rows, const std::vector<std::uint8_t>& inliers, const Sets& sets,
                         double share, Rng rng) {
  std::vector<int> correct;
  for (const int i : rows)
    if (inliers[i]) correct.push_back(i);
  const double wrong = static_cast<double>(rows.size() - correct.size());
  const auto left = std::max(kFewestCorrect, static_cast<int>(std::lround(share / (1.0 - share) * wrong)));
  const int drop = static_cast<int>(correct.size()) - left;
  if (drop <= 0) return rows;
  std::vector<char> stays(inliers.size(), 1);
  const std::vector<int> none;
  const std::vector<int>& kept = sets.empty() ? none : sets[rng.Below(sets.size())];
  int dropped = 0;
  for (const int k : rng.Permutation(static_cast<int>(correct.size()))) {
    if (dropped == drop) break;
    if (std::find(kept.begin(), kept.end(), correct[k]) != kept.end()) continue;
    stays[correct[k]] = 0;
    ++dropped;
  }
  std::vector<int> thinned;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(thinned), [&](int i) { return stays[i] != 0; });
  return thinned;
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
  b.Field("max_points", max_points, AtLeast(0))
      .Help("at most so many matches: those of the drawn labels and random others; 0 keeps all");
  b.Field("max_ratios", max_ratios, Within(0.01, 1.0))
      .Help("one is drawn for each item, and only matches of at most this ratio are kept; empty: all matches");
  b.Field("augment", augment)
      .Help("both images mirrored and turned together, one turned a little more, the images exchanged");
  b.Field("repeats", repeats, Within(0.0, 1.0))
      .Help("share of the items in which groups of correct matches become wrong ones (lab/data/repeated_structures.h)");
  b.Field("thinned", thinned, Within(0.0, 1.0))
      .Help("share of the items in which correct matches are left out until few of the matches are correct");
  b.Field("thinned_to", thinned_to, Within(0.001, 0.999))
      .OnlyIf(thinned > 0.0, "thinned > 0")
      .Help("so few: the share that is left is drawn between these, its logarithm uniform");
  b.Field("likeliest", likeliest, AtLeast(0))
      .OnlyIf(max_points > 0, "max_points > 0")
      .Help("the matches of max_points are among so many of highest prior, as with `max_encoded_points`; 0: among all");
  b.Require(thinned_to.size() == 2 && thinned_to[0] <= thinned_to[1], "thinned_to", "two shares, the smaller first");
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
  if (kept_[part].empty()) return std::make_shared<const Sets>(LabelSets(example, labels_));
  {
    const std::lock_guard lock(mutex_);
    if (kept_[part][position]) return kept_[part][position];
  }
  auto sets = std::make_shared<const Sets>(LabelSets(example, labels_));
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

TrainingSource::Drawn TrainingSource::Restricted(Drawn drawn, const Rng& rng) const {
  Example& example = drawn.example;
  if (!IsTwoView(example.problem.task)) return drawn;
  std::vector<char> moved(static_cast<std::size_t>(example.problem.points.rows()), 0);
  if (two_view_.repeats > 0.0 && rng.Fork("repeats").Uniform() < two_view_.repeats)
    moved = MoveGroups(rng.Fork("moved_groups"), &example);
  std::vector<int> rows = AllRows(example.problem.points.rows());
  if (!two_view_.max_ratios.empty()) {
    Rng choice = rng.Fork("max_ratio");
    rows = PointsWithin(example.problem, two_view_.max_ratios[choice.Below(two_view_.max_ratios.size())],
                        MinimalSetSize(example.problem.task) + 1);
  }
  if (two_view_.thinned > 0.0 && rng.Fork("thinned").Uniform() < two_view_.thinned) {
    Rng choice = rng.Fork("thinned_to");
    const double share = std::exp(choice.Uniform(std::log(two_view_.thinned_to[0]), std::log(two_view_.thinned_to[1])));
    rows = Thinned(rows, example.truth.inliers, *drawn.sets, share, choice);
  }
  std::vector<char> present(moved.size(), 0);
  for (const int i : rows) present[i] = !moved[i];
  if (rows.size() < moved.size()) example = WithRows(example, rows);
  if (drawn.sets->empty()) return drawn;
  Sets usable = SetsWithin(*drawn.sets, present, rows);
  // Where none of the kept sets lies within, others are searched for among what is left.
  if (usable.empty()) usable = LabelSets(example, labels_);
  drawn.sets = std::make_shared<const Sets>(std::move(usable));
  return drawn;
}

TrainingItem TrainingSource::Make(std::uint64_t index) const {
  const Rng rng = rng_.Fork("item", index);
  const Drawn drawn = Restricted(Draw(index), rng);
  const bool two_view = IsTwoView(drawn.example.problem.task);
  const int total = static_cast<int>(drawn.example.problem.points.rows());
  const Sets chosen = ChooseSets(*drawn.sets, copies_, rng.Fork("label"));
  TrainingItem item;
  item.index = index;
  // Features are those of all matches, as at inference; only then is the subset taken.
  const SolverSpace space(drawn.example.problem);
  item.features = features_.Compute(space, rng.Fork("features"));
  std::vector<int> rows = AllRows(total);
  if (two_view && two_view_.max_points > 0 && total > two_view_.max_points) {
    if (two_view_.likeliest > 0)
      rows = LikeliestPoints(PointPrior(space, item.features, features_), two_view_.likeliest);
    rows = RandomSubset(rows, chosen, two_view_.max_points, rng.Fork("subset"));
  }
  item.features.values = decltype(item.features.values)(item.features.values(rows, Eigen::all));
  if (two_view && two_view_.augment && item.features.values.cols() >= 4)
    Augment(features_, rng.Fork("augment"), &item.features);
  item.example = std::make_shared<const Example>(WithRows(drawn.example, rows));
  const auto& inliers = item.example->truth.inliers;
  item.inliers.assign(rows.size(), 0.0f);
  std::copy(inliers.begin(), inliers.end(), item.inliers.begin());
  item.labels.assign(copies_ * rows.size(), -1.0f);
  for (std::size_t k = 0; k < chosen.size(); ++k)
    for (const int i : chosen[k]) item.labels[k * rows.size() + static_cast<std::size_t>(PlaceOf(i, rows))] = 1.0f;
  Rng time = rng.Fork("time");
  for (int k = 0; k < copies_; ++k) item.times.push_back(static_cast<int>(time.Below(schedule_steps_)));
  Rng noise = rng.Fork("noise");
  item.noise.resize(copies_ * rows.size());
  for (float& value : item.noise) value = static_cast<float>(noise.Normal());
  return item;
}

}  // namespace diffsac
