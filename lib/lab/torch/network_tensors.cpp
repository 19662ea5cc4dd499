#include "lab/torch/network_tensors.h"

#include <torch/torch.h>

#include <algorithm>
#include <memory>

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

constexpr const char* kMean = "optimizer.exp_avg.";
constexpr const char* kSquare = "optimizer.exp_avg_sq.";
constexpr const char* kStep = "optimizer.step.";
constexpr const char* kHint = "; the architecture differs from the configuration's";

void CheckNumber(const std::string& prefix, std::size_t expected, const SafetensorsFile& file) {
  const auto& tensors = file.tensors();
  const auto found =
      std::count_if(tensors.begin(), tensors.end(), [&](const auto& item) { return item.first.starts_with(prefix); });
  if (static_cast<std::size_t>(found) != expected)
    throw Error(file.path() + ": holds " + std::to_string(found) + " tensors '" + prefix + "*', expected " +
                std::to_string(expected) + kHint);
}

void CheckShape(const std::string& name, const std::vector<std::int64_t>& shape, const SafetensorsFile& file) {
  const auto found = file.tensors().find(name);
  if (found == file.tensors().end()) throw Error(file.path() + ": has no tensor '" + name + "'" + kHint);
  if (found->second.shape != shape)
    throw Error(file.path() + ": tensor '" + name + "' is " + ShapeText(found->second.shape) + ", expected " +
                ShapeText(shape) + kHint);
}

// Adam's state of a parameter, null before its first step.
const torch::optim::AdamParamState* StateOf(const torch::optim::Adam& optimizer, const torch::Tensor& parameter) {
  const auto found = optimizer.state().find(parameter.unsafeGetTensorImpl());
  if (found == optimizer.state().end()) return nullptr;
  return static_cast<const torch::optim::AdamParamState*>(found->second.get());
}

}  // namespace

void AddTensors(const std::string& prefix, const torch::nn::Module& network, const std::vector<torch::Tensor>& values,
                SafetensorsWriter* writer) {
  std::size_t index = 0;
  for (const auto& item : network.named_parameters()) {
    const auto value = values[index++].detach().to(torch::kCPU).contiguous();
    TORCH_CHECK(value.scalar_type() == torch::kFloat32, item.key(), ": a parameter that is not of 32-bit floats");
    const std::span<const float> numbers(value.data_ptr<float>(), static_cast<std::size_t>(value.numel()));
    writer->Add(prefix + item.key(), value.sizes().vec(), numbers);
  }
}

void ReadTensors(const std::string& prefix, const torch::nn::Module& network, const std::vector<torch::Tensor>& targets,
                 SafetensorsFile* file) {
  const torch::NoGradGuard no_grad;
  const auto parameters = network.named_parameters();
  for (const auto& item : parameters) CheckShape(prefix + item.key(), item.value().sizes().vec(), *file);
  CheckNumber(prefix, parameters.size(), *file);
  std::size_t index = 0;
  for (const auto& item : parameters) {
    const auto value = torch::empty(item.value().sizes(), torch::kFloat32);
    const std::span<float> numbers(value.data_ptr<float>(), static_cast<std::size_t>(value.numel()));
    file->Read(prefix + item.key(), value.sizes().vec(), numbers);
    targets[index++].copy_(value);
  }
}

// A parameter without a step is what Adam makes of it in its first: zeros.
void AddOptimizer(const torch::nn::Module& network, const torch::optim::Adam& optimizer, SafetensorsWriter* writer) {
  std::vector<torch::Tensor> means, squares;
  for (const auto& item : network.named_parameters()) {
    const auto* state = StateOf(optimizer, item.value());
    means.push_back(state != nullptr ? state->exp_avg() : torch::zeros_like(item.value()));
    squares.push_back(state != nullptr ? state->exp_avg_sq() : torch::zeros_like(item.value()));
    const std::int64_t step = state != nullptr ? state->step() : 0;
    writer->Add(kStep + item.key(), {}, std::span<const std::int64_t>(&step, 1));
  }
  AddTensors(kMean, network, means, writer);
  AddTensors(kSquare, network, squares, writer);
}

void ReadOptimizer(const torch::nn::Module& network, torch::optim::Adam* optimizer, SafetensorsFile* file) {
  std::vector<torch::Tensor> means, squares;
  for (const auto& parameter : network.parameters()) {
    means.push_back(torch::zeros_like(parameter));
    squares.push_back(torch::zeros_like(parameter));
  }
  ReadTensors(kMean, network, means, file);
  ReadTensors(kSquare, network, squares, file);
  CheckNumber(kStep, means.size(), *file);
  std::size_t index = 0;
  for (const auto& item : network.named_parameters()) {
    std::int64_t step = 0;
    file->Read(kStep + item.key(), {}, std::span(&step, 1));
    if (step < 0) throw Error(file->path() + ": '" + kStep + item.key() + "' is negative");
    auto state = std::make_unique<torch::optim::AdamParamState>();
    state->step(step);
    state->exp_avg(means[index]);
    state->exp_avg_sq(squares[index]);
    optimizer->state()[item.value().unsafeGetTensorImpl()] = std::move(state);
    ++index;
  }
}

}  // namespace diffsac
