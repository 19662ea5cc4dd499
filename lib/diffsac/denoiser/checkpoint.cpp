#include "diffsac/denoiser/checkpoint.h"

#include <torch/torch.h>

#include <filesystem>
#include <sstream>

#include "diffsac/core/files.h"
#include "diffsac/core/run_directory.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

constexpr const char* kFormat = "diffsac-checkpoint";
constexpr std::int64_t kVersion = 1;

using torch::serialize::InputArchive;
using torch::serialize::OutputArchive;

// Dots in a name would be read as nested modules by the archive's pickler.
std::string ArchiveKey(std::string name) {
  for (char& c : name)
    if (c == '.') c = '/';
  return name;
}

InputArchive Open(const std::string& path) {
  if (!std::filesystem::exists(path)) throw Error(path + ": no such checkpoint");
  if (!std::filesystem::is_regular_file(path)) throw Error(path + ": not a file; expected a checkpoint");
  InputArchive archive;
  try {
    archive.load_from(path);
  } catch (const std::exception&) {
    throw Error(path + ": not a readable checkpoint (truncated, empty or of another program)");
  }
  return archive;
}

template <class T, class Convert>
T Read(InputArchive& archive, const std::string& path, const char* key, Convert convert) {
  c10::IValue value;
  if (!archive.try_read(key, value))
    throw Error(path + ": not a DiffSAC checkpoint (it has no '" + std::string(key) + "')");
  return convert(value);
}

CheckpointInfo ReadInfo(InputArchive& archive, const std::string& path) {
  const auto text = [](const c10::IValue& v) { return v.toStringRef(); };
  const auto number = [](const c10::IValue& v) { return v.toInt(); };
  if (Read<std::string>(archive, path, "format", text) != kFormat) throw Error(path + ": not a DiffSAC checkpoint");
  const auto version = Read<std::int64_t>(archive, path, "version", number);
  if (version != kVersion)
    throw Error(path + ": checkpoint version " + std::to_string(version) + ", this program reads version " +
                std::to_string(kVersion));
  CheckpointInfo info;
  info.config = Read<std::string>(archive, path, "config", text);
  info.git_revision = Read<std::string>(archive, path, "git_revision", text);
  info.iteration = Read<std::int64_t>(archive, path, "iteration", number);
  info.seed = static_cast<std::uint64_t>(Read<std::int64_t>(archive, path, "seed", number));
  info.best_validation =
      Read<double>(archive, path, "best_validation", [](const c10::IValue& v) { return v.toDouble(); });
  return info;
}

std::string ShapeText(const torch::Tensor& tensor) {
  std::string text = "[";
  for (std::int64_t i = 0; i < tensor.dim(); ++i) text += (i ? ", " : "") + std::to_string(tensor.size(i));
  return text + "]";
}

void ReadTensors(InputArchive& archive, const std::string& path, const char* group, const torch::nn::Module& network,
                 const std::vector<torch::Tensor>& targets) {
  torch::NoGradGuard no_grad;
  InputArchive nested;
  if (!archive.try_read(group, nested)) throw Error(path + ": checkpoint without '" + std::string(group) + "'");
  const auto named = network.named_parameters();
  if (nested.keys().size() != named.size())
    throw Error(path + ": holds a network of " + std::to_string(nested.keys().size()) + " weights, expected " +
                std::to_string(named.size()) + "; the architecture differs from the configuration's");
  std::size_t index = 0;
  for (const auto& item : named) {
    torch::Tensor value;
    if (!nested.try_read(ArchiveKey(item.key()), value))
      throw Error(path + ": has no weight '" + item.key() + "'; the architecture differs from the configuration's");
    if (value.sizes() != item.value().sizes())
      throw Error(path + ": weight '" + item.key() + "' is " + ShapeText(value) + ", expected " +
                  ShapeText(item.value()) + "; the architecture differs from the configuration's");
    targets[index++].copy_(value);
  }
}

void WriteTensors(OutputArchive& archive, const char* group, const torch::nn::Module& network,
                  const std::vector<torch::Tensor>& values) {
  OutputArchive nested(archive.compilation_unit());
  std::size_t index = 0;
  for (const auto& item : network.named_parameters())
    nested.write(ArchiveKey(item.key()), values[index++].detach().to(torch::kCPU));
  archive.write(group, nested);
}

}  // namespace

void SaveCheckpoint(const std::string& path, const CheckpointInfo& info, const torch::nn::Module& network,
                    const ExponentialMovingAverage& average, const torch::optim::Optimizer* optimizer) {
  OutputArchive archive;
  archive.write("format", c10::IValue(std::string(kFormat)));
  archive.write("version", c10::IValue(kVersion));
  archive.write("config", c10::IValue(info.config));
  archive.write("git_revision", c10::IValue(info.git_revision));
  archive.write("iteration", c10::IValue(info.iteration));
  archive.write("seed", c10::IValue(static_cast<std::int64_t>(info.seed)));
  archive.write("best_validation", c10::IValue(info.best_validation));
  archive.write("average_updates", c10::IValue(average.updates()));
  WriteTensors(archive, "weights", network, network.parameters());
  WriteTensors(archive, "average", network, average.shadow());
  if (optimizer != nullptr) {
    OutputArchive nested(archive.compilation_unit());
    optimizer->save(nested);
    archive.write("optimizer", nested);
  }
  // Into memory first: LibTorch's own file writer ends the program when the disk is full.
  std::ostringstream content;
  archive.save_to(content);
  WriteFileAtomically(path, content.view());
}

CheckpointInfo ReadCheckpointInfo(const std::string& path) {
  auto archive = Open(path);
  return ReadInfo(archive, path);
}

CheckpointInfo LoadCheckpoint(const std::string& path, torch::nn::Module& network, ExponentialMovingAverage* average,
                              torch::optim::Optimizer* optimizer) {
  auto archive = Open(path);
  const auto info = ReadInfo(archive, path);
  ReadTensors(archive, path, "weights", network, network.parameters());
  if (average != nullptr) {
    ReadTensors(archive, path, "average", network, average->shadow());
    average->set_updates(
        Read<std::int64_t>(archive, path, "average_updates", [](const c10::IValue& v) { return v.toInt(); }));
  }
  if (optimizer != nullptr) {
    InputArchive nested;
    if (!archive.try_read("optimizer", nested)) throw Error(path + ": holds no optimiser state; training cannot resume");
    optimizer->load(nested);
  }
  return info;
}

CheckpointInfo LoadAverage(const std::string& path, torch::nn::Module& network) {
  auto archive = Open(path);
  const auto info = ReadInfo(archive, path);
  ReadTensors(archive, path, "average", network, network.parameters());
  return info;
}

}  // namespace diffsac
