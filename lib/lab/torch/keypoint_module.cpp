// The module that programs load when they are asked for keypoints of a network (lab/images/network_keypoints.h).
#include <ATen/Parallel.h>
#include <torch/script.h>

#include <map>
#include <mutex>

#include "lab/images/network_keypoints.h"

namespace {

torch::jit::Module Loaded(const std::string& file) {
  static std::mutex mutex;
  static std::map<std::string, torch::jit::Module> modules;
  const std::lock_guard lock(mutex);
  const auto known = modules.find(file);
  if (known != modules.end()) return known->second;
  // Images are of many sizes: what is compiled for one is of no use to the next.
  torch::jit::setGraphExecutorOptimize(false);
  return modules.emplace(file, torch::jit::load(file, torch::kCPU)).first->second;
}

std::vector<float> Values(const torch::IValue& value) {
  const torch::Tensor values = value.toTensor().contiguous();
  return {values.data_ptr<float>(), values.data_ptr<float>() + values.numel()};
}

}  // namespace

extern "C" __attribute__((visibility("default"))) std::string DiffsacFindNetworkKeypoints(
    const std::string& model, const unsigned char* grey, int width, int height, int most,
    diffsac::NetworkKeypoints* found) {
  try {
    const torch::InferenceMode inference;
    at::set_num_threads(1);  // Of the calling thread; callers take an image a thread.
    const torch::Tensor image =
        torch::from_blob(const_cast<unsigned char*>(grey), {1, 1, height, width}, torch::kByte).to(torch::kFloat) / 255;
    const auto result = Loaded(model).forward({image, most}).toTuple();
    *found = {Values(result->elements()[0]), Values(result->elements()[1]), Values(result->elements()[2])};
    return "";
  } catch (const std::exception& e) {
    const std::string text = e.what();
    return text.substr(0, text.find('\n'));
  }
}
