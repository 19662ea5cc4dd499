#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <sstream>

#include "core/temporary_folder.h"
#include "diffsac/core/status.h"
#include "diffsac/estimate/diffsac_estimator.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"
#include "lab/data/synthetic_two_view.h"
#include "lab/files/files.h"
#include "lab/torch/checkpoint.h"
#include "lab/torch/diffsac_network.h"
#include "lab/train/train_options.h"
#include "lab/train/train_request.h"
#include "lab/train/trainer.h"
#include "lab/train/training_source.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

Config TinyConfig(const std::string& task, const std::vector<std::string>& changes = {}) {
  auto config = ConfigFromYaml(R"(
data: {type: synthetic_two_view, num_points: [60, 80], outlier_ratio: [0.1, 0.4]}
network:
  features: {kinds: [coordinates_ratio]}
  denoiser: {kind: pooled, width: 16, encoder_layers: 1, layers: 1}
labels: {top_m: 4, draws: 20}
train: {iterations: 40, batch_size: 4, noise_copies: 2, warmup_iterations: 5, log_every: 1, validate_every: 40,
        learning_rate: 0.005, two_view: {max_points: 40, max_ratios: [1, 0.85], augment: true}}
validation: {problems: 6}
inference: {num_diffusion_samples: 4, selection: gumbel, sampler: {steps: 2}, consensus: {score: msac, final_score: msac}}
)",
                               "tiny.yaml");
  SetYaml(&config, "task=" + task);
  SetYaml(&config, "data.task=" + task);
  for (const auto& change : changes) SetYaml(&config, change);
  return config;
}

TrainingSource SourceOf(const std::string& task, const TwoViewTrainingOptions& two_view, const LabelOptions& labels,
                        const std::string& more = "") {
  const auto data =
      ConfigFromYaml("{type: synthetic_two_view, num_points: 120, outlier_ratio: 0.3, task: " + task + more + "}");
  PointFeaturesOptions features;
  features.kinds = {PointFeature::kRatio};
  return TrainingSource(MakeTrainingParts(data, 1), PointFeatures(features, TaskFromString(task)), {labels, 3},
                        two_view, 1);
}

// How many points of a label are true inliers.
int CorrectOnes(const TrainingItem& item, const std::vector<int>& label) {
  return static_cast<int>(std::count_if(label.begin(), label.end(), [&](int i) { return item.inliers[i] == 1.0f; }));
}

}  // namespace

TEST_CASE("two-view networks train and their checkpoints load for their own task alone") {
  const TemporaryFolder folder;
  for (const std::string task : {"homography", "fundamental", "essential"}) {
    const std::string output = folder / task;
    REQUIRE(Train(OneThread(TinyConfig(task), output), kNever) == TrainOutcome::kFinished);
    const auto losses = Column(Metrics(output), "loss_diffusion");
    REQUIRE(losses.size() == 40);
    double first = 0.0, last = 0.0;
    for (int i = 0; i < 5; ++i) first += losses[i], last += losses[losses.size() - 1 - i];
    CHECK(last < 0.9 * first);
    const auto metrics = Metrics(output);
    CHECK_THAT(metrics[0].at(4), Catch::StartsWith(task == "homography" ? "mAA@20px" : "mAA@10deg"));
    const double accuracy = std::stod(metrics.back().at(4));
    CHECK((accuracy >= 0.0 && accuracy <= 1.0));

    const std::string checkpoint = output + "/checkpoints/last.safetensors";
    const auto network = LoadNetwork(ReadTrainedConfig(checkpoint, "diffsac", TaskFromString(task)), torch::kCPU);
    REQUIRE(network->options.features.kinds.size() == 1);
    CHECK(network->options.features.Has(PointFeature::kRatio));
    const Task other = task == "essential" ? Task::kFundamental : Task::kEssential;
    CHECK_THROWS_WITH(LoadNetwork(ReadTrainedConfig(checkpoint, "diffsac", other), torch::kCPU),
                      Catch::Contains("trained for task '" + task + "'"));
  }
}

TEST_CASE("a subset of the matches keeps the label's points and the number that was asked for") {
  LabelOptions labels;
  labels.top_m = 6;
  labels.draws = 30;
  TwoViewTrainingOptions two_view;
  two_view.max_points = 32;
  for (const std::string task : {"homography", "fundamental", "essential"}) {
    const auto source = SourceOf(task, two_view, labels);
    const int gamma = MinimalSetSize(TaskFromString(task));
    for (std::uint64_t index = 0; index < 6; ++index) {
      const auto item = source.Make(index);
      REQUIRE(item.inliers.size() == 32);
      REQUIRE(item.features.values.rows() == 32);
      REQUIRE(item.labels.size() == 3);
      for (const auto& label : item.labels) CHECK(CorrectOnes(item, label) == gamma);
      CHECK(source.Make(index).features.values == item.features.values);
    }
  }
}

