#include "lab/train/trainer.h"
#include "lab/config/yaml.h"

#include <catch2/catch.hpp>

#include <filesystem>

#include "core/temporary_folder.h"
#include "diffsac/core/status.h"
#include "diffsac/estimate/diffsac_estimator.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/report_script.h"
#include "lab/files/files.h"
#include "lab/torch/checkpoint.h"
#include "lab/torch/diffsac_network.h"
#include "lab/train/train_request.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

const char* kTiny = R"(
name: tiny
task: line
data: {type: synthetic_line, num_points: [30, 40], outlier_ratio: [0.1, 0.5]}
network:
  features: {kinds: [residual], residual_draws: 20, residual_kept: 4}
  denoiser: {kind: pooled, width: 16, encoder_layers: 1, layers: 1}
train: {iterations: 60, batch_size: 4, noise_copies: 2, warmup_iterations: 5, log_every: 1, validate_every: 30,
        checkpoint_every: 10, learning_rate: 0.003}
validation: {problems: 8, outlier_ratios: [0.2]}
inference: {num_diffusion_samples: 4, sampler: {steps: 2}}
)";

TrainRequest Request(const std::string& output, const std::vector<std::string>& changes = {}) {
  return OneThread(ConfigFromYaml(kTiny, "tiny.yaml"), output, changes);
}

std::shared_ptr<DiffsacNetwork> NetworkOf(const std::string& run, const std::string& checkpoint) {
  const std::string path = run + "/checkpoints/" + checkpoint + ".safetensors";
  return LoadNetwork(ReadTrainedConfig(path, "diffsac", Task::kLine), torch::kCPU);
}

}  // namespace

TEST_CASE("training writes its files, lowers the loss and a checkpoint that evaluates") {
  const TemporaryFolder folder;
  const auto output = folder / "run";
  REQUIRE(Train(Request(output), kNever) == TrainOutcome::kFinished);
  for (const char* name :
       {"config.yaml", "metrics.csv", "checkpoints/last.safetensors", "checkpoints/best.safetensors"})
    CHECK(fs::exists(output + "/" + name));
  CHECK(ReadFile(output + "/metrics.csv")
            .starts_with("iteration,loss_diffusion,loss_inlier,learning_rate,data_wait_share,mAA@0.5deg"));
  const auto losses = Column(Metrics(output), "loss_diffusion");
  REQUIRE(losses.size() == 60);
  CHECK(losses[59] < 0.8 * losses[0]);
  const auto network = NetworkOf(output, "best");
  CHECK(network->options.denoiser.width == 16);
  CHECK(ReadCheckpointInfo(output + "/checkpoints/last.safetensors").iteration == 60);
  const auto facts = NetworkOf(output, "last")->facts;
  CHECK(facts.parameters == CountParameters(*network->module));
  CHECK(facts.samples == 240);
  CHECK(facts.run_samples == 240);
  CHECK(facts.start.empty());
}

TEST_CASE("a run that was stopped and resumed equals one that was not") {
  const TemporaryFolder folder;
  const auto whole = folder / "whole", parts = folder / "parts";
  REQUIRE(Train(Request(whole, {"train.workers=2"}), kNever) == TrainOutcome::kFinished);

  const TrainRequest request = Request(parts, {"train.workers=2"});
  REQUIRE(TrainUntil(request, [&] { return Metrics(parts).size() >= 7; }) == TrainOutcome::kStopped);
  const auto stopped_at = ReadCheckpointInfo(parts + "/checkpoints/last.safetensors").iteration;
  CHECK(stopped_at < 60);
  REQUIRE(Resume(request) == TrainOutcome::kFinished);

  CHECK(Metrics(whole) == Metrics(parts));
  const auto x = NetworkOf(whole, "last");
  const auto y = NetworkOf(parts, "last");
  for (std::size_t i = 0; i < x->module->parameters().size(); ++i)
    CHECK(torch::equal(x->module->parameters()[i], y->module->parameters()[i]));
}

TEST_CASE("the number of data workers changes no byte") {
  const TemporaryFolder folder;
  const auto checkpoint = [&](int workers) {
    const std::string output = folder / std::to_string(workers), number = std::to_string(workers);
    REQUIRE(Train(Request(output, {"train.iterations=20", "train.workers=" + number}), kNever) ==
            TrainOutcome::kFinished);
    return NetworkOf(output, "last")->module->parameters();
  };
  const auto one = checkpoint(1), three = checkpoint(3);
  for (std::size_t i = 0; i < one.size(); ++i) CHECK(torch::equal(one[i], three[i]));
}

TEST_CASE("steps that no row of metrics counts yet are in the checkpoint") {
  const TemporaryFolder folder;
  const auto whole = folder / "whole", parts = folder / "parts";
  const std::vector<std::string> changes = {"train.log_every=9", "train.iterations=30"};
  REQUIRE(Train(Request(whole, changes), kNever) == TrainOutcome::kFinished);
  const auto checkpoint = parts + "/checkpoints/last.safetensors";
  // The checkpoint of step 10 is one step after a row.
  REQUIRE(TrainUntil(Request(parts, changes), [&] {
            return fs::exists(checkpoint) && ReadCheckpointInfo(checkpoint).iteration >= 10;
          }) == TrainOutcome::kStopped);
  REQUIRE(Resume(Request(parts, changes)) == TrainOutcome::kFinished);
  CHECK(Metrics(whole) == Metrics(parts));
  CHECK(ReadFile(whole + "/checkpoints/last.safetensors") == ReadFile(parts + "/checkpoints/last.safetensors"));

  // Killed between the last checkpoint and the report: resuming has no step to do, and still leaves what a run leaves.
  fs::remove(parts + "/report.html");
  REQUIRE(Resume(Request(parts, changes)) == TrainOutcome::kFinished);
  CHECK(fs::exists(parts + "/report.html") == HasReportPython());
}

