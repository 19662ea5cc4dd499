#include "lab/train/training_folder.h"
#include "lab/config/yaml.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "core/temporary_folder.h"
#include "lab/config/run_directory.h"
#include "lab/files/files.h"
#include "lab/torch/checkpoint.h"
#include "train_request.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;

constexpr const char* kLine = R"(
name: line
task: line
data: {type: synthetic_line, num_points: 30, outlier_ratio: 0.3}
network:
  features: {kinds: [residual], residual_draws: 20, residual_kept: 4}
  denoiser: {kind: pooled, width: 8, encoder_layers: 1, layers: 1}
train: {iterations: 4, batch_size: 2, noise_copies: 1, warmup_iterations: 1, log_every: 2, validate_every: 2,
        checkpoint_every: 2}
validation: {problems: 2, outlier_ratios: [0.2]}
inference: {num_diffusion_samples: 2, sampler: {steps: 1}}
)";

/// A training of a few steps in a folder, and what others ask of that folder.
class Run {
 public:
  Run() { REQUIRE(Train(Request(), kNever) == TrainOutcome::kFinished); }

  TrainRequest Request(const std::vector<std::string>& changes = {}) const {
    return OneThread(ConfigFromYaml(kLine, "line.yaml"), path(), changes);
  }
  TrainRequest Plane() const { return Request({"name=plane", "task=plane", "data.type=synthetic_plane"}); }
  TrainRequest Resumed(const std::vector<std::string>& changes = {}) const {
    TrainRequest request = Request(changes);
    request.resume = true;
    return request;
  }
  TrainRequest ResumedAlone(const std::vector<std::string>& changes = {}) const {
    TrainRequest request = OneThread(ConfigurationToResume(path()), path(), changes);
    request.resume = true;
    return request;
  }
  std::string path() const { return folder_ / "run"; }
  std::string File(const std::string& name) const { return path() + "/" + name; }
  std::string Text(const std::string& name) const { return ReadFile(File(name)); }
  CheckpointInfo Last() const { return ReadCheckpointInfo(File("checkpoints/last.safetensors")); }

 private:
  TemporaryFolder folder_;
};

constexpr const char* kFiles[] = {"checkpoints/best.safetensors", "checkpoints/last.safetensors", "config.yaml",
                                  "metrics.csv", "report.html"};

std::vector<std::string> Texts(const Run& run) {
  std::vector<std::string> texts;
  for (const char* name : kFiles) texts.push_back(run.Text(name));
  return texts;
}

}  // namespace

TEST_CASE("a training over another training is refused, and changes none of its files") {
  const Run run;
  const auto before = Texts(run);
  const auto check_refused = [&](const auto& start) {
    CHECK_THROWS_WITH(start(), Contains(run.path() + ": holds a training already (checkpoints/best.safetensors") &&
                                   Contains("--resume goes on") && Contains("--overwrite"));
  };
  check_refused([&] { Train(run.Request(), kNever); });
  check_refused([&] { Train(run.Plane(), kNever); });
  check_refused([&] { CheckStart(run.Plane()); });
  CHECK(Texts(run) == before);
}

TEST_CASE("overwriting removes all that the earlier training left") {
  const Run run;
  WriteFileAtomically(run.File("notes.txt"), "mine");
  TrainRequest plane = run.Plane();
  plane.overwrite = true;
  const std::atomic<bool> at_once{true};
  REQUIRE(Train(plane, at_once) == TrainOutcome::kStopped);
  CHECK_FALSE(fs::exists(run.File("checkpoints/best.safetensors")));  // A line's would pass for the plane's.
  CHECK_FALSE(fs::exists(run.File("training_curve.png")));
  CHECK(run.Text("metrics.csv").find("\n0") == std::string::npos);
  CHECK(run.Last().task == "plane");
  CHECK(run.Last().iteration == 0);
  CHECK(run.Text("notes.txt") == "mine");
}

TEST_CASE("a start that is overwriting and fails leaves the earlier training") {
  const Run run;
  const auto before = Texts(run);
  TrainRequest broken = run.Request({"task=plane"});  // Of lines.
  broken.overwrite = true;
  CHECK_THROWS_WITH(Train(broken, kNever), Contains("data of task 'line'"));
  broken = run.Request({"train.start_from=nowhere.safetensors"});
  broken.overwrite = true;
  CHECK_THROWS_WITH(Train(broken, kNever), Contains("nowhere.safetensors"));
  CHECK(Texts(run) == before);
}

