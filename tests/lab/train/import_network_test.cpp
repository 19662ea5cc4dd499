#include "lab/train/import_network.h"
#include "lab/config/yaml.h"

#include <catch2/catch.hpp>

#include "core/temporary_folder.h"
#include "diffsac/core/safetensors.h"
#include "diffsac/core/status.h"
#include "diffsac/problem/tasks.h"
#include "lab/torch/ng_ransac.h"
#include "lab/torch/test_networks.h"
#include "train_request.h"

namespace diffsac {
namespace {

using Catch::Contains;

// Made by `scripts/peers/import_ng_ransac.py --task essential --random 8,2`: random weights, and what the official
// program's layers say of 60 matches with them.
const std::string kFile = DIFFSAC_SOURCE_DIR "/tests/lab/train/ng_ransac_weights.safetensors";

constexpr const char* kConfig = R"(
name: official
method: ng_ransac
task: essential
data: {type: synthetic_two_view, task: essential}
network: {features: {kinds: [coordinates_ratio]}, width: 8, blocks: 2, output: sigmoid}
)";

std::string Import(const TemporaryFolder& folder, const std::vector<std::string>& changes = {}) {
  ImportNetwork(OneThread(ConfigFromYaml(kConfig, "test.yaml"), folder.path(), changes), kFile);
  return folder.File("checkpoints/best.safetensors");
}

constexpr int kMatches = 60, kColumns = 5;

struct Example {
  FeatureSet features;
  torch::Tensor log_weights = torch::empty({kMatches});
};

Example ReadExample() {
  SafetensorsFile file(kFile);
  Example example;
  example.features.values.resize(kMatches, kColumns);
  file.Read("example.features", {kMatches, kColumns}, std::span(example.features.values.data(), kMatches * kColumns));
  file.Read("example.log_weights", {kMatches}, std::span(example.log_weights.data_ptr<float>(), kMatches));
  return example;
}

}  // namespace

TEST_CASE("an imported network of NG-RANSAC says what the official layers say") {
  const TemporaryFolder folder;
  const TrainedConfig trained = ReadTrainedConfig(Import(folder), "ng_ransac", Task::kEssential);
  const auto weights = LoadLearnedWeights<NgRansacNetwork>(trained, torch::kCPU);
  const auto [set, expected] = ReadExample();
  const torch::NoGradGuard no_grad;
  CHECK(expected.std().item<float>() > 0.1f);
  CHECK(MaxDifference(weights->module->Weights(BatchOf({set})).log()[0], expected) < 1e-5);
  // With a longer problem beside it.
  const auto padded = weights->module->Weights(BatchOf({set, RandomFeatures(90, 5, Rng(1))}));
  CHECK(MaxDifference(padded[0].slice(0, 0, kMatches).log(), expected) < 1e-5);
}

TEST_CASE("weights are imported over a training only where that is said") {
  const TemporaryFolder folder;
  const std::string best = Import(folder);
  CHECK_THROWS_WITH(Import(folder), Contains("holds a training already (checkpoints/best.safetensors)"));
  TrainRequest request = OneThread(ConfigFromYaml(kConfig, "test.yaml"), folder.path(), {"name=other"});
  request.overwrite = true;
  ImportNetwork(request, kFile);
  CHECK_THAT(ReadCheckpointInfo(best).config, Contains("\"name\":\"other\""));
}

TEST_CASE("weights of another network, task or method are refused in one line") {
  const TemporaryFolder folder;
  CHECK_THROWS_WITH(
      Import(folder, {"task=fundamental", "data.task=fundamental"}),
      Contains("ng_ransac_weights.safetensors: weights for task 'essential'") && Contains("'fundamental'"));
  CHECK_THROWS_WITH(Import(folder, {"network.width=16"}), Contains("is [8, 5], expected [16, 5]"));
  CHECK_THROWS_WITH(Import(folder, {"network.blocks=3"}), Contains("no tensor 'network.block2.first.weight'"));
  CHECK_THROWS_WITH(Import(folder, {"network.blocks=1"}), Contains("holds 20 tensors 'network.*', expected 12"));
  CHECK_THROWS_WITH(Import(folder, {"network.features.kinds=[coordinates]"}), Contains("is [8, 5], expected [8, 4]"));
  const Config clnet =
      ConfigFromYaml("method: clnet\ntask: essential\ndata: {type: synthetic_two_view, task: essential}\n");
  CHECK_THROWS_WITH(ImportNetwork(OneThread(clnet, folder.path()), kFile), Contains("weights of method 'ng_ransac'"));
}

}  // namespace diffsac