TEST_CASE("only matches of the drawn ratio are kept") {
  LabelOptions labels;
  labels.draws = 30;
  TwoViewTrainingOptions two_view;
  two_view.max_ratios = {0.8};
  const auto source = SourceOf("essential", two_view, labels);
  for (std::uint64_t index = 0; index < 5; ++index) {
    const auto item = source.Make(index);
    CHECK(item.inliers.size() < 120);
    CHECK(item.features.values.col(4).maxCoeff() <= (0.8 - 0.7) / 0.25 + 1e-5);
    REQUIRE(item.labels.size() == 3);
    for (const auto& label : item.labels) CHECK(label.size() == 5);
  }
}

TEST_CASE("thinning leaves few correct matches, of one label at least") {
  LabelOptions labels;
  labels.draws = 30;
  TwoViewTrainingOptions two_view;
  two_view.thinned = 1.0;
  two_view.thinned_to = {0.3, 0.4};
  const auto source = SourceOf("fundamental", two_view, labels);
  for (std::uint64_t index = 0; index < 5; ++index) {
    const auto item = source.Make(index);
    const double correct = static_cast<double>(std::count(item.inliers.begin(), item.inliers.end(), 1.0f));
    const double share = correct / static_cast<double>(item.inliers.size());
    CHECK(share > 0.28);
    CHECK(share < 0.42);
    CHECK(item.features.values.rows() == static_cast<Eigen::Index>(item.inliers.size()));
    REQUIRE(item.labels.size() == 3);
    for (const auto& label : item.labels) CHECK(CorrectOnes(item, label) == 7);
  }
  // Twelve are enough for a label.
  two_view.thinned_to = {0.001, 0.001};
  const auto item = SourceOf("fundamental", two_view, labels).Make(0);
  CHECK(std::count(item.inliers.begin(), item.inliers.end(), 1.0f) == 12);
  // What is harder already stays.
  two_view.thinned_to = {0.99, 0.99};
  CHECK(SourceOf("fundamental", two_view, labels).Make(0).features.values ==
        SourceOf("fundamental", {}, labels).Make(0).features.values);
}

TEST_CASE("the likeliest matches are those that a network is shown") {
  LabelOptions labels;
  labels.draws = 30;
  TwoViewTrainingOptions two_view;
  two_view.max_points = 40;
  const auto any = SourceOf("essential", two_view, labels);
  two_view.likeliest = 40;
  const auto likeliest = SourceOf("essential", two_view, labels);
  double of_any = 0.0, of_likeliest = 0.0;
  for (std::uint64_t index = 0; index < 5; ++index) {
    REQUIRE(likeliest.Make(index).inliers.size() == 40);
    of_any += any.Make(index).features.values.col(4).mean();
    of_likeliest += likeliest.Make(index).features.values.col(4).mean();
  }
  CHECK(of_likeliest < of_any - 1.0);
}

TEST_CASE("the labels of finite data are found once and stay the same") {
  LabelOptions labels;
  labels.draws = 30;
  const auto endless = SourceOf("fundamental", {}, labels);
  const auto finite = SourceOf("fundamental", {}, labels, ", size: 4");
  for (std::uint64_t index = 0; index < 4; ++index) CHECK(finite.Make(index).labels == endless.Make(index).labels);
  // top_m is 1, so the second epoch has the same label.
  for (std::uint64_t index = 0; index < 4; ++index) CHECK(finite.Make(index + 4).labels == finite.Make(index).labels);
}

// Coordinates in the cameras, whatever the pixels.
PointMatrix Normalized(const Problem& problem) {
  return NormalizedCoordinates(problem.points, problem.cameras->K1, problem.cameras->K2);
}

// By how much right matches near each other do not move as their keypoints say, relative to how far: a mean.
double KeypointError(const Problem& problem, const std::vector<std::uint8_t>& inliers) {
  double sum = 0.0;
  int count = 0;
  for (Eigen::Index i = 0; i < problem.points.rows(); ++i)
    for (Eigen::Index j = 0; j < problem.points.rows(); ++j) {
      const Eigen::RowVector4d step = problem.points.row(j) - problem.points.row(i);
      if (i == j || !inliers[i] || !inliers[j] || step.head<2>().norm() > 60.0) continue;
      const auto similarity = problem.scale_rotation_changes.row(i);
      const Eigen::Vector2d moved =
          std::exp(similarity[0]) * (Eigen::Rotation2Dd(similarity[1]) * Eigen::Vector2d(step.head<2>().transpose()));
      sum += (moved - step.tail<2>().transpose()).norm() / step.tail<2>().norm();
      ++count;
    }
  return sum / count;
}