TEST_CASE("folders without a training that would be lost are trained in") {
  const TemporaryFolder folder;
  const auto request = OneThread(ConfigFromYaml(kLine, "line.yaml"), folder.path());
  CHECK_NOTHROW(CheckStart(request));
  // What a start that came to nothing leaves, and what is nobody's.
  const RunDirectory directory(folder.path(), "diffsac_train", kLine, 1);
  fs::create_directory(folder / "checkpoints");
  for (const char* name : {"log.txt", "slurm.log", "checkpoints/.last.safetensors.tmp-1"})
    WriteFileAtomically(folder / name, "x");
  CHECK_NOTHROW(CheckStart(request));
  CHECK_NOTHROW(CheckStart(OneThread(ConfigFromYaml(kLine, "line.yaml"), folder / "not/there")));
}

TEST_CASE("folders of evaluations and of shipped networks are not trained in") {
  const TemporaryFolder folder;
  auto request = OneThread(ConfigFromYaml(kLine, "line.yaml"), folder.path());
  {
    const RunDirectory directory(folder.path(), "diffsac_eval", "name: x\n", 1);
    CHECK_THROWS_WITH(CheckStart(request), Contains("holds files of diffsac_eval (config.yaml)"));
  }
  const RunDirectory directory(folder.path(), "diffsac_train", kLine, 1);
  WriteFileAtomically(folder / "model.safetensors", "x");
  CHECK_THROWS_WITH(CheckStart(request), Contains("holds a training already (model.safetensors)") &&
                                             !Contains("--resume"));  // Nothing to go on with.
  request.overwrite = true;
  CHECK_NOTHROW(CheckStart(request));
}

TEST_CASE("a resumed training reads its own configuration") {
  const Run run;
  CHECK(WriteTrainConfig(run.ResumedAlone().options) == WriteTrainConfig(run.Request().options));
  // Where another program's stands there, what the checkpoint says.
  WriteFileAtomically(run.File("config.yaml"), "# program: diffsac_eval\nname: other\n");
  CHECK(WriteTrainConfig(run.ResumedAlone().options) == WriteTrainConfig(run.Request().options));
  fs::remove(run.File("config.yaml"));
  CHECK(WriteTrainConfig(run.ResumedAlone().options) == WriteTrainConfig(run.Request().options));
  const TemporaryFolder empty;
  CHECK_THROWS_WITH(ConfigurationToResume(empty.path()),
                    Contains("checkpoints/last.safetensors: no such checkpoint, so there is no training to resume"));
}

TEST_CASE("keys that a resumed training does not have so are named with both values") {
  const Run run;
  const auto before = Texts(run);
  const std::vector<std::string> changes = {"train.batch_size=3", "train.learning_rate=0.1"};
  const std::string refused =
      "its training has another configuration (train.batch_size: 2, now 3; train.learning_rate: 1.0e-04, now 0.1)";
  CHECK_THROWS_WITH(Train(run.Resumed(changes), kNever), Contains(refused));
  CHECK_THROWS_WITH(CheckStart(run.ResumedAlone(changes)), Contains(refused));
  CHECK_THROWS_WITH(CheckStart(run.Resumed({"train.seed=9"})), Contains("train.seed: 1, now 9"));
  CHECK(Texts(run) == before);
}

TEST_CASE("iterations of a resumed training grow") {
  const Run run;
  CHECK_THROWS_WITH(CheckStart(run.Resumed({"train.iterations=3"})),
                    Contains("4 iterations are done (train.iterations: 4, now 3); expected more than those"));
  REQUIRE(Train(run.ResumedAlone({"train.iterations=6", "train.log_every=1"}), kNever) == TrainOutcome::kFinished);
  CHECK(run.Last().iteration == 6);
  CHECK(ReadTrainConfig(ConfigFromYaml(run.Last().config, "")).train.iterations == 6);
  CHECK_THAT(run.Text("config.yaml"), Contains("iterations: 6"));
  CHECK_THAT(run.Text("metrics.csv"), Contains("\n4,") && Contains("\n5,") && Contains("\n6,"));
  // Finished: what it left stays.
  const auto before = run.Text("checkpoints/last.safetensors");
  REQUIRE(Train(run.ResumedAlone(), kNever) == TrainOutcome::kFinished);
  CHECK(run.Text("checkpoints/last.safetensors") == before);
}

TEST_CASE("a training that started from another network is resumed without it") {
  const Run first;
  const TemporaryFolder folder;
  const std::string start = folder / "start.safetensors";
  fs::copy_file(first.File("checkpoints/best.safetensors"), start);
  TrainRequest request = first.Request({"train.start_from=" + start});
  request.output = folder / "run";
  const std::atomic<bool> at_once{true};
  REQUIRE(Train(request, at_once) == TrainOutcome::kStopped);
  fs::remove(start);
  request.resume = true;
  CHECK(Train(request, kNever) == TrainOutcome::kFinished);
}

}  // namespace diffsac
