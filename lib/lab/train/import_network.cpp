#include "lab/train/import_network.h"

#include <torch/torch.h>

#include "diffsac/core/logging.h"
#include "diffsac/core/safetensors.h"
#include "diffsac/core/status.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/run_directory.h"
#include "lab/config/yaml.h"
#include "lab/options/config.h"
#include "lab/torch/checkpoint.h"
#include "lab/torch/denoiser.h"
#include "lab/torch/network_tensors.h"
#include "lab/train/learner.h"
#include "lab/train/training_folder.h"

namespace diffsac {
namespace {

void CheckPurpose(const SafetensorsFile& file, const TrainConfig& options) {
  const std::string &method = file.Text("method"), &task = file.Text("task");
  if (method != options.method)
    throw Error(file.path() + ": weights of method " + Shown(method) + ", the configuration is of '" + options.method +
                "'");
  if (task != ToString(options.task))
    throw Error(file.path() + ": weights for task " + Shown(task) + ", the configuration's is '" +
                ToString(options.task) + "'");
}

}  // namespace

void ImportNetwork(const TrainRequest& request, const std::string& path) {
  const TrainConfig& options = request.options;
  SafetensorsFile file(path);
  CheckPurpose(file, options);
  const auto learner = MakeLearner(options, torch::kCPU, 1);
  auto& network = learner->network();
  ReadTensors(kNetworkTensors, network, network.parameters(), &file);
  const std::string resolved = WriteTrainConfig(options);
  TrainingFolder folder(request);
  folder.Begin(resolved);
  const std::string checkpoint = folder.Checkpoint("best.safetensors");
  const CheckpointInfo info{options.method,
                            ToString(options.task),
                            ToJson(ConfigFromYaml(resolved)),
                            GitRevision(),
                            0,
                            options.train.seed,
                            -1.0};
  SaveCheckpoint(checkpoint, info, network, ExponentialMovingAverage(network, options.train.ema_decay), nullptr);
  LogInfo(checkpoint + ": " + std::to_string(CountParameters(network)) + " parameters of " + path);
}

}  // namespace diffsac