// Ctrl-C was obeyed only after the whole validation.
TEST_CASE("a training that is stopped in a validation goes on with it") {
  const TemporaryFolder folder;
  const auto whole = folder / "whole", parts = folder / "parts";
  const std::vector<std::string> changes = {"train.iterations=10", "train.validate_every=5",
                                            "validation.problems=1500"};
  REQUIRE(Train(Request(whole, changes), kNever) == TrainOutcome::kFinished);
  // Four rows of losses: the fifth step waits for its validation.
  REQUIRE(TrainUntil(Request(parts, changes), [&] { return Metrics(parts).size() >= 5; }) == TrainOutcome::kStopped);
  CHECK(ReadCheckpointInfo(parts + "/checkpoints/last.safetensors").iteration <= 5);
  CHECK(Metrics(parts).size() == 5);
  CHECK_FALSE(fs::exists(parts + "/checkpoints/best.safetensors"));
  REQUIRE(Resume(Request(parts, changes)) == TrainOutcome::kFinished);
  CHECK(Metrics(whole) == Metrics(parts));
  CHECK(ReadFile(whole + "/checkpoints/best.safetensors") == ReadFile(parts + "/checkpoints/best.safetensors"));
}

// They were not in metrics.csv, the curve and the report unless a row of losses was due at the same step.
TEST_CASE("validations between two rows of losses are in metrics.csv and the report") {
  const TemporaryFolder folder;
  const auto output = folder / "run";
  REQUIRE(Train(Request(output, {"train.iterations=30", "train.log_every=20", "train.validate_every=12"}), kNever) ==
          TrainOutcome::kFinished);
  const auto rows = Metrics(output);
  REQUIRE(rows.size() == 5);
  const std::vector<std::string> steps = {"12", "20", "24", "30"};
  for (std::size_t i = 0; i < steps.size(); ++i) {
    CHECK(rows[i + 1].front() == steps[i]);
    CHECK(rows[i + 1].back().empty() == (steps[i] == "20"));  // Where it was not validated.
    CHECK(!rows[i + 1][1].empty());                           // Every row has losses.
  }
  if (!HasReportPython()) return;
  const std::string report = ReadFile(output + "/report.html");
  for (const char* step : {"data-value=\"30\">30</td>", "data-value=\"3\">3</td>"})
    CHECK_THAT(report, Catch::Contains("mAA@0.5deg_outliers_0.2") && Catch::Contains(step));
}

TEST_CASE("validations before the first row of losses leave a picture") {
  const TemporaryFolder folder;
  const auto output = folder / "run";
  const std::vector<std::string> changes = {"train.iterations=100000", "train.log_every=100000",
                                            "train.validate_every=5"};
  REQUIRE(TrainUntil(Request(output, changes), [&] { return fs::exists(output + "/checkpoints/best.safetensors"); }) ==
          TrainOutcome::kStopped);
  CHECK(fs::exists(output + "/training_curve.png") == HasReportPython());
}

TEST_CASE("a loss that is not finite stops with the last good checkpoint kept") {
  const TemporaryFolder folder;
  const auto output = folder / "run";
  CHECK_THROWS_WITH(
      Train(Request(output, {"train.learning_rate=1e37", "train.checkpoint_every=1", "train.warmup_iterations=0"}),
            kNever),
      Catch::Contains("not finite") && Catch::Contains("last.safetensors"));
  const auto path = output + "/checkpoints/last.safetensors";
  REQUIRE(fs::exists(path));
  CHECK(ReadCheckpointInfo(path).iteration >= 1);
}

TEST_CASE("resuming with another configuration or without a checkpoint is refused") {
  const TemporaryFolder folder;
  const auto output = folder / "run";
  std::atomic<bool> now{true};
  REQUIRE(Train(Request(output), now) == TrainOutcome::kStopped);
  CHECK_THROWS_WITH(Resume(Request(output, {"train.batch_size=5"})),
                    Catch::Contains("another configuration") && Catch::Contains("train.batch_size: 4, now 5"));
  CHECK_THROWS_WITH(Resume(Request(folder / "nothing")), Catch::Contains("no such checkpoint"));
}

TEST_CASE("wrong configurations name their place") {
  const TemporaryFolder folder;
  CHECK_THROWS_WITH(Train(Request(folder / "a", {"train.batch_sise=5"}), kNever), Catch::Contains("batch_size"));
  CHECK_THROWS_WITH(Train(Request(folder / "a", {"data.type=synthetic_plane"}), kNever), Catch::Contains("plane"));
  CHECK_THROWS_WITH(Train(Request(folder / "a", {"network.denoiser.width=15"}), kNever), Catch::Contains("even"));
}

TEST_CASE("the learning rate warms up linearly and falls to 0 on a half cosine") {
  CHECK(LearningRate(0, 10, 110, 1.0) == Approx(0.1));
  CHECK(LearningRate(9, 10, 110, 1.0) == Approx(1.0));
  CHECK(LearningRate(10, 10, 110, 1.0) == Approx(1.0));
  CHECK(LearningRate(60, 10, 110, 1.0) == Approx(0.5));
  CHECK(LearningRate(110, 10, 110, 1.0) == Approx(0.0).margin(1e-12));
  for (int i = 11; i < 110; ++i) CHECK(LearningRate(i, 10, 110, 1.0) < LearningRate(i - 1, 10, 110, 1.0));
  CHECK(LearningRate(0, 0, 1, 2.0) == Approx(2.0));
}

}  // namespace diffsac
