#include "lab/train/training_source.h"

#include <algorithm>
#include <utility>

#include "diffsac/core/status.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"
#include "lab/data/pair_filter.h"

namespace diffsac {
namespace {

// Examples that are passed over for having too few points, or no truth, before the data is called useless.
constexpr int kAttempts = 64;
// A pair whose plane was not found, say, would teach that all of its matches are wrong.
bool KnowsTruth(const Example& example) {
  const auto& inliers = example.truth.inliers;
  return !IsTwoView(example.problem.task) || example.truth.model.size() > 0 ||
         std::find(inliers.begin(), inliers.end(), 1) != inliers.end();
}

// Some of the minimal sets, drawn with replacement: a label each.
MinimalSets ChooseSets(const MinimalSets& sets, int count, Rng rng) {
  MinimalSets chosen;
  for (int k = 0; k < count && !sets.empty(); ++k) chosen.push_back(sets[rng.Below(sets.size())]);
  return chosen;
}

constexpr char kMixture[] = "mixture";

bool IsMixture(const Config& data) { return data.Has("type") && data.Text("type") == kMixture; }

struct MixturePart {
  double weight = 1.0;
  Config data;
  void Bind(OptionsBinder& b) {
    b.Field("weight", weight, Positive()).Help("examples are drawn in proportion to it");
    b.Rest(data).Help("the keys of the part's own data, `type` among them");
  }
};

struct Mixture {
  std::string type = kMixture;
  std::vector<MixturePart> parts;
  void Bind(OptionsBinder& b) {
    b.Choice("type", type, {kMixture}).Help("several datasets");
    b.Field("parts", parts).Help("datasets of one task");
    b.Require(!parts.empty(), "parts", "a list of datasets, each with its type");
  }
};

}  // namespace

std::vector<TrainingPart> MakeTrainingParts(const Config& data, std::uint64_t seed) {
  std::vector<TrainingPart> parts;
  if (!IsMixture(data)) {
    parts.push_back({MakeDataset(data, seed), 1.0});
    return parts;
  }
  for (const MixturePart& part : ReadOptions<Mixture>(data).parts)
    parts.push_back({MakeDataset(part.data, seed), part.weight});
  for (const TrainingPart& part : parts) {
    if (part.dataset->task() != parts.front().dataset->task())
      throw Error(data.Where("parts") + ": data of different tasks");
    if (part.dataset->size() == 0) throw Error(data.Where("parts") + ": a part holds no examples");
  }
  return parts;
}

Config FirstTrainingPart(const Config& data) {
  return IsMixture(data) ? ReadOptions<Mixture>(data).parts.front().data : data;
}

std::vector<OptionDescription> DescribeMixture() { return DescribeOptions<Mixture>(); }

std::string WriteTrainingData(const Config& data) {
  if (!IsMixture(data)) return WriteDatasetOptions(data);
  Mixture mixture = ReadOptions<Mixture>(data);
  for (MixturePart& part : mixture.parts) part.data = ConfigFromYaml(WriteDatasetOptions(part.data));
  return WriteYaml(mixture);
}

TrainingSource::TrainingSource(std::vector<TrainingPart> parts, PointFeatures features, ItemLabels labels,
                               TwoViewTrainingOptions two_view, std::uint64_t seed)
    : parts_(std::move(parts)),
      features_(std::move(features)),
      labels_(std::move(labels)),
      two_view_(std::move(two_view)),
      seed_(seed) {
  for (const auto& part : parts_) {
    const bool keep = part.dataset->size() > 0 && IsTwoView(part.dataset->task());
    kept_.emplace_back(keep ? part.dataset->size() : 0);
  }
}

std::shared_ptr<const MinimalSets> TrainingSource::SetsOf(std::size_t part, std::uint64_t position,
                                                          const Example& example) const {
  if (labels_.count == 0) return std::make_shared<const MinimalSets>();
  if (kept_[part].empty()) return std::make_shared<const MinimalSets>(LabelSets(example, labels_));
  {
    const std::lock_guard lock(mutex_);
    if (kept_[part][position]) return kept_[part][position];
  }
  auto sets = std::make_shared<const MinimalSets>(LabelSets(example, labels_));
  const std::lock_guard lock(mutex_);
  return kept_[part][position] = std::move(sets);
}

LabelledExample TrainingSource::Draw(std::uint64_t index) const {
  Rng rng = Rng(seed_).Fork("training_source").Fork("part", index);
  std::size_t part = 0;
  if (parts_.size() > 1) {
    double total = 0.0;
    for (const auto& p : parts_) total += p.weight;
    for (double u = rng.Uniform() * total; part + 1 < parts_.size() && u >= parts_[part].weight; ++part)
      u -= parts_[part].weight;
  }
  const Dataset& dataset = *parts_[part].dataset;
  // A finite dataset is seen again each epoch, with other labels.
  const std::uint64_t size = dataset.size() > 0 ? static_cast<std::uint64_t>(dataset.size()) : 0;
  std::uint64_t position = index;
  if (size > 0) position = parts_.size() > 1 ? rng.Below(size) : index % size;
  int without_truth = 0;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    Example example = dataset.Get(position);
    const bool known = KnowsTruth(example);
    without_truth += !known;
    if (example.problem.points.rows() > MinimalSetSize(example.problem.task) && known) {
      auto sets = SetsOf(part, position, example);
      return {std::move(example), std::move(sets)};
    }
    position = size > 0 ? (position + 1) % size : position + 1;
  }
  const Example last = dataset.Get(position);
  const std::string folder = dataset.FolderOf(last.scene);
  if (without_truth == kAttempts)
    throw Error((folder.empty() ? "the training data" : folder) +
                ": no truth to learn from: R.h5 and T.h5, Egt.h5, Fgt.h5, Hgt.h5 or labels.h5 would tell task " +
                ToString(last.problem.task) + " the true model");
  throw Error("the training data has " + std::to_string(kAttempts) + " examples in a row with too few points, up to '" +
              last.id + "'" + (folder.empty() ? "" : " of " + folder));
}

TrainingItem TrainingSource::Make(std::uint64_t index) const {
  const Rng rng = RandomOf(seed_, index);
  const auto search = [&](const Example& example) { return LabelSets(example, labels_); };
  const LabelledExample drawn = Restricted(two_view_, Draw(index), search, rng);
  TrainingItem item;
  item.index = index;
  item.labels = ChooseSets(*drawn.sets, labels_.count, rng.Fork("label"));
  const bool augmented = two_view_.augment && IsTwoView(drawn.example.problem.task);
  const Problem seen = augmented ? Augmented(drawn.example.problem, rng.Fork("augment")) : drawn.example.problem;
  // Features are those of all matches, as at inference; only then is the subset taken.
  const NormalizedProblem space(seen);
  item.features = features_.Compute(space, rng.Fork("features"));
  const std::vector<int> rows = ShownRows(two_view_, space, features_, item.features, item.labels, rng.Fork("subset"));
  item.features.values = decltype(item.features.values)(item.features.values(rows, Eigen::all));
  item.example = std::make_shared<const Example>(WithRows(drawn.example, rows));
  const auto& inliers = item.example->truth.inliers;
  item.inliers.assign(rows.size(), 0.0f);
  std::copy(inliers.begin(), inliers.end(), item.inliers.begin());
  for (auto& label : item.labels)
    for (int& i : label) i = PlaceOf(i, rows);
  return item;
}

}  // namespace diffsac
