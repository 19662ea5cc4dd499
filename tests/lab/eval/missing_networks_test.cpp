#include "lab/config/yaml.h"
#include "lab/eval/selection.h"

#include <catch2/catch.hpp>

#include <filesystem>

#include "diffsac/guidance/engine/checkpoint_info.h"
#include "lab/eval/eval_fixtures.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

TEST_CASE("a missing network is made by the training of its name, which says what it reads") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.File("configs/tables"));
  WriteFileAtomically(folder.File("configs/tables/net.yaml"), "name: net\nmethods: []\n");
  WriteFileAtomically(folder.File("configs/of_net.yaml"),
                      "name: net\ntrain: {iterations: 1}\ndata: {parts: [{paths: [runs/pairs/train/fox, data/x]}]}\n");
  const ExperimentOptions experiment = ReadExperiment(ConfigFromYaml(R"(
data: {type: correspondences, task: line, paths: [runs/pairs/test]}
methods:
  a: {type: diffsac, checkpoint: runs/net/checkpoints/best.safetensors}
  b: {type: diffsac, checkpoint: runs/nobody/checkpoints/best.safetensors}
  c: {type: diffsac, checkpoint: elsewhere/model.safetensors}
)"));
  const auto networks = MissingNetworks(experiment, folder.File("configs"));
  REQUIRE(networks.size() == 2);
  CHECK(networks[0].name == "net");
  CHECK(networks[0].config == folder.File("configs/of_net.yaml"));
  CHECK(networks[1].name == "nobody");
  CHECK(networks[1].config.empty());
  CHECK(NeededFolders(experiment, true, folder.File("configs")) ==
        std::vector<std::string>{"runs/pairs/test", "runs/pairs/train/fox"});
  CHECK(NeededFolders(experiment, false, folder.File("configs")) == std::vector<std::string>{"runs/pairs/test"});
  const std::atomic<bool> stop{false};
  CHECK(TrainNetworks({networks[1]}, "cpu", stop));  // Only a warning.
}

/// A checkpoint of a training of ten steps.
void WriteCheckpointAt(std::int64_t iteration, const std::string& path, const std::string& iterations = "10") {
  SafetensorsWriter writer;
  WriteInfo({"diffsac", "line", "train: {iterations: " + iterations + "}\n", "none", iteration, 1, -1.0}, &writer);
  WriteFileAtomically(path, writer.Content());
}

TEST_CASE("regression: the best network so far of a training that was killed passed for that of a finished one") {
  const TemporaryFolder folder;
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  std::filesystem::create_directories("runs/net/checkpoints");
  std::filesystem::create_directories("configs");
  WriteFileAtomically("configs/net.yaml", "name: net\ntrain: {iterations: 10}\n");
  const ExperimentOptions experiment =
      ReadExperiment(ConfigFromYaml("data: {type: synthetic_line}\nmethods: {a: {type: diffsac, checkpoint: "
                                    "runs/net/checkpoints/best.safetensors}}\n"));
  const std::string best = "runs/net/checkpoints/best.safetensors", last = "runs/net/checkpoints/last.safetensors";
  const auto missing = [&] { return MissingNetworks(experiment, "configs").size(); };
  CHECK(missing() == 1);
  WriteCheckpointAt(5, best);
  CHECK(missing() == 0);  // Alone it is somebody's who copied it.
  WriteCheckpointAt(5, last);
  CHECK(missing() == 1);
  WriteCheckpointAt(10, last);
  CHECK(missing() == 0);
  WriteCheckpointAt(5, last, "many");
  CHECK_THROWS_WITH(missing(), Catch::Contains("last.safetensors") && Catch::Contains("expected a number"));
  std::filesystem::current_path(before);
}

TEST_CASE("missing networks are trained on the device that is asked for") {
  const TemporaryFolder folder;
  const MissingNetwork network{"net", folder.File("runs/net/checkpoints/best.safetensors"), "net.yaml"};
  auto command = TrainingCommand(network, "cuda:1");
  command.erase(command.begin());
  CHECK(command ==
        std::vector<std::string>{"--config", "net.yaml", "--output", folder.File("runs/net"), "--device", "cuda:1"});
}

TEST_CASE("a network of another seed is made by the same training with that seed") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.File("configs"));
  WriteFileAtomically(folder.File("configs/net.yaml"), "name: net\ntrain: {iterations: 1}\n");
  const ExperimentOptions experiment = ReadExperiment(ConfigFromYaml(R"(
seed: 3
data: {type: correspondences, task: line, paths: [runs/pairs/test]}
methods: {a: {type: diffsac, checkpoint: "runs/net_seed_${seed}/checkpoints/best.safetensors"}}
)"));
  const auto networks = MissingNetworks(experiment, folder.File("configs"));
  REQUIRE(networks.size() == 1);
  CHECK(networks[0].config == folder.File("configs/net.yaml"));
  const auto command = TrainingCommand(networks[0], "cpu");
  CHECK(std::vector<std::string>(command.end() - 2, command.end()) ==
        std::vector<std::string>{"--set", "train.seed=3"});
}

}  // namespace
}  // namespace diffsac
