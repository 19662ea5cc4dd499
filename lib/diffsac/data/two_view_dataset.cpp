#include "diffsac/data/two_view_dataset.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "diffsac/core/random.h"
#include "diffsac/core/status.h"
#include "diffsac/data/correspondence_files.h"
#include "diffsac/data/dataset_registry.h"
#include "diffsac/data/dominant_plane.h"
#include "diffsac/data/refined_truth.h"

namespace diffsac {
namespace {

std::vector<int> Permuted(const std::vector<int>& values, Rng rng) {
  std::vector<int> permuted;
  for (int i : rng.Permutation(static_cast<int>(values.size()))) permuted.push_back(values[i]);
  return permuted;
}

/// Rows to keep, in the order of the file or, when they are shuffled, in a random one.
std::vector<int> KeptRows(const TwoViewProblem& problem, const CorrespondencesOptions& options, const Rng& rng) {
  const bool rated = problem.quality.size() == problem.points.rows();
  std::vector<int> rows;
  for (int i = 0; i < problem.points.rows(); ++i)
    if (!rated || !(problem.quality[i] > options.max_ratio)) rows.push_back(i);
  if (options.max_points > 0 && static_cast<int>(rows.size()) > options.max_points) {
    if (options.cap == "random")
      rows = Permuted(rows, rng.Fork("cap"));
    else if (rated)
      std::stable_sort(rows.begin(), rows.end(), [&](int a, int b) { return problem.quality[a] < problem.quality[b]; });
    rows.resize(options.max_points);
    std::sort(rows.begin(), rows.end());
  }
  return options.shuffle_points ? Permuted(rows, rng.Fork("shuffle")) : rows;
}

ModelParameters TrueModel(const TwoViewTruth& truth, Task task) {
  const std::optional<Eigen::Matrix3d>& matrix = task == Task::kHomography    ? truth.homography
                                                 : task == Task::kFundamental ? truth.fundamental
                                                                              : truth.essential;
  return matrix ? ModelParameters(AsParameters(*matrix)) : ModelParameters();
}

/// True inliers: the file's labels, else the matches within ε of the true model; empty when neither is known.
std::vector<std::uint8_t> TrueInliers(const TwoViewProblem& problem, const TwoViewTruth& truth, double threshold) {
  std::vector<std::uint8_t> inliers;
  if (!truth.labels.empty()) {
    for (std::int32_t label : truth.labels) inliers.push_back(label > 0);
    return inliers;
  }
  const Eigen::VectorXd distances = TruthDistances(problem, truth);
  for (double distance : distances) inliers.push_back(distance <= threshold);
  return inliers;
}

/// The part of a scene's pairs that is asked for, thinned to `max_pairs`.
std::vector<std::int64_t> PairsOf(std::int64_t size, const CorrespondencesOptions& options) {
  const auto at = [&](double share) {
    return static_cast<std::int64_t>(std::llround(share * static_cast<double>(size)));
  };
  const std::int64_t first = at(options.part.low);
  std::vector<std::int64_t> positions = EvenlySpread(at(options.part.high) - first, options.max_pairs);
  for (std::int64_t& position : positions) position += first;
  return positions;
}

// Each image's descriptor of each match by itself.
void AddDescriptorNoise(double strength, Rng rng, DescriptorMatrix* descriptors) {
  const Eigen::Index size = descriptors->cols() / 2;
  for (Eigen::Index i = 0; i < descriptors->rows(); ++i)
    for (int image = 0; image < 2; ++image) {
      auto values = descriptors->row(i).segment(image * size, size);
      const double deviation = strength * values.norm() / std::sqrt(static_cast<double>(size));
      for (float& value : values) value += static_cast<float>(deviation * rng.Normal());
    }
}

class CorrespondenceDataset : public Dataset {
 public:
  CorrespondenceDataset(Task task, std::vector<Example> examples) : task_(task), examples_(std::move(examples)) {}
  Task task() const override { return task_; }
  std::int64_t size() const override { return static_cast<std::int64_t>(examples_.size()); }
  Example Get(std::uint64_t index) const override {
    if (index >= examples_.size()) throw Error("correspondences: there is no pair " + std::to_string(index));
    return examples_[index];
  }