TEST_CASE("augmented points and keypoints are of turned cameras") {
  SyntheticTwoViewOptions options;
  options.task = Task::kEssential;
  options.matches.num_points = 80;
  options.matches.noise_px = options.matches.similarity_noise = options.matches.gross_scale_rotation_changes = 0.0;
  options.matches.scale_rotation_changes = true;
  options.general = options.mixed = options.forward = 0.0;
  options.plane_tilt_deg = 0.0;
  options.baseline = 0.05;
  const auto dataset = MakeSyntheticTwoView(options, 3);
  int exchanged = 0;
  for (std::uint64_t index = 0; index < 8; ++index) {
    const Example example = dataset->Get(index);
    const auto& inliers = example.truth.inliers;
    const Problem after = Augmented(example.problem, Rng(3).Fork("item", index));
    const PointMatrix old = Normalized(example.problem), now = Normalized(after);
    const Eigen::VectorXd before1 = old.leftCols(2).rowwise().norm(), after1 = now.leftCols(2).rowwise().norm();
    const bool swapped = !before1.isApprox(after1, 1e-9);
    exchanged += swapped;
    CHECK(after1.isApprox(swapped ? Eigen::VectorXd(old.rightCols(2).rowwise().norm()) : before1, 1e-9));
    // One essential matrix explains what is right in the new images.
    Eigen::Matrix<double, Eigen::Dynamic, 9> equations(0, 9);
    for (Eigen::Index i = 0; i < now.rows(); ++i) {
      if (!inliers[i]) continue;
      const Eigen::Vector3d x1(now(i, 0), now(i, 1), 1.0), x2(now(i, 2), now(i, 3), 1.0);
      equations.conservativeResize(equations.rows() + 1, Eigen::NoChange);
      for (int k = 0; k < 9; ++k) equations(equations.rows() - 1, k) = x2[k / 3] * x1[k % 3];
    }
    const Eigen::VectorXd values = equations.jacobiSvd().singularValues();
    CHECK(values[8] < 1e-9 * values[0]);
    CHECK(KeypointError(after, inliers) < KeypointError(example.problem, inliers) + 0.05);
  }
  CHECK((exchanged > 0 && exchanged < 8));
}

TEST_CASE("augmentation keeps distances from the principal point and ratios") {
  LabelOptions labels;
  labels.draws = 30;
  TwoViewTrainingOptions augmented;
  augmented.augment = true;
  const auto plain = SourceOf("essential", {}, labels), changed = SourceOf("essential", augmented, labels);
  int swapped = 0;
  for (std::uint64_t index = 0; index < 12; ++index) {
    const auto a = plain.Make(index), b = changed.Make(index);
    CHECK(a.labels == b.labels);
    CHECK(a.features.values.col(4) == b.features.values.col(4));
    const auto radius = [](const TrainingItem& item, int image) {
      return item.features.values.middleCols(2 * image, 2).rowwise().norm().eval();
    };
    const bool same = radius(a, 0).isApprox(radius(b, 0), 1e-4f) && radius(a, 1).isApprox(radius(b, 1), 1e-4f);
    const bool exchanged = radius(a, 0).isApprox(radius(b, 1), 1e-4f) && radius(a, 1).isApprox(radius(b, 0), 1e-4f);
    CHECK((same || exchanged));
    swapped += exchanged;
  }
  CHECK((swapped > 0 && swapped < 12));
}

// A dataset whose descriptors say which image they are of.
class MarkedImages : public Dataset {
 public:
  explicit MarkedImages(std::unique_ptr<Dataset> inner) : inner_(std::move(inner)) {}
  Task task() const override { return inner_->task(); }
  std::int64_t size() const override { return inner_->size(); }
  Example Get(std::uint64_t index) const override {
    Example example = inner_->Get(index);
    example.problem.descriptors = DescriptorMatrix::Zero(example.problem.points.rows(), 4);
    example.problem.descriptors.col(0).setOnes();
    example.problem.descriptors.col(3).setOnes();
    return example;
  }

 private:
  std::unique_ptr<Dataset> inner_;
};

TEST_CASE("augmentation exchanges descriptors with the images") {
  const MarkedImages data(
      MakeDataset(ConfigFromYaml("{type: synthetic_two_view, num_points: 60, task: essential}"), 1));
  PointFeaturesOptions features;
  features.kinds = {PointFeature::kRatio, PointFeature::kDescriptors};
  features.descriptor_size = 2;
  LabelOptions labels;
  labels.draws = 30;
  TwoViewTrainingOptions augmented;
  augmented.augment = true;
  const auto source = [&](const TwoViewTrainingOptions& two_view) {
    return TrainingSource({{std::shared_ptr<const Dataset>(std::shared_ptr<const Dataset>(), &data), 1.0}},
                          PointFeatures(features, Task::kEssential), {labels, 1}, two_view, 1);
  };
  const auto plain = source({}), changed = source(augmented);
  int swapped = 0;
  for (std::uint64_t index = 0; index < 12; ++index) {
    const auto before = plain.Make(index).features.values, after = changed.Make(index).features.values;
    const bool marked = after(0, 5) == 0.0f;  // image 1's descriptor came first, with its first value set
    const auto radius = [](const auto& values, int image) { return values.row(0).segment(2 * image, 2).norm(); };
    CHECK(radius(after, 0) == Approx(radius(before, marked ? 1 : 0)).epsilon(1e-4));
    swapped += marked;
  }
  CHECK((swapped > 0 && swapped < 12));
}

