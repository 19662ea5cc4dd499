// Checkpoints: the safetensors reader, the texts about a network, its configuration, and the network itself where it
// runs without LibTorch.

#include <filesystem>

#include "diffsac/core/safetensors.h"
#include "diffsac/estimators/diffsac_engine.h"
#include "diffsac/network/engine/checkpoint_info.h"
#include "fuzz/fuzz_target.h"

namespace diffsac::testing {
namespace {

constexpr const char* kConfig =
    "method: diffsac\ntask: line\nnetwork:\n  features: {kinds: [coordinates]}\n"
    "  denoiser: {kind: pooled, width: 16, encoder_layers: 1, layers: 1}\n"
    "train: {iterations: 10, batch_size: 4}\n";

/// As FusedDenoiser reads them: the least network there is.
void AddNetwork(SafetensorsWriter* writer) {
  constexpr std::int64_t kWidth = 16, kHeads = 4;
  const auto add = [&](const std::string& name, const std::vector<std::int64_t>& shape) {
    std::int64_t size = 1;
    for (const std::int64_t extent : shape) size *= extent;
    writer->Add(kAverageTensors + name, shape, std::vector<float>(static_cast<std::size_t>(size), 0.25f));
  };
  const auto linear = [&](const std::string& name, std::int64_t in, std::int64_t out) {
    add(name + ".weight", {out, in});
    add(name + ".bias", {out});
  };
  const auto norm = [&](const std::string& name) {
    add(name + ".weight", {kWidth});
    add(name + ".bias", {kWidth});
  };
  linear("input_points", 2, kWidth);
  for (const std::string block : {"encoder0", "decoder0"}) {
    norm(block + ".norm");
    linear(block + ".attention", kWidth, kHeads);
    linear(block + ".set", (2 + kHeads) * kWidth, 2 * kWidth);
    linear(block + ".point", kWidth, 2 * kWidth);
    linear(block + ".output", 2 * kWidth, kWidth);
  }
  for (const char* name : {"ln_encoder", "ln_post"}) norm(name);
  linear("input_confidence", 1, kWidth);
  linear("time_hidden", kWidth, kWidth);
  linear("time_output", kWidth, kWidth);
  linear("output_proj", kWidth, 1);
}

std::string Checkpoint(bool network) {
  SafetensorsWriter writer;
  WriteInfo({.method = "diffsac", .task = "line", .config = kConfig, .git_revision = "0", .iteration = 3, .seed = 1},
            &writer);
  WriteLossSums({.sums = {0.5, 0.25}, .steps = 2}, &writer);
  const std::vector<float> values = {1.0f, 2.0f};
  const std::vector<std::int64_t> step = {3};
  if (network) {
    AddNetwork(&writer);
  } else {
    writer.Add("network.a.weight", {2}, values);
    writer.Add("optimizer.step.a.weight", {1}, step);
  }
  return writer.Content();
}

void ReadTensors(const std::string& path) {
  SafetensorsFile file(path);
  for (const auto& [name, tensor] : file.tensors()) {
    std::size_t count = 1;
    for (const std::int64_t size : tensor.shape) count *= static_cast<std::size_t>(size);
    if (tensor.type == "F32") {
      std::vector<float> values(count);
      file.Read(name, tensor.shape, values);
    } else if (tensor.type == "I64") {
      std::vector<std::int64_t> values(count);
      file.Read(name, tensor.shape, values);
    }
  }
}

}  // namespace

std::vector<std::string> Seeds() { return {Checkpoint(false), Checkpoint(true)}; }

}  // namespace diffsac::testing

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace diffsac::testing;
  const std::string path = WriteScratch("fuzz.safetensors", {reinterpret_cast<const char*>(data), size});
  Parses({path}, [&] { ReadTensors(path); });
  Parses({path}, [&] {
    const diffsac::TrainedConfig trained = diffsac::ReadTrainedConfig(path);
    diffsac::LoadDiffsac(trained, diffsac::NetworkEngine::kAuto, "cpu");
  });
  return 0;
}
