#include "diffsac/guidance/engine/cpu_denoiser.h"
#include "lab/config/yaml.h"

#include <torch/torch.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/temporary_folder.h"
#include "diffsac/core/status.h"
#include "diffsac/estimate/diffsac_model.h"
#include "estimate/tiny_network.h"
#include "lab/config/make_estimator.h"
#include "lab/torch/checkpoint.h"

using namespace diffsac;

namespace {

/// Stated by CpuDenoiser.
constexpr double kTolerance = 1e-4;

/// A checkpoint of a network with such options, whose weights are waves.
std::string Saved(const TemporaryFolder& folder, const NetworkOptions& options) {
  const auto network = TinyNetwork(Task::kPlane, options);
  ExponentialMovingAverage average(*network->module, 0.5);
  const std::string path = folder.path() + "/model.safetensors";
  CheckpointInfo info{"diffsac", "plane", "network: " + WriteYaml(options), "test"};
  info.config = "{}";
  SaveCheckpoint(path, info, *network->module, average, nullptr);
  return path;
}

struct Outputs {
  torch::Tensor weights, raw;
};

double WorstDifference(const torch::Tensor& a, const std::vector<float>& b) {
  return (a.flatten() - torch::tensor(b)).abs().max().item<double>();
}

/// Both engines on the same features: 70 points, 3 copies.
void CheckSame(const NetworkOptions& options) {
  const TemporaryFolder folder;
  SafetensorsFile file(Saved(folder, options));
  const auto network = TinyNetwork(Task::kPlane, options);
  const auto examples = TinyExamples(Task::kPlane, 1);
  const FeatureSet features = network->features.Compute(examples[0].problem, Rng(4));
  const int points = static_cast<int>(features.values.rows()), copies = 3;

  const torch::NoGradGuard no_grad;
  const FeatureSet* one = &features;
  const Context context = network->module->Encode(MakePointBatch({&one, 1}));
  torch::manual_seed(1);
  const auto c_t = torch::randn({1, copies, points});
  const auto raw = network->module->Denoise(context, c_t, torch::full({1, 1}, 37.5));

  const KernelList kernels = AvailableKernels();
  for (int i = 0; i < kernels.count; ++i) {
    INFO(kernels.all[i]->name);
    const FeatureColumns columns(network->features.width(), network->features.first_residual());
    const CpuDenoiser fused(options, columns, &file, *kernels.all[i]);
    CHECK(fused.parameters() == CountParameters(*network->module));
    CpuDenoiser::Workspace work;
    fused.Encode(features.values.data(), points, &work);
    CHECK(WorstDifference(context.points, work.context) < kTolerance);
    if (options.denoiser.inlier_head) CHECK(WorstDifference(context.inlier_logits, work.logits) < kTolerance);
    std::vector<float> out(static_cast<std::size_t>(copies) * points);
    fused.Denoise(c_t.data_ptr<float>(), copies, 37.5, &work, out.data());
    CHECK(WorstDifference(raw, out) < kTolerance * (1.0 + raw.abs().max().item<double>()));
  }
}

}  // namespace

TEST_CASE("the fused network says what LibTorch's says, with every kernel and for every option that it has") {
  SECTION("tiny") { CheckSame(TinyOptions()); }
  SECTION("the shipped width and depth") {
    NetworkOptions options = TinyOptions();
    options.denoiser.width = 64;
    options.denoiser.encoder_layers = 4;
    options.denoiser.layers = 2;
    CheckSame(options);
  }
  SECTION("no encoder, no head") {
    NetworkOptions options = TinyOptions();
    options.denoiser.encoder_layers = 0;
    options.denoiser.inlier_head = false;
    CheckSame(options);
  }
  SECTION("relation") {
    NetworkOptions options = TinyOptions();
    options.denoiser.relation = true;
    CheckSame(options);
  }
}

TEST_CASE("what the fused network has not is said in words") {
  NetworkOptions options = TinyOptions();
  CHECK(CpuDenoiser::Missing(options).empty());
  options.denoiser.kind = DenoiserKind::kDgcnn;
  CHECK(CpuDenoiser::Missing(options) == "network.denoiser.kind: dgcnn");
  options = TinyOptions();
  options.denoiser.width = 24;
  CHECK(CpuDenoiser::Missing(options).find("network.denoiser.width: 24") == 0);
}

TEST_CASE("weights of another architecture are refused with the tensor's name") {
  const TemporaryFolder folder;
  SafetensorsFile file(Saved(folder, TinyOptions()));
  NetworkOptions deeper = TinyOptions();
  deeper.denoiser.layers = 2;
  const auto network = TinyNetwork(Task::kPlane);
  const FeatureColumns columns(network->features.width(), network->features.first_residual());
  CHECK_THROWS_WITH(CpuDenoiser(deeper, columns, &file), Catch::Contains("average.decoder1"));
  NetworkOptions shallower = TinyOptions();
  shallower.denoiser.encoder_layers = 0;
  shallower.denoiser.inlier_head = false;
  CHECK_THROWS_WITH(CpuDenoiser(shallower, columns, &file), Catch::Contains("averaged weights"));
}

TEST_CASE("rows with either engine estimate the same from shipped networks") {
  for (const Task task : {Task::kLine, Task::kPlane}) {
    const std::string name = ToString(task), checkpoint = DIFFSAC_SOURCE_DIR "/models/" + name + "/model.safetensors";
    const auto make = [&](const std::string& engine) {
      return MakeEstimator(ConfigFromYaml("{type: diffsac, checkpoint: '" + checkpoint + "', engine: " + engine + "}"),
                           task, {});
    };
    const auto fused = make("fused"), libtorch = make("libtorch");
    int same = 0, count = 0;
    for (const Example& example : TinyExamples(task, 10)) {
      const Estimate a = fused->Run(example.problem, 7), b = libtorch->Run(example.problem, 7);
      REQUIRE(a.inlier_probabilities.size() == b.inlier_probabilities.size());
      double worst = 0.0;
      for (std::size_t i = 0; i < a.inlier_probabilities.size(); ++i)
        worst = std::max<double>(worst, std::abs(a.inlier_probabilities[i] - b.inlier_probabilities[i]));
      CHECK(worst < kTolerance);
      same += a.inliers == b.inliers ? 1 : 0;
      ++count;
    }
    CHECK(same >= count - 1);  // rounding may swap two points of nearly equal confidence
  }
}

TEST_CASE("an engine that a row asks for in vain is an error that says why") {
  const std::string line = DIFFSAC_SOURCE_DIR "/models/line/model.safetensors";
  const auto make = [&](const std::string& engine, const std::string& device) {
    EstimatorContext context;
    context.device = device;
    return MakeEstimator(ConfigFromYaml("{type: diffsac, checkpoint: '" + line + "', engine: " + engine + "}"),
                         Task::kLine, context);
  };
  CHECK_NOTHROW(make("auto", "auto"));
  CHECK_THROWS_WITH(make("quick", "cpu"), Catch::Contains("fused"));
  CHECK_THROWS_WITH(make("fused", "tpu"), Catch::Contains("device 'tpu'"));
}
