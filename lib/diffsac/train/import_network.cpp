#include "diffsac/train/import_network.h"

#include <torch/torch.h>

#include <filesystem>

#include "diffsac/core/logging.h"
#include "diffsac/core/run_directory.h"
#include "diffsac/core/status.h"
#include "diffsac/data/tasks.h"
#include "diffsac/data/weight_file.h"
#include "diffsac/denoiser/checkpoint.h"
#include "diffsac/denoiser/denoiser.h"
#include "diffsac/train/learner.h"

namespace diffsac {
namespace {

std::string TextOf(const std::vector<std::int64_t>& shape) {
  std::string text;
  for (std::int64_t size : shape) text += (text.empty() ? "" : "x") + std::to_string(size);
  return text;
}

void CheckPurpose(const WeightFile& file, const TrainConfig& options, const std::string& path) {
  if (file.method != options.method)
    throw Error(path + ": weights of method '" + file.method + "', the configuration is of '" + options.method + "'");
  if (file.task != ToString(options.task))
    throw Error(path + ": weights for task '" + file.task + "', the configuration's is '" + ToString(options.task) +
                "'");
}

void CopyWeights(const WeightFile& file, const std::string& path, torch::nn::Module* network) {
  const torch::NoGradGuard no_grad;
  const auto parameters = network->named_parameters();
  const std::string hint = "; the architecture differs from the configuration's";
  for (const auto& item : parameters) {
    const auto found = file.weights.find(item.key());
    if (found == file.weights.end()) throw Error(path + ": has no weight '" + item.key() + "'" + hint);
    const auto& [shape, values] = found->second;
    if (item.value().sizes() != shape)
      throw Error(path + ": weight '" + item.key() + "' is " + TextOf(shape) + ", expected " +
                  TextOf(item.value().sizes().vec()) + hint);
    item.value().copy_(torch::tensor(values).view(shape));
  }
  if (file.weights.size() != parameters.size())
    throw Error(path + ": holds " + std::to_string(file.weights.size()) + " weights, expected " +
                std::to_string(parameters.size()) + hint);
}

}  // namespace

void ImportNetwork(const TrainRequest& request, const std::string& path) {
  const TrainConfig& options = request.options;
  const WeightFile file = ReadWeightFile(path);
  CheckPurpose(file, options, path);
  const auto learner = MakeLearner(options, torch::kCPU, 1);
  CopyWeights(file, path, &learner->network());
  const std::string resolved = WriteTrainConfig(options);
  const RunDirectory directory(request.output, "diffsac_train", resolved, options.train.seed);
  std::filesystem::create_directories(directory.File("checkpoints"));
  const std::string checkpoint = directory.File("checkpoints/best.pt");
  SaveCheckpoint(checkpoint, {resolved, GitRevision(), 0, options.train.seed, -1.0}, learner->network(),
                 ExponentialMovingAverage(learner->network(), options.train.ema_decay), nullptr);
  LogInfo(checkpoint + ": " + std::to_string(CountParameters(learner->network())) + " parameters of " + path);
}

}  // namespace diffsac