TEST_CASE("a mixture draws its parts by weight") {
  const auto data = ConfigFromYaml(R"(
type: mixture
parts:
  - {weight: 3, type: synthetic_two_view, task: homography, num_points: 30, size: 5}
  - {weight: 1, type: synthetic_two_view, task: homography, num_points: 50}
)");
  LabelOptions labels;
  labels.draws = 5;
  PointFeaturesOptions features;
  features.kinds = {PointFeature::kRatio};
  const TrainingSource source(MakeTrainingParts(data, 1), PointFeatures(features, Task::kHomography), {labels, 1}, {},
                              1);
  int small = 0;
  for (std::uint64_t index = 0; index < 200; ++index) small += source.Make(index).inliers.size() == 30;
  CHECK((small > 125 && small < 175));
  CHECK(WriteTrainingData(ConfigFromYaml(WriteTrainingData(data))) == WriteTrainingData(data));
}

TEST_CASE("every shipped training can be read") {
  // The other folders hold tables, estimators to use, and parts that tables and trainings share.
  const std::set<std::string> others = {"colmap", "data", "pair", "presets", "problems", "tables", "tuning"};
  int count = 0;
  for (const auto& entry : fs::recursive_directory_iterator(DIFFSAC_SOURCE_DIR + std::string("/configs"))) {
    const bool training = others.count(entry.path().parent_path().filename().string()) == 0;
    if (entry.path().extension() != ".yaml" || !training) continue;
    INFO(entry.path().string());
    const Config config = ConfigFromFile(entry.path().string());
    if (config.Has("sets")) continue;  // Image sets, for diffsac_prepare.
    CHECK_NOTHROW(ReadTrainConfig(config));
    const std::string data = WriteTrainingData(config.Sub("data")), name = entry.path().filename().string();
    const bool pairs = name == "essential.yaml" || name == "fundamental.yaml" || name == "homography.yaml";
    if (pairs && entry.path().parent_path().filename() == "configs")
      CHECK_THAT(data, Catch::Contains("refine_truth_px"));
    ++count;
  }
  CHECK(count > 30);
}

TEST_CASE("features are those of all matches, whatever subset is trained on") {
  const auto data =
      ConfigFromYaml("{type: synthetic_two_view, num_points: 120, outlier_ratio: 0.3, task: fundamental}");
  const auto parts = MakeTrainingParts(data, 1);
  PointFeaturesOptions kinds;
  kinds.kinds = {PointFeature::kRatio, PointFeature::kNeighborhood};
  const PointFeatures features(kinds, Task::kFundamental);
  TwoViewTrainingOptions subset;
  subset.max_points = 20;
  const TrainingSource source(parts, features, {{}, 1}, subset, 5);
  for (std::uint64_t index = 0; index < 4; ++index) {
    const TrainingItem item = source.Make(index);
    const FeatureSet all = features.Compute(parts[0].dataset->Get(index).problem, Rng(1));
    REQUIRE(item.features.values.rows() == 20);
    for (int i = 0; i < 20; ++i) {
      const auto distance = (all.values.rowwise() - item.features.values.row(i)).rowwise().norm().minCoeff();
      CHECK(distance < 1e-6f);
    }
  }
}

TEST_CASE("wrong two-view configurations name their place") {
  const TemporaryFolder folder;
  const auto fails = [&](const std::string& task, const std::vector<std::string>& changes, const std::string& message) {
    CHECK_THROWS_WITH(Train(OneThread(TinyConfig(task, changes), folder / "a"), kNever), Catch::Contains(message));
  };
  fails("fundamental", {"model=fundamental9"}, "model=fundamental9");
  fails("essential", {"model=fundamental8"}, "expected essential for task essential");
  fails("essential", {"data.task=homography"}, "homography");
  fails("essential", {"validation.data.task=homography"}, "validation data of task");
  fails("essential", {"data={type: mixture}"}, "parts");
  fails("essential", {"data={type: mixture, parts: [{type: synthetic_two_view, weight: -1}]}"}, "weight");
  fails("essential", {"data={type: mixture, part: 3}"}, "part");
}

}  // namespace diffsac
