#include <torch/torch.h>

#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "device/test_device.h"
#include "diffsac/core/status.h"
#include "diffsac/estimate/diffsac_estimator.h"
#include "diffsac/problem/tasks.h"
#include "estimate/tiny_network.h"
#include "lab/config/make_estimator.h"
#include "lab/config/yaml.h"
#include "lab/data/synthetic_two_view.h"

namespace diffsac {
namespace {

using testing::TestDeviceName;

const std::string kModels = DIFFSAC_SOURCE_DIR "/models/";

std::unique_ptr<RobustEstimator> Row(const TrainedConfig& trained, const std::string& device,
                                     const std::string& more = "") {
  const std::string row = "{type: " + trained.method + ", checkpoint: '" + trained.checkpoint + "'" + more + "}";
  return MakeEstimator(ConfigFromYaml(row), trained.task, {"", device, 1});
}

std::vector<Example> ExamplesOf(Task task) {
  if (!IsTwoView(task)) return TinyExamples(task, 3);
  SyntheticTwoViewOptions options;
  options.task = task;
  options.matches.num_points = {50, 70};
  options.matches.outlier_ratio = {0.3, 0.3};
  const auto dataset = MakeSyntheticTwoView(options, 3);
  return {dataset->Get(0), dataset->Get(1), dataset->Get(2)};
}

double Worst(const std::vector<float>& a, const std::vector<float>& b) {
  REQUIRE(a.size() == b.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i] != b[i]) worst = std::max<double>(worst, std::abs(a[i] - b[i]));
  return worst;
}

// What the networks say of a batch is the same, and each row estimates something from it.
void CheckRow(const RobustEstimator& there, const RobustEstimator& here, const std::vector<Example>& examples) {
  std::vector<NormalizedProblem> spaces;
  std::vector<const Problem*> problems;
  std::vector<std::uint64_t> seeds;
  for (const auto& example : examples) {
    spaces.emplace_back(example.problem);
    problems.push_back(&example.problem);
    seeds.push_back(seeds.size() + 1);
  }
  const auto a = dynamic_cast<const LearnedEstimator&>(there).Predict(spaces, seeds);
  const auto b = dynamic_cast<const LearnedEstimator&>(here).Predict(spaces, seeds);
  for (std::size_t k = 0; k < a.size(); ++k) {
    CHECK(Worst(a[k].weights, b[k].weights) < 1e-3);
    CHECK(Worst(a[k].confidences, b[k].confidences) < 1e-2);
  }
  for (const Estimate& estimate : there.RunBatch(problems, seeds)) CHECK(estimate.status == Status::kOk);
}

}  // namespace

TEST_CASE("every learned row with a shipped network says on the device what it says on the CPU") {
  int rows = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kModels)) {
    const std::string checkpoint = entry.path().string() + "/model.safetensors";
    if (!std::filesystem::exists(checkpoint)) continue;
    CAPTURE(checkpoint);
    const auto trained = ReadTrainedConfig(checkpoint);
    if (trained.method == "structure_chooser") continue;  // Part of rows, none of its own.
    const std::string engine = trained.method == "diffsac" ? ", engine: libtorch" : "";
    CheckRow(*Row(trained, TestDeviceName(), engine), *Row(trained, "cpu", engine), ExamplesOf(trained.task));
    ++rows;
  }
  CHECK(rows >= 10);
}

TEST_CASE("rows of DiffSAC choose the engine by the device") {
  const auto trained = ReadTrainedConfig(kModels + "line/model.safetensors");
  const auto examples = ExamplesOf(Task::kLine);
  CheckRow(*Row(trained, TestDeviceName()), *Row(trained, "cpu"), examples);
  if (testing::TestDevice().is_cpu()) return;
  CHECK_THROWS_WITH(Row(trained, TestDeviceName(), ", engine: fused"),
                    Catch::Contains("model.safetensors: engine 'fused' runs on the CPU alone"));
}

TEST_CASE("rows that ask the network late, for steps or for both guides work on the device") {
  const auto trained = ReadTrainedConfig(kModels + "line/model.safetensors");
  const auto examples = ExamplesOf(Task::kLine);
  for (const std::string more :
       {", num_diffusion_samples: 0, num_guided_samples: 20", ", num_guided_samples: 5, learned_refit: true",
        ", max_encoded_points: 30", ", max_decoded_points: 20", ", intermediate_sets: true, num_diffusion_samples: 30",
        ", selection: gumbel"}) {
    CAPTURE(more);
    CheckRow(*Row(trained, TestDeviceName(), more), *Row(trained, "cpu", more + ", engine: libtorch"), examples);
  }
  const auto row = Row(trained, TestDeviceName());
  const auto steps = dynamic_cast<const DiffsacEstimator&>(*row).Trace(examples[0].problem, 1);
  REQUIRE(steps);
  CHECK(steps->confidences.size() == steps->timesteps.size());
}

}  // namespace diffsac