 private:
  Task task_;
  std::vector<Example> examples_;
};

}  // namespace

void CorrespondencesOptions::Bind(OptionsBinder& b) {
  b.Field("paths", paths);
  b.Choice("task", task, {"homography", "fundamental", "essential"});
  b.Field("inlier_threshold_px", inlier_threshold_px, Positive());
  b.Field("max_ratio", max_ratio, Positive());
  b.Field("max_points", max_points, AtLeast(0));
  b.Choice("cap", cap, {"best", "random"});
  b.Field("shuffle_points", shuffle_points);
  b.Field("min_points", min_points, AtLeast(0));
  b.Field("max_pairs", max_pairs, AtLeast(0));
  b.Field("part", part, Within(0.0, 1.0));
  b.Field("refine_truth_px", refine_truth_px, AtLeast(0.0));
  b.Field("dominant_plane", dominant_plane);
  b.Field("descriptors", descriptors);
  b.Field("descriptor_noise", descriptor_noise, AtLeast(0.0));
}

Example ToExample(const TwoViewExample& pair, Task task, const CorrespondencesOptions& options) {
  const std::string name = pair.scene + "/" + pair.id;
  const std::vector<int> rows = KeptRows(pair.problem, options, Rng(0).Fork("matches/" + name));
  TwoViewTruth truth = pair.truth;
  if (options.refine_truth_px > 0.0) RefineEpipolarTruth(pair.problem, options.refine_truth_px, &truth);
  if (task == Task::kHomography && options.dominant_plane) {
    truth.homography = DominantHomography(pair.problem, truth, options.inlier_threshold_px, name);
    truth.labels.clear();
    if (!truth.homography) truth.fundamental.reset();
  }
  const std::vector<std::uint8_t> inliers = TrueInliers(pair.problem, truth, options.inlier_threshold_px);
  Example example;
  example.id = name;
  example.scene = pair.scene;
  example.problem.task = task;
  example.problem.inlier_threshold = options.inlier_threshold_px;
  example.problem.points = pair.problem.points(rows, Eigen::all);
  if (pair.problem.quality.size() == pair.problem.points.rows()) example.problem.quality = pair.problem.quality(rows);
  if (pair.problem.calibrated) example.problem.cameras = CameraPair{pair.problem.K1, pair.problem.K2};
  example.problem.size1 = pair.problem.size1;
  example.problem.size2 = pair.problem.size2;
  if (pair.problem.descriptors.rows() == pair.problem.points.rows())
    example.problem.descriptors = pair.problem.descriptors(rows, Eigen::all);
  if (options.descriptor_noise > 0.0)
    AddDescriptorNoise(options.descriptor_noise, Rng(0).Fork("descriptors/" + name), &example.problem.descriptors);
  example.truth.model = TrueModel(truth, task);
  if (truth.motion) {
    const double length = truth.motion->translation.norm();
    example.truth.pose =
        RelativePose{truth.motion->rotation,
                     length > 0.0 ? Eigen::Vector3d(truth.motion->translation / length) : Eigen::Vector3d::Zero()};
  }
  if (!inliers.empty())
    for (int row : rows) example.truth.inliers.push_back(inliers[row]);
  return example;
}

std::vector<std::int64_t> EvenlySpread(std::int64_t size, int count) {
  if (count == 0 || count >= size) {
    std::vector<std::int64_t> all(size);
    std::iota(all.begin(), all.end(), 0);
    return all;
  }
  std::vector<std::int64_t> positions;
  for (int i = 0; i < count; ++i) positions.push_back(i * size / count);
  return positions;
}

std::unique_ptr<Dataset> MakeCorrespondences(const CorrespondencesOptions& options) {
  const Task task = TaskFromString(options.task);
  std::vector<Example> examples;
  for (const std::string& path : options.paths) {
    for (const std::string& folder : FindCorrespondenceScenes(path)) {
      const CorrespondenceScene scene(folder, {options.inlier_threshold_px, options.descriptors});
      for (std::int64_t position : PairsOf(scene.size(), options)) {
        Example example = ToExample(scene.Read(position), task, options);
        if (task == Task::kEssential && !example.problem.cameras)
          throw Error(folder + ": pair '" + example.id + "' has no calibration (K1_K2.h5), which task essential needs");
        if (example.problem.points.rows() < options.min_points) continue;
        example.index = examples.size();
        examples.push_back(std::move(example));
      }
    }
  }
  if (examples.empty())
    throw Error("correspondences: no pairs with at least " + std::to_string(options.min_points) +
                " matches in the given paths");
  return std::make_unique<CorrespondenceDataset>(task, std::move(examples));
}

namespace {

const RegisteredDataset<CorrespondencesOptions> kCorrespondences(
    "correspondences", DataSource::kFiles, "Correspondence files, as `diffsac_prepare` writes them.",
    [](const CorrespondencesOptions& options, std::uint64_t) { return MakeCorrespondences(options); });

}  // namespace

}  // namespace diffsac
